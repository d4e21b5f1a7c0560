//! Metal: the mirror direction, blurred (report, III.D).

use std::f32::consts::PI;

use super::Shading;
use super::scatter::{Bsdf, Colored, Material, Scatter};
use super::vertex::Vertex;
use crate::engine::contract::LEAST_BLUR;
use crate::engine::dimension::{Dimension, Randoms};
use crate::engine::wavefront::materials::Pattern;
use crate::engine::wavefront::paths::Segment;
use crate::simd::random::PathKeys;
use crate::simd::warp::uniform_ball;
use crate::simd::{Float, Mask, Vec3x};

/// Metals whose colours vary in one way.
pub(super) struct Metal(Pattern);

/// The mirror direction moved by `fuzz` times a point of the unit ball.
pub(super) struct MetalBsdf {
    normal: Vec3x,
    mirror: Vec3x,
    albedo: Vec3x,
    fuzz: Float,
}

impl Material for Metal {
    type Bsdf = MetalBsdf;

    #[inline(always)]
    fn bsdf(&self, shading: &Shading<'_>, vertex: &Vertex) -> MetalBsdf {
        let (albedo, fuzz) = shading.albedo(self.0, vertex);
        let mirror = vertex.segment.direction.reflect(vertex.normal);
        MetalBsdf { normal: vertex.normal, mirror, albedo, fuzz }
    }
}

impl Colored for Metal {
    #[inline(always)]
    fn of(pattern: Pattern) -> Self {
        Self(pattern)
    }
}

impl Bsdf for MetalBsdf {
    #[inline(always)]
    fn specular(&self) -> Mask {
        self.fuzz.lt(Float::splat(LEAST_BLUR))
    }

    #[inline(always)]
    fn sample(&self, randoms: &Randoms<PathKeys>) -> Scatter {
        let (u, v) = randoms.two(Dimension::SCATTER);
        let blur = uniform_ball(u, v, randoms.one(Dimension::BALL));
        let direction = (self.mirror + blur * self.fuzz).normalize();
        let specular = Float::splat(Segment::SPECULAR);
        Scatter {
            direction,
            side: self.normal,
            weight: self.albedo,
            pdf: self.specular().select(specular, self.pdf(direction)),
            // False for NaN too, where the blur undoes the mirror direction exactly.
            scattered: direction.dot(self.normal).gt(Float::ZERO).bits(),
        }
    }

    #[inline(always)]
    fn evaluate(&self, direction: Vec3x) -> (Vec3x, Float) {
        let possible = direction.dot(self.normal).gt(Float::ZERO) & !self.specular();
        let pdf = possible.select(self.pdf(direction), Float::ZERO);
        (self.albedo * pdf, pdf)
    }
}

impl MetalBsdf {
    /// The volume of the ball in the direction: see the scalar engine's.
    #[inline(always)]
    fn pdf(&self, direction: Vec3x) -> Float {
        let number = Float::splat;
        let b = self.mirror.dot(direction);
        let across = self.mirror.cross(direction);
        let s2 = Float::ZERO.max(self.fuzz * self.fuzz - across.dot(across));
        let cube = self.fuzz * self.fuzz * self.fuzz;
        let pdf = s2.sqrt() * (number(3.0) * (b * b) + s2) / (number(2.0 * PI) * cube);
        b.gt(Float::ZERO).select(pdf, Float::ZERO)
    }
}
