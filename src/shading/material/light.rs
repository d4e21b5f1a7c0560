//! Surfaces that emit light (report, III.G).

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::{Bsdf, Emission, MaterialModel, MaterialParameters, Scatter, Sides};
use crate::checks::{Location, MAX_RADIANCE};
use crate::error::Result;
use crate::math::{Mask, Real, Vector};
use crate::sampler::Randoms;
use crate::shading::{Interaction, TextureTables};

/// A surface that emits light and absorbs all light that hits it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Light {
    /// Emitted radiance in linear RGB, 0 to 1e30.
    pub radiance: [f32; 3],
    /// The sides that emit light.
    #[serde(default)]
    pub sides: Sides,
}

impl MaterialParameters for Light {
    fn emission(&self) -> Option<Emission> {
        Some(Emission { radiance: Vec3::from(self.radiance), sides: self.sides })
    }

    fn check(&self, e: &Location<'_>) -> Result<()> {
        e.color("radiance", self.radiance, MAX_RADIANCE).map(|_| ())
    }
}

impl MaterialModel for Light {
    type Entry = ();
    type Bsdf<R: Real> = Black;

    const SCATTERS: bool = false;

    fn entry(&self, _: &mut TextureTables) {}

    #[inline(always)]
    fn bsdf<R: Real>(_: &[()], _: R::Index, _: &Interaction<'_, R>) -> Black {
        Black
    }
}

/// The BSDF of a surface that absorbs all light.
pub(crate) struct Black;

impl<R: Real> Bsdf<R> for Black {
    #[inline(always)]
    fn albedo(&self) -> R::Vec3 {
        R::Vec3::zero()
    }

    #[inline(always)]
    fn sample(&self, _: &Randoms<R>) -> Scatter<R> {
        Scatter {
            direction: R::Vec3::zero(),
            transmitted: R::Mask::NONE,
            weight: R::Vec3::zero(),
            pdf: R::ZERO,
            scattered: R::Mask::NONE,
        }
    }

    #[inline(always)]
    fn evaluate(&self, _: R::Vec3) -> (R::Vec3, R) {
        (R::Vec3::zero(), R::ZERO)
    }
}
