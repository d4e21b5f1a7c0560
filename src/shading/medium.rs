//! Homogeneous media with isotropic scattering.

use std::f32::consts::PI;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::material::{Bsdf, Scatter};
use crate::checks::{Location, MAX_COORDINATE};
use crate::error::Result;
use crate::geometry::{Ray, Volume};
use crate::math::powers::{exp, ln};
use crate::math::precise::{rotate, turns};
use crate::math::warp::uniform_sphere;
use crate::math::{Mask, Real, Row, Word, max, min, row};
use crate::sampler::{Dimension, Randoms};

/// A medium in a volume with an invisible boundary, as written in a scene file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
#[non_exhaustive]
pub enum MediumFile {
    /// A medium that fills a ball.
    #[serde(rename = "sphere")]
    Ball {
        /// Centre.
        center: [f32; 3],
        /// Radius, above 0 and at most 1e9.
        radius: f32,
        /// Extinction coefficient: collisions per unit of length, above 0 and at most 1e6.
        density: f32,
        /// The share of light that a collision scatters instead of absorbing it: linear RGB, each
        /// channel in [0, 1].
        albedo: [f32; 3],
    },
    /// A medium that fills a box.
    Box {
        /// Lower corner before rotation.
        min: [f32; 3],
        /// Upper corner before rotation.
        max: [f32; 3],
        /// Right-handed rotation in degrees about x, then y, then z, through the middle of the box.
        #[serde(default)]
        rotation: [f32; 3],
        /// Extinction coefficient: collisions per unit of length, above 0 and at most 1e6.
        density: f32,
        /// The share of light that a collision scatters instead of absorbing it: linear RGB, each
        /// channel in [0, 1].
        albedo: [f32; 3],
    },
}

/// A checked medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Medium {
    /// The volume that it fills.
    pub volume: Volume,
    /// Extinction coefficient: collisions per unit of length.
    pub density: f32,
    /// The share of light that a collision scatters instead of absorbing it.
    pub albedo: Vec3,
}

impl Medium {
    /// Checks a medium of a scene file.
    pub(crate) fn new(e: &Location<'_>, file: &MediumFile) -> Result<Self> {
        let (volume, density, albedo) = match file {
            MediumFile::Ball { center, radius, density, albedo } => {
                let center = e.point("center", *center)?;
                let ok = *radius > 0.0 && *radius <= MAX_COORDINATE;
                e.check(ok, "radius", "above 0 and at most 1e9", radius)?;
                (Volume::Ball { center, radius: *radius }, density, albedo)
            }
            MediumFile::Box { min, max, rotation, density, albedo } => {
                e.bounds(*min, *max)?;
                e.rotation(*rotation)?;
                (turned_box(*min, *max, *rotation), density, albedo)
            }
        };
        let ok = *density > 0.0 && *density <= 1e6;
        e.check(ok, "density", "above 0 and at most 1e6", density)?;
        Ok(Self { volume, density: *density, albedo: e.color("albedo", *albedo, 1.0)? })
    }
}

/// The box from `min` to `max`, rotated about its middle in the same way as the box primitive.
fn turned_box(min: [f32; 3], max: [f32; 3], rotation: [f32; 3]) -> Volume {
    let at = |f: fn(f64, f64) -> f64| {
        let both = |axis: usize| f(f64::from(min[axis]), f64::from(max[axis])) as f32;
        Vec3::new(both(0), both(1), both(2))
    };
    let turns = turns(rotation);
    let axis = |axis: usize| {
        let mut unit = [0.0; 3];
        unit[axis] = 1.0;
        Vec3::from_array(rotate(unit, turns).map(|c| c as f32))
    };
    Volume::Box {
        center: at(|min, max| (min + max) * 0.5),
        axes: [axis(0), axis(1), axis(2)],
        half: at(|min, max| (max - min) * 0.5),
    }
}

/// The media of a scene, which do not overlap.
#[derive(Debug)]
pub(crate) struct Media {
    media: Vec<Medium>,
    /// The albedo of each medium.
    rows: Vec<Row>,
    /// The number of the first medium. Media are numbered after the primitives.
    first: u32,
}

impl Media {
    pub(crate) fn new(media: &[Medium], first: u32) -> Self {
        let rows = media.iter().map(|medium| row(medium.albedo, 0.0)).collect();
        Self { media: media.to_vec(), rows, first }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.media.is_empty()
    }

    /// Returns the distance of the first collision along `ray` and the number of its medium. If
    /// there is no collision before the given hit, returns the distance and primitive of the hit.
    /// Since media do not overlap, a collision is sampled in each medium independently, and the
    /// nearest one counts.
    #[inline(always)]
    pub(crate) fn collide<R: Real>(
        &self,
        ray: &Ray<R>,
        (mut end, mut primitive): (R, R::Word),
        randoms: &Randoms<R>,
    ) -> (R, R::Word) {
        for (index, medium) in (0..).zip(&self.media) {
            let (near, far) = medium.volume.interval(ray);
            // The distance is exponentially distributed: it exceeds t with probability e^−σt.
            let chance = R::ONE - randoms.one(Dimension::medium(index));
            let t = near - ln(chance) / R::splat(medium.density);
            let collides = t.lt(min(far, end));
            end = collides.select(t, end);
            primitive = collides.select(R::Word::splat(self.first + index), primitive);
        }
        (end, primitive)
    }

    /// The share of light that travels along `ray` up to distance `end` without a collision.
    #[inline(always)]
    pub(crate) fn transmittance<R: Real>(&self, ray: &Ray<R>, end: R) -> R {
        let mut depth = R::ZERO;
        for medium in &self.media {
            let (near, far) = medium.volume.interval(ray);
            depth = depth + max(R::ZERO, min(far, end) - near) * medium.density;
        }
        exp(-depth)
    }

    /// The phase function of the medium with number `primitive`.
    #[inline(always)]
    pub(crate) fn phase<R: Real>(&self, primitive: R::Word) -> Isotropic<R> {
        let medium = primitive.wrapping_sub(R::Word::splat(self.first));
        let (albedo, _) = R::gather(&self.rows, R::index(medium, self.rows.len()), |row| row);
        Isotropic { albedo }
    }
}

/// The isotropic phase function. Unlike a surface's BSDF, it has no cosine factor.
pub(crate) struct Isotropic<R: Real> {
    pub(crate) albedo: R::Vec3,
}

impl<R: Real> Bsdf<R> for Isotropic<R> {
    #[inline(always)]
    fn albedo(&self) -> R::Vec3 {
        self.albedo
    }

    #[inline(always)]
    fn sample(&self, randoms: &Randoms<R>) -> Scatter<R> {
        let (u, v) = randoms.two(Dimension::SCATTER);
        Scatter {
            direction: uniform_sphere(u, v),
            transmitted: R::Mask::NONE,
            weight: self.albedo,
            pdf: R::splat(0.25 / PI),
            scattered: R::Mask::ALL,
        }
    }

    #[inline(always)]
    fn evaluate(&self, _: R::Vec3) -> (R::Vec3, R) {
        let pdf = R::splat(0.25 / PI);
        (self.albedo * pdf, pdf)
    }
}
