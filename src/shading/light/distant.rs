//! Lights so far away that their rays are parallel, such as the sun.

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::file::FreeLightModel;
use super::sample::LightSample;
use super::tree::LightBounds;
use super::{Entry, LightModel, LightTables};
use crate::checks::{Location, MAX_RADIANCE};
use crate::error::Result;
use crate::math::precise::{one_minus_cos, unit};
use crate::math::warp::uniform_cone;
use crate::math::{Mask, Real, Row, Vector, row};

/// Light from outside the scene that comes from a disk in the sky, or from a single direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Distant {
    /// The direction in which the light travels, of any length but 0.
    pub direction: [f32; 3],
    /// Irradiance of a surface that faces the light, in linear RGB, 0 to 1e30.
    pub irradiance: [f32; 3],
    /// Angle across the disk in degrees, at least 0 and below 180. The sun has 0.53.
    #[serde(default)]
    pub angle: f32,
}

#[derive(Debug)]
pub(super) struct DistantLight {
    /// (direction to the middle of the disk, 1 − cosine of its angular radius).
    middle: Row,
}

impl Distant {
    /// Unit vector to the middle of the disk.
    fn toward(&self) -> DVec3 {
        -unit(Vec3::from(self.direction).as_dvec3())
    }

    /// 1 − cosine of the angular radius of the disk.
    fn height(&self) -> f64 {
        one_minus_cos(f64::from(self.angle) / 2.0)
    }
}

impl FreeLightModel for Distant {
    fn check(&self, e: &Location<'_>) -> Result<()> {
        e.point("direction", self.direction)?;
        if !self.toward().is_finite() {
            return Err(e.error("direction must not be zero"));
        }
        e.color("irradiance", self.irradiance, MAX_RADIANCE)?;
        e.check((0.0..180.0).contains(&self.angle), "angle", "in [0, 180) degrees", self.angle)
    }

    /// A disk of uniform radiance L and angular radius a causes the irradiance π L sin² a, and has
    /// the solid angle 2π (1 − cos a). Samples have the density 1, so that this radiance stands for
    /// L times the solid angle.
    fn radiance(&self) -> Vec3 {
        Vec3::from(self.irradiance) * (2.0 / (2.0 - self.height())) as f32
    }

    fn inside(&self) -> Option<LightBounds> {
        None
    }

    fn add_to(&self, tables: &mut LightTables) -> Entry {
        tables.push(DistantLight { middle: row(self.toward().as_vec3(), self.height() as f32) })
    }
}

impl LightModel for DistantLight {
    const UNSEEN: bool = true;

    #[inline(never)]
    fn sample<R: Real>(
        table: &[Self],
        index: R::Index,
        _: R::Vec3,
        _: R,
        (u, v): (R, R),
    ) -> LightSample<R> {
        let (middle, one_minus_cos) = R::gather(table, index, |light| &light.middle);
        LightSample {
            direction: uniform_cone(middle, one_minus_cos, u, v),
            distance: R::INFINITY,
            pdf: R::ONE,
            tint: R::Vec3::gray(R::ONE),
            front: R::Mask::ALL,
            visible: R::Mask::ALL,
        }
    }
}
