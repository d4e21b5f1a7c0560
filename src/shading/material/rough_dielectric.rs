//! Frosted glass, whose GGX microfacets reflect and refract (Walter et al. 2007).

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::{Bsdf, MaterialModel, MaterialParameters, Opacity, Scatter};
use crate::checks::Location;
use crate::error::Result;
use crate::math::microfacet::Ggx;
use crate::math::{Frame, Mask, Real, Row, Vector, dot, fresnel, max, min, normalize};
use crate::sampler::{Dimension, Randoms};
use crate::shading::{Interaction, Number, TextureRef, TextureTables};

/// Frosted glass in air, with GGX microfacets and the exact Fresnel equations.
///
/// Each visible microfacet is a smooth piece of glass. As in smooth glass, paths carry basic
/// radiance. Masking and shadowing on opposite sides are treated as independent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct RoughDielectric {
    /// Index of refraction relative to air, 0.01 to 0.99 or 1.01 to 100.
    pub ior: f32,
    /// GGX roughness α, 0.001 to 1, or a texture, which counts as at least 0.001.
    pub alpha: Number,
    /// Name of a normal map: an image texture with linear encoding.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<TextureRef>,
    /// Holes in the surface, which must then be of triangles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opacity: Option<Opacity>,
}

impl RoughDielectric {
    /// Creates the material without a normal map and without holes.
    pub fn new(ior: f32, alpha: impl Into<Number>) -> Self {
        Self { ior, alpha: alpha.into(), normal: None, opacity: None }
    }
}

/// Smallest α.
const LEAST_ALPHA: f32 = 0.001;

impl MaterialParameters for RoughDielectric {
    texture_methods!(alpha);

    fn transmits(&self) -> bool {
        true
    }

    fn absorption(&self) -> Option<Vec3> {
        Some(Vec3::ZERO)
    }

    fn check(&self, e: &Location<'_>) -> Result<()> {
        let Self { ior, alpha, .. } = self;
        // As the index approaches 1, all microfacets transmit light without deflecting it.
        let ok = (0.01..=0.99).contains(ior) || (1.01..=100.0).contains(ior);
        e.check(ok, "ior", "in [0.01, 0.99] or [1.01, 100]", ior)?;
        alpha.check(e, "alpha", LEAST_ALPHA..=1.0)
    }
}

impl MaterialModel for RoughDielectric {
    /// The words of α, and the index of refraction.
    type Entry = Row;
    type Bsdf<R: Real> = RoughDielectricBsdf<R>;

    const GLOSSY: bool = true;
    const TEXTURED: bool = true;

    fn entry(&self, textures: &mut TextureTables) -> Row {
        let [alpha, code] = textures.number(&self.alpha);
        [alpha, code, self.ior.to_bits(), 0]
    }

    #[inline(always)]
    fn bsdf<R: Real>(
        table: &[Row],
        index: R::Index,
        at: &Interaction<'_, R>,
    ) -> RoughDielectricBsdf<R> {
        let (row, _) = R::gather(table, index, |row| row);
        let alpha = max(at.number([row[0], row[1]]), R::splat(LEAST_ALPHA));
        let frame = Frame::new(at.normals.mirror);
        let wo = frame.local(-at.ray.direction);
        let eta = at.front.select(row[2], R::ONE / row[2]);
        RoughDielectricBsdf { frame, wo, eta, ggx: Ggx::new(alpha) }
    }
}

pub(crate) struct RoughDielectricBsdf<R: Real> {
    frame: Frame<R::Vec3>,
    /// Direction back along the path, in the local frame.
    wo: R::Vec3,
    /// Index of refraction beyond the surface divided by the index before it.
    eta: R,
    ggx: Ggx<R>,
}

impl<R: Real> RoughDielectricBsdf<R> {
    /// Returns f·|cos θi|/pdf and the pdf of direction `wi` for microfacets with normal `m`, and
    /// whether such microfacets can scatter light into `wi`.
    #[inline(always)]
    fn weight_and_pdf(&self, wi: R::Vec3, m: R::Vec3) -> (R, R, R::Mask) {
        let (before, after) = (min(dot(self.wo, m), R::ONE), dot(wi, m));
        let (lo, li) = (self.ggx.length(self.wo), self.ggx.length(wi));
        let reflectance = fresnel::dielectric(before, self.eta);
        // Density of m among the normals visible from wo: 2 D max(0, wo·m)/(z + length).
        let normals = self.ggx.density(m) * 2.0 * before / (self.wo[2] + lo);
        let reflection = (
            wi[2] * (self.wo[2] + lo) / (self.wo[2] * li + wi[2] * lo),
            reflectance * normals / (before * 4.0),
        );
        // The weight of refraction is the shadowing alone: 2 |z|/(|z| + length).
        let sum = before + self.eta * after;
        let jacobian = self.eta * self.eta * after.abs() / (sum * sum);
        let refraction = (wi[2] * 2.0 / (wi[2] - li), (R::ONE - reflectance) * normals * jacobian);
        let above = wi[2].gt(R::ZERO);
        let weight = above.select(reflection.0, refraction.0);
        let pdf = above.select(reflection.1, refraction.1);
        let through = above.select(after.gt(R::ZERO), after.lt(R::ZERO));
        (weight, pdf, through & before.gt(R::ZERO) & pdf.gt(R::ZERO))
    }
}

impl<R: Real> Bsdf<R> for RoughDielectricBsdf<R> {
    const TRANSMITS: bool = true;

    #[inline(always)]
    fn albedo(&self) -> R::Vec3 {
        R::Vec3::gray(R::ONE)
    }

    #[inline(always)]
    fn sample(&self, randoms: &Randoms<R>) -> Scatter<R> {
        let (u, v) = randoms.two(Dimension::SCATTER);
        let m = self.ggx.sample(self.wo, R::ONE, u, v);
        let cos = min(dot(self.wo, m), R::ONE);
        let reflected = randoms.one(Dimension::LOBE).lt(fresnel::dielectric(cos, self.eta));
        let reflection = m * (cos * 2.0) - self.wo;
        let sin2 = (R::ONE - cos * cos) / (self.eta * self.eta);
        let along = cos / self.eta - max(R::ZERO, R::ONE - sin2).sqrt();
        let refraction = m * along - self.wo / self.eta;
        let wi = normalize(reflected.select(reflection, refraction));
        let (weight, pdf, possible) = self.weight_and_pdf(wi, m);
        // A path is lost if its microfacet sends it to the wrong side of the surface.
        let right_side = !(wi[2].gt(R::ZERO) ^ reflected);
        Scatter {
            direction: self.frame.world(wi),
            transmitted: !reflected,
            weight: R::Vec3::gray(weight),
            pdf,
            scattered: possible & right_side,
        }
    }

    #[inline(always)]
    fn evaluate(&self, direction: R::Vec3) -> (R::Vec3, R) {
        let wi = self.frame.local(direction);
        let half = self.wo + wi * wi[2].gt(R::ZERO).select(R::ONE, self.eta);
        let half = half[2].lt(R::ZERO).select(-half, half);
        let (weight, pdf, possible) = self.weight_and_pdf(wi, normalize(half));
        let f_cos = possible.select(weight * pdf, R::ZERO);
        (R::Vec3::gray(f_cos), possible.select(pdf, R::ZERO))
    }
}
