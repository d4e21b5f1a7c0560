//! The point where a path meets a surface.

use super::{ScatterNormals, TexturePoint, TextureTables};
use crate::geometry::{Hit, Ray, Shape, Surface, Surfaces};
use crate::math::Real;

/// A point of a surface where a path arrives, or one point per lane. All lanes have the same shape.
#[derive(Clone, Copy)]
pub(crate) struct Interaction<'a, R: Real> {
    pub(crate) surfaces: &'a Surfaces,
    /// The scene's textures, or `None` if no material of the same kind as the surface's uses a
    /// texture. Colours then need no texture lookup.
    pub(crate) textures: Option<&'a TextureTables>,
    /// The arriving ray, with a direction of unit length.
    pub(crate) ray: Ray<R>,
    pub(crate) shape: Shape,
    pub(crate) hit: Hit<R>,
    pub(crate) surface: Surface<R>,
    /// The surface's geometric normal, turned to the side that was hit. The origins of new rays are
    /// moved along it.
    pub(crate) normal: R::Vec3,
    /// The normals about which the material scatters light. They are on the side that was hit, and differ
    /// from `normal` only on smooth surfaces.
    pub(crate) normals: ScatterNormals<R>,
    /// Whether the shading normals may differ from `normal`: the surface is smooth or has a normal map.
    pub(crate) smooth: R::Mask,
    /// Whether its shadows fade out towards the terminator.
    pub(crate) soft: R::Mask,
    /// Whether the front was hit.
    pub(crate) front: R::Mask,
}

impl<R: Real> Interaction<'_, R> {
    /// The colour for a row made by [`TextureTables::row`]: the row's constant colour, or the
    /// colour of its texture at this point.
    #[inline(always)]
    pub(crate) fn color(&self, row: (R::Vec3, R)) -> R::Vec3 {
        self.textures.map_or(row.0, |textures| textures.color(row, self))
    }

    /// The number for two words made by [`TextureTables::number`].
    #[inline(always)]
    pub(crate) fn number(&self, words: [R; 2]) -> R {
        self.textures.map_or(words[0], |textures| textures.number_at(words, self))
    }

    /// As [`number`](Self::number), for two numbers, which are often channels of one texture.
    #[inline(always)]
    pub(crate) fn two_numbers(&self, words: [[R; 2]; 2]) -> [R; 2] {
        let constants = words.map(|[number, _]| number);
        self.textures.map_or(constants, |textures| textures.two_numbers_at(words, self))
    }
}

impl<R: Real> TexturePoint<R> for Interaction<'_, R> {
    #[inline(always)]
    fn point(&self) -> R::Vec3 {
        self.surface.point
    }

    fn uv(&self) -> (R, R) {
        self.surfaces.uv(self.shape, &self.ray, self.hit, &self.surface)
    }

    fn second_uv(&self) -> (R, R) {
        self.surfaces.second_uv(self.shape, &self.ray, self.hit, &self.surface)
    }

    fn vertex_color(&self) -> R::Vec3 {
        self.surfaces.color(self.shape, &self.ray, self.hit)
    }
}
