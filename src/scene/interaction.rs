//! The point where a path meets a surface.

use super::texture::{TexturePoint, TextureTables};
use crate::geometry::{Ray, Shape, Surface, Surfaces};
use crate::math::Real;

/// A point of a surface that a path arrives at, or one a lane; the surfaces are of one shape.
#[derive(Clone, Copy)]
pub(crate) struct Interaction<'a, R: Real> {
    pub(crate) surfaces: &'a Surfaces,
    /// `None` where no material has a texture: then colours cost nothing.
    pub(crate) textures: Option<&'a TextureTables>,
    /// The ray that arrives; its direction is of unit length.
    pub(crate) ray: Ray<R>,
    /// Distance along the ray.
    pub(crate) t: R,
    pub(crate) shape: Shape,
    pub(crate) primitive: R::Word,
    pub(crate) surface: Surface<R>,
    /// The surface's geometric normal, turned to the side that was hit: paths leave along it.
    pub(crate) normal: R::Vec3,
    /// The normal by which the material scatters. No shape has another than the geometric one yet.
    pub(crate) shading: R::Vec3,
    /// Whether that is the front.
    pub(crate) front: R::Mask,
}

impl<R: Real> Interaction<'_, R> {
    /// The colour of a row of [`TextureTables::row`].
    #[inline(always)]
    pub(crate) fn color(&self, row: (R::Vec3, R)) -> R::Vec3 {
        self.textures.map_or(row.0, |textures| textures.color(row, self))
    }
}

impl<R: Real> TexturePoint<R> for Interaction<'_, R> {
    #[inline(always)]
    fn point(&self) -> R::Vec3 {
        self.surface.point
    }

    fn uv(&self) -> (R, R) {
        self.surfaces.uv(self.shape, self.primitive, &self.ray, &self.surface, self.t)
    }
}
