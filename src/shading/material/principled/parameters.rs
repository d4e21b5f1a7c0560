//! The parameters of the principled material at a point.

use crate::math::{Mask, Real, Vector, Word};

/// The parameters of the material at a point.
pub(in crate::shading::material) struct Parameters<R: Real> {
    pub(in crate::shading::material) base_color: R::Vec3,
    pub(in crate::shading::material) metalness: R,
    pub(in crate::shading::material) roughness: R,
    pub(in crate::shading::material) specular: R,
    pub(in crate::shading::material) transmission: R,
    pub(in crate::shading::material) thin: R::Mask,
    /// Whether the light that passes is left to [`MaterialModel::passes`](super::MaterialModel::passes).
    pub(in crate::shading::material) pane: R::Mask,
    pub(in crate::shading::material) ior: R,
    pub(in crate::shading::material) coat: R,
    pub(in crate::shading::material) coat_roughness: R,
    pub(in crate::shading::material) coat_color: R::Vec3,
    /// Whether the normals of the coat are not those of the surface below it, and the code of its normal map.
    pub(in crate::shading::material) coat_apart: R::Mask,
    pub(in crate::shading::material) coat_normal: R::Word,
    pub(in crate::shading::material) extras: Extras<R>,
}

/// The parameters that few materials have.
pub(in crate::shading::material) struct Extras<R: Real> {
    pub(super) specular_color: R::Vec3,
    /// Strength of the anisotropy, and the direction along (tangent, bitangent) in which the surface is
    /// rougher.
    pub(super) anisotropy: R,
    pub(super) direction: [R; 2],
    pub(super) sheen_color: R::Vec3,
    pub(super) sheen_roughness: R,
    /// Share of the light of the diffuse base that leaves on the other side, and its colour.
    pub(super) through: R,
    pub(super) through_color: R::Vec3,
}

impl<R: Real> Extras<R> {
    /// Those of a material that has none of them.
    #[inline(always)]
    pub(super) fn none() -> Self {
        let white = R::Vec3::gray(R::ONE);
        Self {
            specular_color: white,
            anisotropy: R::ZERO,
            direction: [R::ONE, R::ZERO],
            sheen_color: R::Vec3::zero(),
            sheen_roughness: R::ZERO,
            through: R::ZERO,
            through_color: white,
        }
    }
}

impl<R: Real> Parameters<R> {
    /// An opaque surface of one layer that is not metal.
    #[inline(always)]
    pub(in crate::shading::material) fn plastic(base_color: R::Vec3, roughness: R, ior: R) -> Self {
        Self {
            base_color,
            metalness: R::ZERO,
            roughness,
            specular: R::ONE,
            transmission: R::ZERO,
            thin: R::Mask::NONE,
            pane: R::Mask::NONE,
            ior,
            coat: R::ZERO,
            coat_roughness: R::ZERO,
            coat_color: R::Vec3::gray(R::ONE),
            coat_apart: R::Mask::NONE,
            coat_normal: R::Word::splat(0),
            extras: Extras::none(),
        }
    }
}
