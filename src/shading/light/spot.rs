//! Spotlights.

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::file::FreeLightModel;
use super::point::sample_point;
use super::sample::LightSample;
use super::tree::LightBounds;
use super::{Entry, LightModel, LightTables};
use crate::checks::{Location, MAX_RADIANCE};
use crate::error::Result;
use crate::geometry::Bounds;
use crate::math::precise::{one_minus_cos, sin_cos_degrees, unit};
use crate::math::{Mask, Real, Row, Vector, clamp, dot, row};
use crate::shading::luminance;

/// A point that emits light into a cone.
///
/// The intensity falls from the inner to the outer cone by a curve over the cosine of the angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spot {
    /// The position.
    pub position: [f32; 3],
    /// A point on the axis of the cone.
    pub look_at: [f32; 3],
    /// Radiant intensity (power per solid angle) in the inner cone in linear RGB, 0 to 1e30.
    pub intensity: [f32; 3],
    /// Angle between the axis and the rim of the outer cone in degrees, above 0 and at most 180.
    pub outer: f32,
    /// Angle between the axis and the rim of the inner cone in degrees, at least 0 and below `outer`.
    #[serde(default)]
    pub inner: f32,
    /// The curve between the cones.
    #[serde(default, skip_serializing_if = "Falloff::is_smooth")]
    pub falloff: Falloff,
}

/// How the intensity of a [`Spot`] falls: a function of t, which grows linearly in the cosine of the angle, from 0
/// at the outer cone to 1 at the inner one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Falloff {
    /// The smooth step t²(3 − 2t) of pbrt (Pharr et al., *Physically Based Rendering*, 4th ed., section 12.2.1).
    #[default]
    Smooth,
    /// The square t² of glTF (KHR_lights_punctual, "Inner and Outer Cone Angles").
    Square,
}

impl Falloff {
    // Serde passes a reference.
    #[expect(clippy::trivially_copy_pass_by_ref)]
    fn is_smooth(&self) -> bool {
        *self == Self::Smooth
    }
}

#[derive(Debug)]
pub(super) struct SpotLight {
    /// (position, 1 − cosine of the outer angle).
    position: Row,
    /// (axis, reciprocal of the difference of the cosines). The reciprocal is negative for [`Falloff::Square`].
    axis: Row,
}

impl Spot {
    fn axis(&self) -> DVec3 {
        unit(Vec3::from(self.look_at).as_dvec3() - Vec3::from(self.position).as_dvec3())
    }

    /// 1 − cos a = 2 sin² a/2, without the cancellation, for the inner and the outer angle.
    fn heights(&self) -> [f64; 2] {
        [self.inner, self.outer].map(|angle| one_minus_cos(angle.into()))
    }
}

impl FreeLightModel for Spot {
    fn check(&self, e: &Location<'_>) -> Result<()> {
        let Self { inner, outer, .. } = *self;
        e.point("position", self.position)?;
        e.point("look_at", self.look_at)?;
        if !self.axis().is_finite() {
            return Err(e.error("position and look_at must differ, or the cone has no axis"));
        }
        e.color("intensity", self.intensity, MAX_RADIANCE)?;
        e.check(outer > 0.0 && outer <= 180.0, "outer", "in (0, 180] degrees", outer)?;
        e.check((0.0..outer).contains(&inner), "inner", "at least 0 and below `outer`", inner)
    }

    fn radiance(&self) -> Vec3 {
        self.intensity.into()
    }

    fn inside(&self) -> Option<LightBounds> {
        let [inner, outer] = self.heights();
        // The cone whose normals, spread by 90°, just reach the outer angle.
        let wide = f64::from(self.outer) - 90.0;
        let luminance = luminance(self.radiance());
        Some(LightBounds {
            bounds: Bounds::of([self.position.into()]),
            axis: self.axis(),
            cos: if wide > 0.0 { sin_cos_degrees(wide).1 } else { 1.0 },
            two_sided: false,
            power: match self.falloff {
                // The smooth step is 1/2 on average, the square 1/3.
                Falloff::Smooth => luminance * (inner + outer),
                Falloff::Square => luminance * (4.0 * inner + 2.0 * outer) / 3.0,
            },
        })
    }

    fn add_to(&self, tables: &mut LightTables) -> Entry {
        let [inner, outer] = self.heights();
        let slope = (1.0 / (outer - inner)) as f32;
        let signed = if self.falloff == Falloff::Smooth { slope } else { -slope };
        tables.push(SpotLight {
            position: row(self.position.into(), outer as f32),
            axis: row(self.axis().as_vec3(), signed),
        })
    }
}

impl LightModel for SpotLight {
    const UNSEEN: bool = true;

    #[inline(never)]
    fn sample<R: Real>(
        table: &[Self],
        index: R::Index,
        from: R::Vec3,
        _: R,
        _: (R, R),
    ) -> LightSample<R> {
        let (position, outer) = R::gather(table, index, |light| &light.position);
        let (axis, slope) = R::gather(table, index, |light| &light.axis);
        let sample = sample_point(position, from);
        // 1 − cosine of the angle to the axis, for unit vectors.
        let off = sample.direction + axis;
        let x = clamp((outer - dot(off, off) * 0.5) * slope.abs(), R::ZERO, R::ONE);
        let smooth = R::splat(3.0) - x * 2.0;
        let step = x * x * slope.lt(R::ZERO).select(R::ONE, smooth);
        LightSample {
            tint: R::Vec3::gray(step),
            visible: sample.visible & step.gt(R::ZERO),
            ..sample
        }
    }
}
