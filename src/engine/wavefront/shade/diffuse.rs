//! Diffuse surfaces: Lambert's law (report, III.C) or the report's ideal diffuse (III.B).

use std::f32::consts::PI;

use super::Shading;
use super::scatter::{Bsdf, Colored, Material, Scatter};
use super::vertex::Vertex;
use crate::engine::dimension::{Dimension, Randoms};
use crate::engine::wavefront::materials::Pattern;
use crate::simd::random::PathKeys;
use crate::simd::warp::{cosine_hemisphere, uniform_hemisphere};
use crate::simd::{Float, Mask, Vec3x};

/// Diffuse materials whose colours vary in one way, by Lambert's law if `COSINE`.
pub(super) struct Diffuse<const COSINE: bool>(Pattern);

/// Surfaces that scatter light to all sides.
pub(super) struct DiffuseBsdf<const COSINE: bool> {
    /// On the side that was hit.
    normal: Vec3x,
    /// ρ, which is also the weight of every sample.
    albedo: Vec3x,
    present: u32,
}

impl<const COSINE: bool> Material for Diffuse<COSINE> {
    type Bsdf = DiffuseBsdf<COSINE>;

    #[inline(always)]
    fn bsdf(&self, shading: &Shading<'_>, vertex: &Vertex) -> DiffuseBsdf<COSINE> {
        let (albedo, _) = shading.albedo(self.0, vertex);
        DiffuseBsdf { normal: vertex.normal, albedo, present: vertex.present }
    }
}

impl<const COSINE: bool> Colored for Diffuse<COSINE> {
    #[inline(always)]
    fn of(pattern: Pattern) -> Self {
        Self(pattern)
    }
}

impl<const COSINE: bool> Bsdf for DiffuseBsdf<COSINE> {
    #[inline(always)]
    fn specular(&self) -> Mask {
        Mask::NONE
    }

    #[inline(always)]
    fn sample(&self, randoms: &Randoms<PathKeys>) -> Scatter {
        let Self { normal, albedo, present } = *self;
        let (u, v) = randoms.two(Dimension::SCATTER);
        let (direction, pdf) = if COSINE {
            let (direction, cos) = cosine_hemisphere(normal, u, v);
            (direction, cos * Float::splat(1.0 / PI))
        } else {
            (uniform_hemisphere(normal, u, v).0, Float::splat(0.5 / PI))
        };
        Scatter { direction, side: normal, weight: albedo, pdf, scattered: present }
    }

    #[inline(always)]
    fn evaluate(&self, direction: Vec3x) -> (Vec3x, Float) {
        let cos = self.normal.dot(direction);
        let above = if COSINE { cos * Float::splat(1.0 / PI) } else { Float::splat(0.5 / PI) };
        let pdf = cos.gt(Float::ZERO).select(above, Float::ZERO);
        (self.albedo * pdf, pdf)
    }
}
