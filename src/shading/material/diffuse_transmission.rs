//! Thin matte surfaces that let light through, such as leaves and paper.

use std::f32::consts::PI;

use serde::{Deserialize, Serialize};

use super::{Bsdf, MaterialModel, MaterialParameters, Opacity, Scatter};
use crate::checks::Location;
use crate::error::Result;
use crate::math::warp::cosine_hemisphere;
use crate::math::{Mask, Real, Row, Vector, dot, max};
use crate::sampler::{Dimension, Randoms};
use crate::shading::{Color, Interaction, TextureRef, TextureTables};

/// A thin matte surface: it reflects f = ρ/π on the side of the light, and transmits f = τ/π to the
/// other side (Pharr et al., *Physically Based Rendering*, 4th ed., section 9.2).
///
/// Samples choose a side in proportion to ρ and τ.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct DiffuseTransmission {
    /// Reflectance ρ, a colour with each channel in [0, 1] or a texture.
    pub reflectance: Color,
    /// Transmittance τ, a colour with each channel in [0, 1] or a texture.
    pub transmittance: Color,
    /// Factor of both, 0 to 1. Reflectance and transmittance times this factor must not exceed 1
    /// together in any channel. Where textures do, both are divided by their sum.
    #[serde(default = "one")]
    pub scale: f32,
    /// Name of a normal map: an image texture with linear encoding.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<TextureRef>,
    /// Holes in the surface, which must then be of triangles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opacity: Option<Opacity>,
}

fn one() -> f32 {
    1.0
}

impl DiffuseTransmission {
    /// Creates the material without a normal map.
    pub fn new(reflectance: impl Into<Color>, transmittance: impl Into<Color>) -> Self {
        let (reflectance, transmittance) = (reflectance.into(), transmittance.into());
        Self { reflectance, transmittance, scale: 1.0, normal: None, opacity: None }
    }
}

impl MaterialParameters for DiffuseTransmission {
    texture_methods!(reflectance, transmittance);

    fn transmits(&self) -> bool {
        true
    }

    fn check(&self, e: &Location<'_>) -> Result<()> {
        let scale = self.scale;
        self.reflectance.check(e, "reflectance")?;
        self.transmittance.check(e, "transmittance")?;
        e.check((0.0..=1.0).contains(&scale), "scale", "in [0, 1]", scale)?;
        let (Color::Rgb(reflected), Color::Rgb(transmitted)) =
            (&self.reflectance, &self.transmittance)
        else {
            return Ok(());
        };
        let sum: Vec<f32> =
            reflected.iter().zip(transmitted).map(|(r, t)| (r + t) * scale).collect();
        let ok = sum.iter().all(|&sum| sum <= 1.0);
        e.check(ok, "the sum of reflectance and transmittance", "at most 1 per channel", sum)
    }
}

impl MaterialModel for DiffuseTransmission {
    /// Rows of ρ and τ, and (`scale`, 0, 0, 0).
    type Entry = [Row; 3];
    type Bsdf<R: Real> = DiffuseTransmissionBsdf<R>;

    const TEXTURED: bool = true;
    const LARGE: bool = true;

    fn entry(&self, textures: &mut TextureTables) -> [Row; 3] {
        let scale = [self.scale.to_bits(), 0, 0, 0];
        [textures.row(&self.reflectance), textures.row(&self.transmittance), scale]
    }

    #[inline(always)]
    fn bsdf<R: Real>(
        table: &[[Row; 3]],
        index: R::Index,
        at: &Interaction<'_, R>,
    ) -> DiffuseTransmissionBsdf<R> {
        let color = |i: usize| at.color(R::gather(table, index, |entry: &[Row; 3]| &entry[i]));
        let (scale, _) = R::gather(table, index, |entry| &entry[2]);
        let (reflectance, transmittance) = (color(0) * scale[0], color(1) * scale[0]);
        let sum = reflectance + transmittance;
        let limit = |i: usize| R::ONE / max(sum[i], R::ONE);
        let limit = R::Vec3::new(limit(0), limit(1), limit(2));
        let (reflectance, transmittance) = (reflectance * limit, transmittance * limit);
        let weight = |color: R::Vec3| color[0] + color[1] + color[2];
        let (reflected, transmitted) = (weight(reflectance), weight(transmittance));
        let chance = reflected / max(reflected + transmitted, R::splat(1e-12));
        DiffuseTransmissionBsdf { normal: at.normals.shading, reflectance, transmittance, chance }
    }
}

pub(crate) struct DiffuseTransmissionBsdf<R: Real> {
    /// Normal on the side that was hit.
    normal: R::Vec3,
    reflectance: R::Vec3,
    transmittance: R::Vec3,
    /// Probability of sampling reflection.
    chance: R,
}

impl<R: Real> DiffuseTransmissionBsdf<R> {
    /// The colour and the density per cosine of light that is scattered to one side.
    #[inline(always)]
    fn side(&self, through: R::Mask) -> (R::Vec3, R) {
        let color = through.select(self.transmittance, self.reflectance);
        let chance = through.select(R::ONE - self.chance, self.chance);
        (color * R::splat(1.0 / PI), chance * (1.0 / PI))
    }
}

impl<R: Real> Bsdf<R> for DiffuseTransmissionBsdf<R> {
    const TRANSMITS: bool = true;

    #[inline(always)]
    fn albedo(&self) -> R::Vec3 {
        self.reflectance + self.transmittance
    }

    #[inline(always)]
    fn sample(&self, randoms: &Randoms<R>) -> Scatter<R> {
        let (u, v) = randoms.two(Dimension::SCATTER);
        let transmitted = randoms.one(Dimension::LOBE).ge(self.chance);
        let normal = transmitted.select(-self.normal, self.normal);
        let (direction, cos) = cosine_hemisphere(normal, u, v);
        let (f, density) = self.side(transmitted);
        let weight = f / density;
        let scattered = density.gt(R::ZERO);
        Scatter { direction, transmitted, weight, pdf: cos * density, scattered }
    }

    #[inline(always)]
    fn evaluate(&self, direction: R::Vec3) -> (R::Vec3, R) {
        let cos = dot(self.normal, direction);
        let (f, density) = self.side(cos.lt(R::ZERO));
        (f * cos.abs(), density * cos.abs())
    }
}
