//! Triangle lights, sampled uniformly in solid angle.

use glam::DVec3;

use super::sample::{LightSample, Plane};
use super::spherical_triangle::SphericalTriangle;
use super::{LightModel, PrimitiveLight};
use crate::geometry::{Primitive, Ray};
use crate::math::{Mask, Real, Row, normalize, row};

#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleLight {
    vertices: [Row; 3],
    /// Normal, area.
    normal: Row,
}

/// Returns the vertices and planes of the lights at `index`.
#[inline(always)]
fn shape<R: Real>(table: &[TriangleLight], index: R::Index) -> ([R::Vec3; 3], Plane<R>) {
    let vertex = |i: usize| R::gather(table, index, |light| &light.vertices[i]).0;
    let (normal, area) = R::gather(table, index, |light| &light.normal);
    let vertices = [vertex(0), vertex(1), vertex(2)];
    (vertices, Plane { point: vertices[0], normal, area })
}

impl LightModel for TriangleLight {
    fn of(primitive: Primitive) -> Option<PrimitiveLight<Self>> {
        let Primitive::Triangle(triangle) = primitive else { return None };
        let [a, b, c] = triangle.vertices.map(|v| v.as_dvec3());
        let normal: DVec3 = (b - a).cross(c - a);
        let twice = normal.dot(normal).sqrt();
        let area = (0.5 * twice) as f32;
        let vertices = triangle.vertices.map(|vertex| row(vertex, 0.0));
        let normal = normal / twice;
        let light = Self { vertices, normal: row(normal.as_vec3(), area) };
        Some(PrimitiveLight { light, area: f64::from(area), normal: Some(normal) })
    }

    #[inline(always)]
    fn sample<R: Real>(
        table: &[Self],
        index: R::Index,
        from: R::Vec3,
        _: R,
        (u, v): (R, R),
    ) -> LightSample<R> {
        let (vertices, plane) = shape::<R>(table, index);
        let spherical = SphericalTriangle::new(vertices, &plane, from);
        // A point distributed uniformly over the area, by the square-root mapping (Turk 1990).
        let ([a, b, c], root) = (vertices, u.sqrt());
        let target = a + (b - a) * (root * (R::ONE - v)) + (c - a) * (root * v);
        let mut direction = normalize(target - from);
        if spherical.exact.any() {
            direction = spherical.exact.select(spherical.sample(u, v), direction);
        }
        plane.sample(from, direction, spherical.exact, spherical.pdf())
    }

    #[inline(always)]
    fn pdf<R: Real>(table: &[Self], index: R::Index, ray: &Ray<R>, t: R) -> R {
        let (vertices, plane) = shape::<R>(table, index);
        let spherical = SphericalTriangle::new(vertices, &plane, ray.origin);
        spherical.exact.select(spherical.pdf(), plane.area_pdf(ray.direction, t))
    }
}
