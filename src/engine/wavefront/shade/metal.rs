//! Metal: the mirror direction, blurred (report, III.D).

use super::Shading;
use super::scatter::{Colored, Scatter, Scatterer, reflect};
use super::vertex::Vertex;
use crate::engine::dimension::Dimension;
use crate::engine::wavefront::connect::Shadows;
use crate::engine::wavefront::materials::Pattern;
use crate::engine::wavefront::paths::Segment;
use crate::simd::Float;
use crate::simd::warp::uniform_ball;

/// Metals whose colours vary in one way.
pub(super) struct MetalOf(Pattern);

impl Scatterer for MetalOf {
    #[inline(always)]
    fn scatter(&self, shading: &Shading<'_>, vertex: &Vertex, _: &mut Shadows) -> Scatter {
        let (albedo, fuzz) = shading.albedo(self.0, vertex);
        let mirror = reflect(vertex.segment.direction, vertex.normal);
        let (u, v) = vertex.randoms.two(Dimension::SCATTER);
        let blur = uniform_ball(u, v, vertex.randoms.one(Dimension::BALL));
        let direction = (mirror + blur * fuzz).normalize();
        // False for NaN too, where the blur undoes the mirror direction exactly.
        let above = direction.dot(vertex.normal).gt(Float::ZERO);
        Scatter {
            origin: vertex.surface.spawn(vertex.normal),
            direction,
            weight: albedo,
            pdf: Float::splat(Segment::SPECULAR),
            scattered: above.bits(),
        }
    }
}

impl Colored for MetalOf {
    #[inline(always)]
    fn of(pattern: Pattern) -> Self {
        Self(pattern)
    }
}
