//! Diffuse surfaces: Lambert's law (report, III.C) or the report's ideal diffuse (III.B).

use std::f32::consts::PI;

use super::Shading;
use super::scatter::{Colored, Scatter, Scatterer};
use super::vertex::Vertex;
use crate::engine::dimension::Dimension;
use crate::engine::wavefront::connect::Shadows;
use crate::engine::wavefront::materials::Pattern;
use crate::simd::warp::{cosine_hemisphere, uniform_hemisphere};
use crate::simd::{Float, Vec3x};

/// Surfaces that scatter light to all sides.
pub(super) struct Diffuse<const COSINE: bool> {
    /// On the side that was hit.
    pub(super) normal: Vec3x,
    /// ρ, which is also the weight of every sample.
    pub(super) albedo: Vec3x,
}

impl<const COSINE: bool> Diffuse<COSINE> {
    /// Directions and their densities per unit solid angle.
    #[inline(always)]
    fn sample(&self, (u, v): (Float, Float)) -> (Vec3x, Float) {
        if COSINE {
            let (direction, cos) = cosine_hemisphere(self.normal, u, v);
            (direction, cos * Float::splat(1.0 / PI))
        } else {
            (uniform_hemisphere(self.normal, u, v).0, Float::splat(0.5 / PI))
        }
    }

    /// f·cos θ without ρ, which is the density of θ too.
    #[inline(always)]
    pub(super) fn evaluate(cos: Float) -> Float {
        let value = if COSINE { cos * Float::splat(1.0 / PI) } else { Float::splat(0.5 / PI) };
        cos.gt(Float::ZERO).select(value, Float::ZERO)
    }
}

/// Diffuse materials whose colours vary in one way.
pub(super) struct DiffuseOf<const COSINE: bool>(Pattern);

impl<const COSINE: bool> Scatterer for DiffuseOf<COSINE> {
    #[inline(always)]
    fn scatter(&self, shading: &Shading<'_>, vertex: &Vertex, shadows: &mut Shadows) -> Scatter {
        let (albedo, _) = shading.albedo(self.0, vertex);
        let diffuse = Diffuse::<COSINE> { normal: vertex.normal, albedo };
        let origin = vertex.surface.spawn(vertex.normal);
        if shading.settings.samples_lights(shading.scene) {
            shading.direct(vertex, &diffuse, origin, shadows);
        }
        let (direction, pdf) = diffuse.sample(vertex.randoms.two(Dimension::SCATTER));
        Scatter { origin, direction, weight: albedo, pdf, scattered: vertex.present }
    }
}

impl<const COSINE: bool> Colored for DiffuseOf<COSINE> {
    #[inline(always)]
    fn of(pattern: Pattern) -> Self {
        Self(pattern)
    }
}
