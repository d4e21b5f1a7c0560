//! Points on moving spheres.

use std::sync::Arc;

use super::SurfaceTable;
use crate::geometry::sphere::{row_at_start, surface, uv};
use crate::geometry::{Geometry, Ray, Surface};
use crate::math::{Real, Row, row};

/// [`row_at_start`] and the motion of every sphere. The table is empty if no sphere moves.
#[derive(Debug)]
pub(super) struct Table(Vec<[Row; 2]>);

impl SurfaceTable for Table {
    fn new(geometry: &Arc<Geometry>) -> Self {
        let spheres = if geometry.moves() { &geometry.spheres[..] } else { &[] };
        let rows = spheres.iter().map(|sphere| [row_at_start(sphere), row(sphere.motion(), 0.0)]);
        Self(rows.collect())
    }

    #[inline(always)]
    fn find<R: Real>(&self, primitive: R::Word, ray: &Ray<R>, t: R) -> Surface<R> {
        let index = R::index(primitive, self.0.len());
        let (center, radius) = R::gather(&self.0, index, |rows| &rows[0]);
        let (motion, _) = R::gather(&self.0, index, |rows| &rows[1]);
        surface(center + motion * ray.time, radius, ray, t)
    }

    #[inline(always)]
    fn uv<R: Real>(&self, _: R::Word, _: &Ray<R>, surface: &Surface<R>, _: R) -> (R, R) {
        uv(surface.normal)
    }
}
