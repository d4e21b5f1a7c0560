//! The point where a path meets a surface.

use super::tables::SceneTables;
use crate::geometry::{Ray, Shape, Surface};
use crate::math::Real;

/// A point of a surface that a path arrives at, or one a lane; the surfaces are of one shape.
#[derive(Clone, Copy)]
pub(crate) struct Interaction<'a, R: Real> {
    pub(crate) tables: &'a SceneTables,
    /// Whether colours may be textures: where it is known that none is, nothing is spent on them.
    pub(crate) textured: bool,
    /// That arrives; its direction is of unit length.
    pub(crate) ray: Ray<R>,
    /// Distance along the ray.
    pub(crate) t: R,
    pub(crate) shape: Shape,
    pub(crate) primitive: R::Word,
    pub(crate) surface: Surface<R>,
    /// The surface's normal, turned to the side that was hit.
    pub(crate) normal: R::Vec3,
    /// Whether that is the front.
    pub(crate) front: R::Mask,
}

impl<R: Real> Interaction<'_, R> {
    /// The colour of a row of [`super::texture::TextureTables::row`].
    #[inline(always)]
    pub(crate) fn color(&self, row: (R::Vec3, R)) -> R::Vec3 {
        if self.textured { self.tables.textures.color(row, self) } else { row.0 }
    }

    /// Texture coordinates, both in [0, 1] up to rounding.
    pub(crate) fn uv(&self) -> (R, R) {
        self.tables.surfaces.uv(self.shape, self.primitive, &self.ray, &self.surface, self.t)
    }
}
