//! Media that scatter light to all sides alike.

use std::f32::consts::PI;

use super::Shading;
use super::scatter::{Bsdf, Material, Scatter};
use super::vertex::Vertex;
use crate::engine::dimension::{Dimension, Randoms};
use crate::simd::random::PathKeys;
use crate::simd::warp::uniform_sphere;
use crate::simd::{Float, Mask, Vec3x, gather_quads};

/// The media of a scene.
pub(super) struct Media;

/// The isotropic phase function.
pub(super) struct PhaseBsdf {
    albedo: Vec3x,
    present: u32,
}

impl PhaseBsdf {
    const PDF: f32 = 0.25 / PI;
}

impl Material for Media {
    type Bsdf = PhaseBsdf;

    #[inline(always)]
    fn bsdf(&self, shading: &Shading<'_>, vertex: &Vertex) -> PhaseBsdf {
        let (albedo, _) = gather_quads(&vertex.primitive, |code| shading.materials.medium(code));
        PhaseBsdf { albedo, present: vertex.present }
    }
}

impl Bsdf for PhaseBsdf {
    #[inline(always)]
    fn specular(&self) -> Mask {
        Mask::NONE
    }

    #[inline(always)]
    fn sample(&self, randoms: &Randoms<PathKeys>) -> Scatter {
        let (u, v) = randoms.two(Dimension::SCATTER);
        Scatter {
            direction: uniform_sphere(u, v),
            side: Vec3x::ZERO,
            weight: self.albedo,
            pdf: Float::splat(Self::PDF),
            scattered: self.present,
        }
    }

    #[inline(always)]
    fn evaluate(&self, _: Vec3x) -> (Vec3x, Float) {
        let pdf = Float::splat(Self::PDF);
        (self.albedo * pdf, pdf)
    }
}
