//! Metals with a complex index of refraction, smooth or rough.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::{Bsdf, MaterialModel, MaterialParameters, Opacity, SPECULAR, Scatter};
use crate::checks::Location;
use crate::error::Result;
use crate::math::microfacet::Ggx;
use crate::math::{Frame, Mask, Real, Row, Vector, dot, fresnel, min, normalize, row};
use crate::sampler::{Dimension, Randoms};
use crate::shading::{Interaction, Number, TextureRef, TextureTables};

/// A metal with a complex index of refraction, smooth or with GGX microfacets.
///
/// f = F D G/(4 |cos θo cos θi|), with height-correlated masking and shadowing (Heitz 2014,
/// equation 99).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Conductor {
    /// Real part of the index per channel, 0 to 100.
    pub eta: [f32; 3],
    /// Imaginary part of the index per channel, 0 to 100. Must be at least 0.001 in channels whose
    /// `eta` is below 0.001.
    pub k: [f32; 3],
    /// GGX roughness α, 0 to 1, or a texture. Below 0.001, the metal is a mirror.
    #[serde(default = "Number::zero")]
    pub alpha: Number,
    /// Name of a normal map: an image texture with linear encoding.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<TextureRef>,
    /// Holes in the surface, which must then be of triangles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opacity: Option<Opacity>,
}

impl Conductor {
    /// Creates the material without a normal map and without holes.
    pub fn new(eta: [f32; 3], k: [f32; 3], alpha: impl Into<Number>) -> Self {
        Self { eta, k, alpha: alpha.into(), normal: None, opacity: None }
    }
}

/// Smallest α of a rough metal.
const LEAST_ALPHA: f32 = 0.001;

impl MaterialParameters for Conductor {
    texture_methods!(alpha);

    fn check(&self, e: &Location<'_>) -> Result<()> {
        let Self { eta, k, .. } = *self;
        self.alpha.check(e, "alpha", 0.0..=1.0)?;
        e.color("eta", eta, 100.0)?;
        e.color("k", k, 100.0)?;
        // If both are 0, the Fresnel equations yield 0/0 at normal incidence.
        let known = eta.iter().zip(k).all(|(&eta, k)| eta >= 0.001 || k >= 0.001);
        e.check(known, "k", "at least 0.001 in channels whose eta is below 0.001", k)
    }
}

impl MaterialModel for Conductor {
    /// `eta` and `k`, each with a word of `alpha`.
    type Entry = [Row; 2];
    type Bsdf<R: Real> = ConductorBsdf<R>;

    const GLOSSY: bool = true;
    const TEXTURED: bool = true;

    fn entry(&self, textures: &mut TextureTables) -> [Row; 2] {
        let [alpha, code] = textures.number(&self.alpha).map(f32::from_bits);
        [row(Vec3::from(self.eta), alpha), row(Vec3::from(self.k), code)]
    }

    #[inline(always)]
    fn bsdf<R: Real>(
        table: &[[Row; 2]],
        index: R::Index,
        at: &Interaction<'_, R>,
    ) -> ConductorBsdf<R> {
        let (eta, alpha) = R::gather(table, index, |entry| &entry[0]);
        let (k, code) = R::gather(table, index, |entry| &entry[1]);
        let alpha = at.number([alpha, code]);
        let alpha = alpha.lt(R::splat(LEAST_ALPHA)).select(R::ZERO, alpha);
        let (frame, ggx) = (Frame::new(at.normals.mirror), Ggx::new(alpha));
        let wo = frame.local(-at.ray.direction);
        ConductorBsdf { frame, wo, eta, k, ggx, bound: ggx.bound(wo) }
    }
}

pub(crate) struct ConductorBsdf<R: Real> {
    frame: Frame<R::Vec3>,
    /// Direction back along the path, in the local frame.
    wo: R::Vec3,
    eta: R::Vec3,
    k: R::Vec3,
    ggx: Ggx<R>,
    /// Bound on the sampled normals, from [`Ggx::bound`].
    bound: R,
}

impl<R: Real> ConductorBsdf<R> {
    #[inline(always)]
    fn reflectance(&self, cos: R) -> R::Vec3 {
        fresnel::conductor(min(cos, R::ONE), self.eta, self.k)
    }

    /// Density of the direction into which a microfacet with normal `m` reflects.
    #[inline(always)]
    fn pdf(&self, m: R::Vec3) -> R {
        let projected = self.bound * self.wo[2] + self.ggx.length(self.wo);
        self.ggx.density(m) / (projected * 2.0)
    }

    /// f·cos θi/pdf without F. D is a factor of both f and pdf, and cancels.
    #[inline(always)]
    fn weight(&self, wi: R::Vec3) -> R {
        let (lo, li) = (self.ggx.length(self.wo), self.ggx.length(wi));
        wi[2] * (self.bound * self.wo[2] + lo) / (self.wo[2] * li + wi[2] * lo)
    }
}

impl<R: Real> Bsdf<R> for ConductorBsdf<R> {
    #[inline(always)]
    fn specular(&self) -> R::Mask {
        self.ggx.alpha.eq(R::ZERO)
    }

    #[inline(always)]
    fn albedo(&self) -> R::Vec3 {
        self.reflectance(R::ONE)
    }

    #[inline(always)]
    fn sample(&self, randoms: &Randoms<R>) -> Scatter<R> {
        let (u, v) = randoms.two(Dimension::SCATTER);
        let m = self.ggx.sample(self.wo, self.bound, u, v);
        let cos = dot(self.wo, m);
        let wi = normalize(m * (cos * 2.0) - self.wo);
        Scatter {
            direction: self.frame.world(wi),
            transmitted: R::Mask::NONE,
            weight: self.reflectance(cos) * self.weight(wi),
            pdf: self.specular().select(R::splat(SPECULAR), self.pdf(m)),
            // Also false for NaN.
            scattered: wi[2].gt(R::ZERO),
        }
    }

    #[inline(always)]
    fn evaluate(&self, direction: R::Vec3) -> (R::Vec3, R) {
        let wi = self.frame.local(direction);
        let m = normalize(self.wo + wi);
        let possible = wi[2].gt(R::ZERO) & !self.specular();
        let pdf = possible.select(self.pdf(m), R::ZERO);
        let f_cos = self.reflectance(dot(self.wo, m)) * (self.weight(wi) * pdf);
        (possible.select(f_cos, R::Vec3::zero()), pdf)
    }
}
