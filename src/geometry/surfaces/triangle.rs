//! Points on triangles.

use std::sync::Arc;

use super::SurfaceTable;
use crate::geometry::triangle::surface;
use crate::geometry::{Geometry, Ray, Surface};
use crate::math::{Real, Word};

/// A reference to the geometry, whose rows can be gathered as they are.
#[derive(Debug)]
pub(super) struct Table {
    /// The index of the first triangle among all primitives.
    first: u32,
    geometry: Arc<Geometry>,
}

impl Table {
    /// The vertices of triangles.
    #[inline(always)]
    fn vertices<R: Real>(&self, primitive: R::Word) -> [R::Vec3; 3] {
        let (corners, vertices) = self.geometry.triangles.rows();
        let index = R::index(primitive.wrapping_sub(R::Word::splat(self.first)), corners.len());
        let (corners, _) = R::gather(corners, index, |row| row);
        [0, 1, 2].map(|corner| {
            let index = R::index(corners[corner].to_bits(), vertices.len());
            R::gather(vertices, index, |row| row).0
        })
    }
}

impl SurfaceTable for Table {
    fn new(geometry: &Arc<Geometry>) -> Self {
        let first = (geometry.spheres.len() + geometry.quads.len()) as u32;
        Self { first, geometry: Arc::clone(geometry) }
    }

    #[inline(always)]
    fn find<R: Real>(&self, primitive: R::Word, ray: &Ray<R>, t: R) -> Surface<R> {
        surface(self.vertices::<R>(primitive), ray, t).0
    }

    /// The barycentric coordinates for the second and the third vertex.
    #[inline(always)]
    fn uv<R: Real>(&self, primitive: R::Word, ray: &Ray<R>, _: &Surface<R>, t: R) -> (R, R) {
        surface(self.vertices::<R>(primitive), ray, t).1.into()
    }
}
