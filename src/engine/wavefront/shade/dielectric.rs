//! Glass: reflection or refraction, chosen by Schlick's approximation (report, III.E).

use super::Shading;
use super::scatter::{Scatter, Scatterer, reflect};
use super::vertex::Vertex;
use crate::engine::dimension::Dimension;
use crate::engine::wavefront::connect::Shadows;
use crate::engine::wavefront::paths::Segment;
use crate::simd::{Float, Vec3x};

/// Clear glass.
pub(super) struct Dielectric;

impl Scatterer for Dielectric {
    #[inline(always)]
    fn scatter(&self, shading: &Shading<'_>, vertex: &Vertex, _: &mut Shadows) -> Scatter {
        let (one, (_, ior)) = (Float::splat(1.0), shading.solid(&vertex.primitive));
        let (direction, normal) = (vertex.segment.direction, vertex.normal);
        let eta = vertex.front.select(one / ior, ior);
        let cos = (-direction.dot(normal)).min(one);
        let sin2_refracted = eta * eta * (one - cos * cos);
        let chance = schlick(cos, ior);
        let reflected = sin2_refracted.gt(one) | vertex.randoms.one(Dimension::LOBE).lt(chance);
        let along = eta * cos - Float::ZERO.max(one - sin2_refracted).sqrt();
        let refraction = direction * eta + normal * along;
        let next = Vec3x::select(reflected, reflect(direction, normal), refraction);
        Scatter {
            origin: vertex.surface.spawn(Vec3x::select(reflected, normal, -normal)),
            direction: next.normalize(),
            weight: Vec3x([one; 3]),
            pdf: Float::splat(Segment::SPECULAR),
            scattered: vertex.present,
        }
    }
}

/// Reflectance at the cosine of the angle of incidence (Schlick 1994).
#[inline(always)]
fn schlick(cos: Float, ior: Float) -> Float {
    let one = Float::splat(1.0);
    let r = (one - ior) / (one + ior);
    let r0 = r * r;
    let x = one - cos;
    let x2 = x * x;
    r0 + (one - r0) * (x2 * x2 * x)
}
