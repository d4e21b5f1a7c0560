//! Points on the triangles of instances.

use std::sync::Arc;

use super::{Partials, SurfaceTable, triangle};
use crate::geometry::triangle::inset;
use crate::geometry::{Geometry, Hit, Ray, Surface};
use crate::math::Real;

/// The triangles of the meshes, and the geometry with the instances.
#[derive(Debug)]
pub(super) struct Table {
    triangles: triangle::Table,
    geometry: Arc<Geometry>,
}

impl SurfaceTable for Table {
    fn new(geometry: &Arc<Geometry>) -> Self {
        let first = geometry.len() as u32;
        let triangles =
            triangle::Table::with_first(first, Arc::clone(geometry.instances.triangles()));
        Self { triangles, geometry: Arc::clone(geometry) }
    }

    #[inline(always)]
    fn find<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>) -> Surface<R> {
        // A copy, so that the ray of other shapes can stay in registers.
        let ray = *ray;
        self.find_apart(&ray, hit)
    }

    #[inline(always)]
    fn uv<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>, surface: &Surface<R>) -> (R, R) {
        let placement = self.geometry.instances.placement::<R>(hit.instance);
        self.triangles.uv(&placement.ray(ray), hit, surface)
    }

    fn second_uv<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>, surface: &Surface<R>) -> (R, R) {
        let placement = self.geometry.instances.placement::<R>(hit.instance);
        self.triangles.second_uv(&placement.ray(ray), hit, surface)
    }

    fn color<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>) -> R::Vec3 {
        let placement = self.geometry.instances.placement::<R>(hit.instance);
        self.triangles.color(&placement.ray(ray), hit)
    }

    fn partials<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>, surface: &Surface<R>) -> Partials<R> {
        let placement = self.geometry.instances.placement::<R>(hit.instance);
        let Partials { u, v, tangent } = self.triangles.partials(&placement.ray(ray), hit, surface);
        let [u, v, tangent] = [u, v, tangent].map(|vector| placement.vector(vector));
        Partials { u, v, tangent }
    }
}

impl Table {
    #[inline(never)]
    fn find_apart<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>) -> Surface<R> {
        let placement = self.geometry.instances.placement::<R>(hit.instance);
        let (surface, face) = self.triangles.find_exactly(&placement.ray(ray), hit);
        let placed = placement.surface(surface);
        // Distances from the edges matter where the triangle is placed.
        let edges = face.edges.map(|edge| placement.vector(edge));
        let point = placement.point(face.point(inset(edges, face.shares, placed.offset)));
        Surface { point, ..placed }
    }
}
