//! Clear glass: reflection or refraction, chosen by chance (report, III.E).

use super::Shading;
use super::scatter::{Bsdf, Material, Scatter};
use super::vertex::Vertex;
use crate::engine::dimension::{Dimension, Randoms};
use crate::engine::wavefront::paths::Segment;
use crate::simd::fresnel;
use crate::simd::random::PathKeys;
use crate::simd::{Float, Mask, Vec3x};

/// Smooth glass, of [`Fresnel::Exact`](crate::scene::Fresnel::Exact) or Schlick's approximation.
pub(super) struct Dielectric<const EXACT: bool>;

/// A smooth surface of glass.
pub(super) struct DielectricBsdf<const EXACT: bool> {
    direction: Vec3x,
    normal: Vec3x,
    front: Mask,
    ior: Float,
    present: u32,
}

impl<const EXACT: bool> Material for Dielectric<EXACT> {
    type Bsdf = DielectricBsdf<EXACT>;

    #[inline(always)]
    fn bsdf(&self, shading: &Shading<'_>, vertex: &Vertex) -> DielectricBsdf<EXACT> {
        let Vertex { normal, front, present, .. } = *vertex;
        let (_, ior) = shading.solid(&vertex.primitive);
        DielectricBsdf { direction: vertex.segment.direction, normal, front, ior, present }
    }
}

impl<const EXACT: bool> Bsdf for DielectricBsdf<EXACT> {
    #[inline(always)]
    fn specular(&self) -> Mask {
        Mask::all()
    }

    #[inline(always)]
    fn sample(&self, randoms: &Randoms<PathKeys>) -> Scatter {
        let Self { direction, normal, front, ior, present } = *self;
        let one = Float::splat(1.0);
        let eta = front.select(one / ior, ior);
        let cos = (-direction.dot(normal)).min(one);
        let sin2_refracted = eta * eta * (one - cos * cos);
        let reflectance = if EXACT {
            fresnel::dielectric(cos, front.select(ior, one / ior))
        } else {
            fresnel::schlick(cos, ior)
        };
        let reflected = sin2_refracted.gt(one) | randoms.one(Dimension::LOBE).lt(reflectance);
        let along = eta * cos - Float::ZERO.max(one - sin2_refracted).sqrt();
        let refraction = direction * eta + normal * along;
        let next = Vec3x::select(reflected, direction.reflect(normal), refraction);
        Scatter {
            direction: next.normalize(),
            side: Vec3x::select(reflected, normal, -normal),
            weight: Vec3x([one; 3]),
            pdf: Float::splat(Segment::SPECULAR),
            scattered: present,
        }
    }

    #[inline(always)]
    fn evaluate(&self, _: Vec3x) -> (Vec3x, Float) {
        (Vec3x::ZERO, Float::ZERO)
    }
}
