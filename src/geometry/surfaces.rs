//! The points where rays hit primitives, from tables that vectors can read.

use std::sync::Arc;

use super::{Geometry, Primitive, Ray, Shape, Surface, quad, sphere, triangle};
use crate::math::{Real, Row, Word, row};

/// A geometry's primitives in rows.
#[derive(Debug)]
pub(crate) struct Surfaces {
    geometry: Arc<Geometry>,
    spheres: Vec<Row>,
    /// Of the spheres, if any moves.
    motions: Vec<Row>,
    quads: Vec<[Row; 5]>,
}

impl Surfaces {
    pub(crate) fn new(geometry: &Arc<Geometry>) -> Self {
        let moving = if geometry.moves() { &geometry.spheres[..] } else { &[] };
        Self {
            spheres: geometry.spheres.iter().map(sphere::row_at_start).collect(),
            motions: moving.iter().map(|sphere| row(sphere.motion(), 0.0)).collect(),
            quads: geometry.quads.iter().map(quad::rows).collect(),
            geometry: Arc::clone(geometry),
        }
    }

    /// The points that `ray` hits at distance `t`: on primitives of one shape.
    #[inline(always)]
    pub(crate) fn find<R: Real>(
        &self,
        shape: Shape,
        primitive: R::Word,
        ray: &Ray<R>,
        t: R,
    ) -> Surface<R> {
        match shape {
            Shape::Sphere => {
                let index = R::index(primitive, self.spheres.len());
                let (center, radius) = R::gather(&self.spheres, index, |row| row);
                sphere::surface(center, radius, ray, t)
            }
            Shape::MovingSphere => {
                let index = R::index(primitive, self.spheres.len());
                let (center, radius) = R::gather(&self.spheres, index, |row| row);
                let (motion, _) = R::gather(&self.motions, index, |row| row);
                sphere::surface(center + motion * ray.time, radius, ray, t)
            }
            Shape::Quad => quad::surface(&self.quads, self.quad::<R>(primitive), ray, t),
            Shape::Triangle => {
                let [px, py, pz, nx, ny, nz, offset] =
                    self.triangle(primitive, ray, |triangle, ray| {
                        let Surface { point, normal, offset } = triangle.surface(ray);
                        let ([px, py, pz], [nx, ny, nz]) = (point.to_array(), normal.to_array());
                        [px, py, pz, nx, ny, nz, offset]
                    });
                let (point, normal) = (vector::<R>([px, py, pz]), vector::<R>([nx, ny, nz]));
                Surface { point, normal, offset }
            }
        }
    }

    /// The texture coordinates of such points, both in [0, 1] up to rounding.
    pub(crate) fn uv<R: Real>(
        &self,
        shape: Shape,
        primitive: R::Word,
        ray: &Ray<R>,
        surface: &Surface<R>,
        t: R,
    ) -> (R, R) {
        match shape {
            Shape::Sphere | Shape::MovingSphere => sphere::uv(surface.normal),
            Shape::Quad => quad::uv(&self.quads, self.quad::<R>(primitive), ray, t),
            Shape::Triangle => {
                let [u, v] = self.triangle(primitive, ray, |triangle, ray| triangle.uv(ray).into());
                (u, v)
            }
        }
    }

    #[inline(always)]
    fn quad<R: Real>(&self, primitive: R::Word) -> R::Index {
        let first = R::Word::splat(self.spheres.len() as u32);
        R::index(primitive.wrapping_sub(first), self.quads.len())
    }

    /// `f` of triangles and rays, one by one: it is in f64.
    #[inline(always)]
    fn triangle<R: Real, const N: usize>(
        &self,
        primitive: R::Word,
        ray: &Ray<R>,
        f: impl Fn(&triangle::Triangle, &Ray) -> [f32; N],
    ) -> [R; N] {
        let (o, d) = (ray.origin, ray.direction);
        let numbers = [o[0], o[1], o[2], d[0], d[1], d[2], ray.time];
        R::each_lane(primitive, numbers, |primitive, [ox, oy, oz, dx, dy, dz, time]| {
            let (origin, direction) = ([ox, oy, oz].into(), [dx, dy, dz].into());
            match self.geometry.get(primitive) {
                Primitive::Triangle(triangle) => f(triangle, &Ray { origin, direction, time }),
                other => unreachable!("{other:?} is no triangle"),
            }
        })
    }
}

#[inline(always)]
fn vector<R: Real>([x, y, z]: [R; 3]) -> R::Vec3 {
    <R::Vec3 as crate::math::Vector>::new(x, y, z)
}
