//! Matte surfaces that follow Lambert's law (report, III.C).

use std::f32::consts::PI;

use serde::{Deserialize, Serialize};

use super::{Bsdf, MaterialModel, MaterialParameters, Opacity, Scatter};
use crate::checks::Location;
use crate::error::Result;
use crate::math::warp::cosine_hemisphere;
use crate::math::{Mask, Real, Row, dot};
use crate::sampler::{Dimension, Randoms};
use crate::shading::{Color, Interaction, TextureRef, TextureTables};

/// A matte surface that follows Lambert's law: f = ρ/π, sampled in proportion to the cosine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Lambertian {
    /// Albedo ρ, a colour with each channel in [0, 1] or a texture.
    pub albedo: Color,
    /// Name of a normal map: an image texture with linear encoding.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<TextureRef>,
    /// Holes in the surface, which must then be of triangles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opacity: Option<Opacity>,
}

impl Lambertian {
    /// Creates the material without a normal map.
    pub fn new(albedo: impl Into<Color>) -> Self {
        Self { albedo: albedo.into(), normal: None, opacity: None }
    }
}

impl MaterialParameters for Lambertian {
    texture_methods!(albedo);

    fn check(&self, e: &Location<'_>) -> Result<()> {
        self.albedo.check(e, "albedo")
    }
}

impl MaterialModel for Lambertian {
    /// Row of the albedo ρ.
    type Entry = Row;
    type Bsdf<R: Real> = LambertianBsdf<R>;

    const TEXTURED: bool = true;

    fn entry(&self, textures: &mut TextureTables) -> Row {
        textures.row(&self.albedo)
    }

    #[inline(always)]
    fn bsdf<R: Real>(table: &[Row], index: R::Index, at: &Interaction<'_, R>) -> LambertianBsdf<R> {
        let albedo = at.color(R::gather(table, index, |row| row));
        LambertianBsdf { normal: at.normals.shading, albedo }
    }
}

pub(crate) struct LambertianBsdf<R: Real> {
    /// Normal on the side that was hit.
    normal: R::Vec3,
    albedo: R::Vec3,
}

impl<R: Real> Bsdf<R> for LambertianBsdf<R> {
    #[inline(always)]
    fn albedo(&self) -> R::Vec3 {
        self.albedo
    }

    #[inline(always)]
    fn sample(&self, randoms: &Randoms<R>) -> Scatter<R> {
        let (u, v) = randoms.two(Dimension::SCATTER);
        let (direction, cos) = cosine_hemisphere(self.normal, u, v);
        Scatter {
            direction,
            transmitted: R::Mask::NONE,
            weight: self.albedo,
            pdf: cos * (1.0 / PI),
            scattered: R::Mask::ALL,
        }
    }

    #[inline(always)]
    fn evaluate(&self, direction: R::Vec3) -> (R::Vec3, R) {
        let cos = dot(self.normal, direction);
        let pdf = cos.gt(R::ZERO).select(cos * (1.0 / PI), R::ZERO);
        (self.albedo * pdf, pdf)
    }
}
