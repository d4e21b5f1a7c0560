//! Points on moving spheres.

use std::sync::Arc;

use super::{Partials, SurfaceTable};
use crate::geometry::sphere::{partials, row_at_start, surface, uv};
use crate::geometry::{Geometry, Hit, Ray, Surface};
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
    fn find<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>) -> Surface<R> {
        let index = R::index(hit.primitive, self.0.len());
        let (center, radius) = R::gather(&self.0, index, |rows| &rows[0]);
        let (motion, _) = R::gather(&self.0, index, |rows| &rows[1]);
        surface(center + motion * ray.time, radius, ray, hit.t)
    }

    #[inline(always)]
    fn uv<R: Real>(&self, _: &Ray<R>, _: Hit<R>, surface: &Surface<R>) -> (R, R) {
        uv(surface.normal)
    }

    #[inline(always)]
    fn partials<R: Real>(&self, _: &Ray<R>, hit: Hit<R>, surface: &Surface<R>) -> Partials<R> {
        let index = R::index(hit.primitive, self.0.len());
        let (_, radius) = R::gather(&self.0, index, |rows| &rows[0]);
        let [u, v] = partials(surface.normal, radius);
        Partials::new(u, v)
    }
}
