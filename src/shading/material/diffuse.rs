//! The report's ideal diffuse material (III.B).

use std::f32::consts::PI;

use serde::{Deserialize, Serialize};

use super::{Bsdf, MaterialModel, MaterialParameters, Scatter};
use crate::checks::Location;
use crate::error::Result;
use crate::math::warp::uniform_hemisphere;
use crate::math::{Mask, Real, Row, dot};
use crate::sampler::{Dimension, Randoms};
use crate::shading::{Color, Interaction, TextureRef, TextureTables};

/// A surface that scatters light uniformly over the hemisphere: f·cos θ = ρ/2π.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Diffuse {
    /// Albedo ρ, a colour with each channel in [0, 1] or a texture.
    pub albedo: Color,
}

impl MaterialParameters for Diffuse {
    fn textures(&mut self) -> Vec<&mut TextureRef> {
        self.albedo.reference().into_iter().collect()
    }

    fn check(&self, e: &Location<'_>) -> Result<()> {
        self.albedo.check(e, "albedo")
    }
}

impl MaterialModel for Diffuse {
    /// Row of the albedo ρ.
    type Entry = Row;
    type Bsdf<R: Real> = DiffuseBsdf<R>;

    const TEXTURED: bool = true;

    fn entry(&self, textures: &mut TextureTables) -> Row {
        textures.row(&self.albedo)
    }

    #[inline(always)]
    fn bsdf<R: Real>(table: &[Row], index: R::Index, at: &Interaction<'_, R>) -> DiffuseBsdf<R> {
        DiffuseBsdf {
            normal: at.normals.shading,
            albedo: at.color(R::gather(table, index, |row| row)),
        }
    }
}

pub(crate) struct DiffuseBsdf<R: Real> {
    /// Normal on the side that was hit.
    normal: R::Vec3,
    albedo: R::Vec3,
}

impl<R: Real> Bsdf<R> for DiffuseBsdf<R> {
    #[inline(always)]
    fn albedo(&self) -> R::Vec3 {
        self.albedo
    }

    #[inline(always)]
    fn sample(&self, randoms: &Randoms<R>) -> Scatter<R> {
        let (u, v) = randoms.two(Dimension::SCATTER);
        Scatter {
            direction: uniform_hemisphere(self.normal, u, v).0,
            transmitted: R::Mask::NONE,
            weight: self.albedo,
            pdf: R::splat(0.5 / PI),
            scattered: R::Mask::ALL,
        }
    }

    #[inline(always)]
    fn evaluate(&self, direction: R::Vec3) -> (R::Vec3, R) {
        let above = dot(self.normal, direction).gt(R::ZERO);
        let pdf = above.select(R::splat(0.5 / PI), R::ZERO);
        (self.albedo * pdf, pdf)
    }
}
