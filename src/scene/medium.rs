//! Homogeneous media that scatter light to all sides alike.

use std::f32::consts::PI;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::material::{Bsdf, Scatter};
use super::place::{Element, MAX_COORDINATE, angles};
use crate::error::Result;
use crate::geometry::{Ray, Volume};
use crate::math::powers::{exp, ln};
use crate::math::precise::rotate;
use crate::math::warp::uniform_sphere;
use crate::math::{Mask, Real, Row, Word, max, min, row};
use crate::sampler::{Dimension, Randoms};

/// A medium in a volume whose boundary is invisible, as a scene file has it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
#[non_exhaustive]
pub enum MediumFile {
    /// In a ball.
    #[serde(rename = "sphere")]
    Ball {
        /// Centre.
        center: [f32; 3],
        /// Radius, above 0 to 1e9.
        radius: f32,
        /// Extinction coefficient: collisions per unit of length, above 0 to 1e6.
        density: f32,
        /// The share of light that is scattered, not absorbed: linear RGB, each in [0, 1].
        albedo: [f32; 3],
    },
    /// In a box.
    Box {
        /// Lower corner before rotation.
        min: [f32; 3],
        /// Upper corner before rotation.
        max: [f32; 3],
        /// Right-handed angles about x, then y, then z, through the middle of the box.
        #[serde(default)]
        rotation: [f32; 3],
        /// Extinction coefficient: collisions per unit of length, above 0 to 1e6.
        density: f32,
        /// The share of light that is scattered, not absorbed: linear RGB, each in [0, 1].
        albedo: [f32; 3],
    },
}

/// A medium.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Medium {
    /// What it fills.
    pub volume: Volume,
    /// Extinction coefficient: collisions per unit of length.
    pub density: f32,
    /// The share of the light that a collision does not absorb.
    pub albedo: Vec3,
}

impl Medium {
    /// Checks what a file says of one.
    pub(super) fn new(e: &Element<'_>, file: &MediumFile) -> Result<Self> {
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

/// The box from `min` to `max`, turned about its middle as the primitive is.
fn turned_box(min: [f32; 3], max: [f32; 3], rotation: [f32; 3]) -> Volume {
    let at = |f: fn(f64, f64) -> f64| {
        let both = |axis: usize| f(f64::from(min[axis]), f64::from(max[axis])) as f32;
        Vec3::new(both(0), both(1), both(2))
    };
    let turns = angles(rotation);
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

/// The media of a scene, none of which overlaps another.
#[derive(Debug)]
pub(crate) struct Media {
    media: Vec<Medium>,
    /// Albedo.
    rows: Vec<Row>,
    /// The number of the first among primitives.
    first: u32,
}

impl Media {
    pub(super) fn new(media: &[Medium], first: u32) -> Self {
        let rows = media.iter().map(|medium| row(medium.albedo, 0.0)).collect();
        Self { media: media.to_vec(), rows, first }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.media.is_empty()
    }

    /// The first collision along `ray` before its hit, or the hit: distance, and primitive or medium.
    /// Media do not overlap, and so each has its own chance: the nearest of their collisions is the
    /// first.
    #[inline(always)]
    pub(crate) fn collide<R: Real>(
        &self,
        ray: &Ray<R>,
        (mut end, mut primitive): (R, R::Word),
        randoms: &Randoms<R>,
    ) -> (R, R::Word) {
        for (index, medium) in (0..).zip(&self.media) {
            let (near, far) = medium.volume.interval(ray);
            // An exponential distance: e^−σt of the light gets farther than t.
            let chance = R::ONE - randoms.one(Dimension::medium(index));
            let t = near - ln(chance) / R::splat(medium.density);
            let collides = t.lt(min(far, end));
            end = collides.select(t, end);
            primitive = collides.select(R::Word::splat(self.first + index), primitive);
        }
        (end, primitive)
    }

    /// The share of light that crosses `ray` up to distance `end` without a collision.
    #[inline(always)]
    pub(crate) fn transmittance<R: Real>(&self, ray: &Ray<R>, end: R) -> R {
        let mut depth = R::ZERO;
        for medium in &self.media {
            let (near, far) = medium.volume.interval(ray);
            depth = depth + max(R::ZERO, min(far, end) - near) * medium.density;
        }
        exp(-depth)
    }

    /// How the medium with number `primitive` scatters light.
    #[inline(always)]
    pub(crate) fn phase<R: Real>(&self, primitive: R::Word) -> Isotropic<R> {
        let medium = primitive.wrapping_sub(R::Word::splat(self.first));
        let (albedo, _) = R::gather(&self.rows, R::index(medium, self.rows.len()), |row| row);
        Isotropic { albedo }
    }
}

/// The isotropic phase function. There is no surface, and so no cosine.
pub(crate) struct Isotropic<R: Real> {
    pub(crate) albedo: R::Vec3,
}

impl<R: Real> Bsdf<R> for Isotropic<R> {
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
