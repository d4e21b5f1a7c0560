//! Frosted glass: GGX microfacets that reflect and refract.

use super::Shading;
use super::scatter::{Bsdf, Material, Scatter};
use super::vertex::Vertex;
use crate::engine::dimension::{Dimension, Randoms};
use crate::simd::fresnel;
use crate::simd::microfacet::GgxLanes;
use crate::simd::random::PathKeys;
use crate::simd::{Float, FrameLanes, Mask, Vec3x};

/// Frosted glass.
pub(super) struct RoughDielectric;

/// Its surfaces: the scalar engine's model.
pub(super) struct RoughDielectricBsdf {
    frame: FrameLanes,
    /// To where the paths have come from, in the frame.
    wo: Vec3x,
    /// Index of refraction beyond the surface over that before it.
    eta: Float,
    ggx: GgxLanes,
}

impl Material for RoughDielectric {
    type Bsdf = RoughDielectricBsdf;

    #[inline(always)]
    fn bsdf(&self, shading: &Shading<'_>, vertex: &Vertex) -> RoughDielectricBsdf {
        let (_, ior) = shading.solid(&vertex.primitive);
        let (_, alpha) = shading.more(0, &vertex.primitive);
        let frame = FrameLanes::new(vertex.normal);
        let wo = frame.local(-vertex.segment.direction);
        let eta = vertex.front.select(ior, Float::splat(1.0) / ior);
        RoughDielectricBsdf { frame, wo, eta, ggx: GgxLanes { alpha } }
    }
}

impl Bsdf for RoughDielectricBsdf {
    const TRANSMITS: bool = true;

    #[inline(always)]
    fn specular(&self) -> Mask {
        Mask::NONE
    }

    #[inline(always)]
    fn sample(&self, randoms: &Randoms<PathKeys>) -> Scatter {
        let (one, (u, v)) = (Float::splat(1.0), randoms.two(Dimension::SCATTER));
        let m = self.ggx.sample(self.wo, one, u, v);
        let cos = self.wo.dot(m).min(one);
        let reflectance = fresnel::dielectric(cos, self.eta);
        let reflected = randoms.one(Dimension::LOBE).lt(reflectance);
        let reflection = m * (Float::splat(2.0) * cos) - self.wo;
        let sin2 = (one - cos * cos) / (self.eta * self.eta);
        let along = cos / self.eta - Float::ZERO.max(one - sin2).sqrt();
        let refraction = m * along - self.wo / self.eta;
        let wi = Vec3x::select(reflected, reflection, refraction).normalize();
        let (weight, pdf, possible) = self.weight_and_pdf(wi, m);
        // Where the microfacet turns the path to the other side it is lost.
        let right = !(wi[2].gt(Float::ZERO).bits() ^ reflected.bits());
        let normal = self.frame.normal();
        Scatter {
            direction: self.frame.world(wi),
            side: Vec3x::select(reflected, normal, -normal),
            weight: Vec3x([weight; 3]),
            pdf,
            scattered: possible.bits() & right,
        }
    }

    #[inline(always)]
    fn evaluate(&self, direction: Vec3x) -> (Vec3x, Float) {
        let wi = self.frame.local(direction);
        let bent = wi[2].gt(Float::ZERO).select(Float::splat(1.0), self.eta);
        let half = self.wo + wi * bent;
        let half = Vec3x::select(half[2].lt(Float::ZERO), -half, half);
        let (weight, pdf, possible) = self.weight_and_pdf(wi, half.normalize());
        let f_cos = possible.select(weight * pdf, Float::ZERO);
        (Vec3x([f_cos; 3]), possible.select(pdf, Float::ZERO))
    }
}

impl RoughDielectricBsdf {
    /// f·|cos θi|/pdf and pdf of the directions `wi` by way of the microfacets with normals `m`, and
    /// where these can bring light that way.
    #[inline(always)]
    fn weight_and_pdf(&self, wi: Vec3x, m: Vec3x) -> (Float, Float, Mask) {
        let (one, two) = (Float::splat(1.0), Float::splat(2.0));
        let (before, after) = (self.wo.dot(m).min(one), wi.dot(m));
        let (lo, li) = (self.ggx.length(self.wo), self.ggx.length(wi));
        let reflectance = fresnel::dielectric(before, self.eta);
        let normals = two * self.ggx.density(m) * before / (self.wo[2] + lo);
        let reflection = (
            wi[2] * (self.wo[2] + lo) / (self.wo[2] * li + wi[2] * lo),
            reflectance * normals / (Float::splat(4.0) * before),
        );
        let sum = before + self.eta * after;
        let jacobian = self.eta * self.eta * after.abs() / (sum * sum);
        let refraction = (two * wi[2] / (wi[2] - li), (one - reflectance) * normals * jacobian);
        let above = wi[2].gt(Float::ZERO);
        let weight = above.select(reflection.0, refraction.0);
        let pdf = above.select(reflection.1, refraction.1);
        let through = (above & after.gt(Float::ZERO)) | (!above & after.lt(Float::ZERO));
        (weight, pdf, through & before.gt(Float::ZERO) & pdf.gt(Float::ZERO))
    }
}
