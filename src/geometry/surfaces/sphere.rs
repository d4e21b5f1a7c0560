//! Points on still spheres.

use std::sync::Arc;

use super::{Partials, SurfaceTable};
use crate::geometry::sphere::{partials, row_at_start, surface, uv};
use crate::geometry::{Geometry, Hit, Ray, Surface};
use crate::math::{Real, Row};

/// [`row_at_start`] of every sphere. Moving spheres are included, so that rows are found by
/// primitive index.
#[derive(Debug)]
pub(super) struct Table(Vec<Row>);

impl SurfaceTable for Table {
    fn new(geometry: &Arc<Geometry>) -> Self {
        Self(geometry.spheres.iter().map(row_at_start).collect())
    }

    #[inline(always)]
    fn find<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>) -> Surface<R> {
        let index = R::index(hit.primitive, self.0.len());
        let (center, radius) = R::gather(&self.0, index, |row| row);
        surface(center, radius, ray, hit.t)
    }

    #[inline(always)]
    fn uv<R: Real>(&self, _: &Ray<R>, _: Hit<R>, surface: &Surface<R>) -> (R, R) {
        uv(surface.normal)
    }

    #[inline(always)]
    fn partials<R: Real>(&self, _: &Ray<R>, hit: Hit<R>, surface: &Surface<R>) -> Partials<R> {
        let index = R::index(hit.primitive, self.0.len());
        let (_, radius) = R::gather(&self.0, index, |row| row);
        let [u, v] = partials(surface.normal, radius);
        Partials::new(u, v)
    }
}
