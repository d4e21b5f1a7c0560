//! Lights of one point.

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::file::FreeLightModel;
use super::sample::LightSample;
use super::tree::LightBounds;
use super::{Entry, LightModel, LightTables};
use crate::checks::{Location, MAX_RADIANCE};
use crate::error::Result;
use crate::geometry::Bounds;
use crate::math::{Mask, Real, Row, Vector, dot, row};
use crate::shading::luminance;

/// A point that emits light uniformly in all directions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// The position.
    pub position: [f32; 3],
    /// Radiant intensity (power per solid angle) in linear RGB, 0 to 1e30.
    pub intensity: [f32; 3],
}

#[derive(Debug)]
pub(super) struct PointLight {
    /// (position, 0).
    position: Row,
}

impl FreeLightModel for Point {
    fn check(&self, e: &Location<'_>) -> Result<()> {
        e.point("position", self.position)?;
        e.color("intensity", self.intensity, MAX_RADIANCE).map(|_| ())
    }

    fn radiance(&self) -> Vec3 {
        self.intensity.into()
    }

    fn inside(&self) -> Option<LightBounds> {
        Some(LightBounds {
            bounds: Bounds::of([self.position.into()]),
            axis: DVec3::Z,
            cos: -1.0,
            two_sided: false,
            power: 4.0 * luminance(self.radiance()),
        })
    }

    fn add_to(&self, tables: &mut LightTables) -> Entry {
        tables.push(PointLight { position: row(self.position.into(), 0.0) })
    }
}

/// The sample of a point at `position`. Its density is chosen so that intensity divided by density
/// is the irradiance of a surface that faces the point.
#[inline(always)]
pub(super) fn sample_point<R: Real>(position: R::Vec3, from: R::Vec3) -> LightSample<R> {
    let to = position - from;
    let square = dot(to, to);
    let distance = square.sqrt();
    LightSample {
        direction: to / distance,
        distance,
        pdf: square,
        tint: R::Vec3::gray(R::ONE),
        front: R::Mask::ALL,
        visible: square.gt(R::ZERO) & square.lt(R::INFINITY),
    }
}

impl LightModel for PointLight {
    const UNSEEN: bool = true;

    #[inline(never)]
    fn sample<R: Real>(
        table: &[Self],
        index: R::Index,
        from: R::Vec3,
        _: R,
        _: (R, R),
    ) -> LightSample<R> {
        sample_point(R::gather(table, index, |light| &light.position).0, from)
    }
}
