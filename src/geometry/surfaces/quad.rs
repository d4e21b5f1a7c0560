//! Points on quads.

use std::sync::Arc;

use super::{Partials, SurfaceTable};
use crate::geometry::quad::rows;
use crate::geometry::{Geometry, Hit, Ray, Surface};
use crate::math::{Real, Row, Vector, Word, dot};

/// The [`rows`] of every quad.
#[derive(Debug)]
pub(super) struct Table {
    /// The index of the first quad among all primitives.
    first: u32,
    quads: Vec<[Row; 5]>,
}

impl Table {
    #[inline(always)]
    fn index<R: Real>(&self, primitive: R::Word) -> R::Index {
        R::index(primitive.wrapping_sub(R::Word::splat(self.first)), self.quads.len())
    }

    /// Row `number` of the quads at `index`.
    #[inline(always)]
    fn row<R: Real>(&self, index: R::Index, number: usize) -> (R::Vec3, R) {
        R::gather(&self.quads, index, |rows| &rows[number])
    }
}

impl SurfaceTable for Table {
    fn new(geometry: &Arc<Geometry>) -> Self {
        let quads = geometry.quads.iter().map(rows).collect();
        Self { first: geometry.spheres.len() as u32, quads }
    }

    #[inline(always)]
    fn find<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>) -> Surface<R> {
        let index = self.index::<R>(hit.primitive);
        let (q, offset) = self.row::<R>(index, 0);
        let (u, x) = self.row::<R>(index, 1);
        let (v, y) = self.row::<R>(index, 2);
        let (dual_u, z) = self.row::<R>(index, 3);
        let (dual_v, _) = self.row::<R>(index, 4);
        let (a, b) = coordinates([q, dual_u, dual_v], ray, hit.t);
        Surface::flat(q + (u * a + v * b), <R::Vec3 as Vector>::new(x, y, z), offset)
    }

    /// The coordinates (a, b) along the edges.
    #[inline(always)]
    fn uv<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>, _: &Surface<R>) -> (R, R) {
        let index = self.index::<R>(hit.primitive);
        let (q, _) = self.row::<R>(index, 0);
        let (dual_u, _) = self.row::<R>(index, 3);
        let (dual_v, _) = self.row::<R>(index, 4);
        coordinates([q, dual_u, dual_v], ray, hit.t)
    }

    /// The edges.
    #[inline(always)]
    fn partials<R: Real>(&self, _: &Ray<R>, hit: Hit<R>, _: &Surface<R>) -> Partials<R> {
        let index = self.index::<R>(hit.primitive);
        let (u, _) = self.row::<R>(index, 1);
        let (v, _) = self.row::<R>(index, 2);
        Partials::new(u, v)
    }
}

/// The coordinates (a, b) of the point at distance `t`, on a quad with this corner and these dual
/// edges.
#[inline(always)]
fn coordinates<R: Real>([q, dual_u, dual_v]: [R::Vec3; 3], ray: &Ray<R>, t: R) -> (R, R) {
    let p = (ray.origin - q) + ray.direction * t;
    (dot(p, dual_u), dot(p, dual_v))
}
