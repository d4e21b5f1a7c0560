//! Metal by its index of refraction, smooth or of GGX microfacets.

use super::Shading;
use super::scatter::{Bsdf, Material, Scatter};
use super::vertex::Vertex;
use crate::engine::dimension::{Dimension, Randoms};
use crate::engine::wavefront::paths::Segment;
use crate::simd::fresnel;
use crate::simd::microfacet::GgxLanes;
use crate::simd::random::PathKeys;
use crate::simd::{Float, FrameLanes, Mask, Vec3x};

/// Conductors.
pub(super) struct Conductor;

/// Their surfaces: the scalar engine's model.
pub(super) struct ConductorBsdf {
    frame: FrameLanes,
    /// To where the paths have come from, in the frame.
    wo: Vec3x,
    eta: Vec3x,
    k: Vec3x,
    ggx: GgxLanes,
    bound: Float,
}

impl Material for Conductor {
    type Bsdf = ConductorBsdf;

    #[inline(always)]
    fn bsdf(&self, shading: &Shading<'_>, vertex: &Vertex) -> ConductorBsdf {
        let (eta, alpha) = shading.solid(&vertex.primitive);
        let (k, _) = shading.more(0, &vertex.primitive);
        let (frame, ggx) = (FrameLanes::new(vertex.normal), GgxLanes { alpha });
        let wo = frame.local(-vertex.segment.direction);
        ConductorBsdf { frame, wo, eta, k, ggx, bound: ggx.bound(wo) }
    }
}

impl Bsdf for ConductorBsdf {
    #[inline(always)]
    fn specular(&self) -> Mask {
        self.ggx.alpha.eq(Float::ZERO)
    }

    #[inline(always)]
    fn sample(&self, randoms: &Randoms<PathKeys>) -> Scatter {
        let (u, v) = randoms.two(Dimension::SCATTER);
        let m = self.ggx.sample(self.wo, self.bound, u, v);
        let cos = self.wo.dot(m);
        let wi = (m * (Float::splat(2.0) * cos) - self.wo).normalize();
        let specular = Float::splat(Segment::SPECULAR);
        Scatter {
            direction: self.frame.world(wi),
            side: self.frame.normal(),
            weight: self.reflectance(cos) * self.weight(wi),
            pdf: self.specular().select(specular, self.pdf(m)),
            // False for NaN too.
            scattered: wi[2].gt(Float::ZERO).bits(),
        }
    }

    #[inline(always)]
    fn evaluate(&self, direction: Vec3x) -> (Vec3x, Float) {
        let wi = self.frame.local(direction);
        let m = (self.wo + wi).normalize();
        let possible = wi[2].gt(Float::ZERO) & !self.specular();
        let pdf = possible.select(self.pdf(m), Float::ZERO);
        let f_cos = self.reflectance(self.wo.dot(m)) * (self.weight(wi) * pdf);
        (Vec3x::select(possible, f_cos, Vec3x::ZERO), pdf)
    }
}

impl ConductorBsdf {
    #[inline(always)]
    fn reflectance(&self, cos: Float) -> Vec3x {
        fresnel::conductor(cos.min(Float::splat(1.0)), self.eta, self.k)
    }

    /// Density of the direction that `m` reflects to.
    #[inline(always)]
    fn pdf(&self, m: Vec3x) -> Float {
        let projected = self.bound * self.wo[2] + self.ggx.length(self.wo);
        self.ggx.density(m) / (Float::splat(2.0) * projected)
    }

    /// f·cos θi/pdf without F: D is in both.
    #[inline(always)]
    fn weight(&self, wi: Vec3x) -> Float {
        let (lo, li) = (self.ggx.length(self.wo), self.ggx.length(wi));
        wi[2] * (self.bound * self.wo[2] + lo) / (self.wo[2] * li + wi[2] * lo)
    }
}
