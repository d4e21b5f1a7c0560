//! Points on triangles, computed lane by lane because they need f64.

use std::sync::Arc;

use super::SurfaceTable;
use crate::geometry::triangle::Triangle;
use crate::geometry::{Geometry, Ray, Surface};
use crate::math::{Real, Vector};

/// A reference to the geometry, since triangles are read from it directly.
#[derive(Debug)]
pub(super) struct Table {
    /// The index of the first triangle among all primitives.
    first: u32,
    geometry: Arc<Geometry>,
}

impl Table {
    /// Calls `f` with each lane's triangle and ray, and returns the results.
    #[inline(always)]
    fn each<R: Real, const N: usize>(
        &self,
        primitive: R::Word,
        ray: &Ray<R>,
        f: impl Fn(&Triangle, &Ray) -> [f32; N],
    ) -> [R; N] {
        let (o, d) = (ray.origin, ray.direction);
        let numbers = [o[0], o[1], o[2], d[0], d[1], d[2], ray.time];
        R::each_lane(primitive, numbers, |primitive, [ox, oy, oz, dx, dy, dz, time]| {
            let triangle = &self.geometry.triangles[(primitive - self.first) as usize];
            let (origin, direction) = ([ox, oy, oz].into(), [dx, dy, dz].into());
            f(triangle, &Ray { origin, direction, time })
        })
    }
}

impl SurfaceTable for Table {
    fn new(geometry: &Arc<Geometry>) -> Self {
        let first = (geometry.spheres.len() + geometry.quads.len()) as u32;
        Self { first, geometry: Arc::clone(geometry) }
    }

    #[inline(always)]
    fn find<R: Real>(&self, primitive: R::Word, ray: &Ray<R>, _: R) -> Surface<R> {
        let [px, py, pz, nx, ny, nz, offset] = self.each(primitive, ray, |triangle, ray| {
            let Surface { point, normal, offset } = triangle.surface(ray);
            let ([px, py, pz], [nx, ny, nz]) = (point.to_array(), normal.to_array());
            [px, py, pz, nx, ny, nz, offset]
        });
        Surface {
            point: <R::Vec3 as Vector>::new(px, py, pz),
            normal: <R::Vec3 as Vector>::new(nx, ny, nz),
            offset,
        }
    }

    #[inline(always)]
    fn uv<R: Real>(&self, primitive: R::Word, ray: &Ray<R>, _: &Surface<R>, _: R) -> (R, R) {
        let [u, v] = self.each(primitive, ray, |triangle, ray| triangle.uv(ray).into());
        (u, v)
    }
}
