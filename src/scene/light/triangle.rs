//! Triangle lights: uniform in their solid angle.

use glam::DVec3;

use super::spherical_triangle::SphericalTriangle;
use super::{Chosen, LightKind, LightModel, LightSample, Plane, Shone};
use crate::geometry::{self, Ray};
use crate::math::{Mask, Real, normalize, row};

pub(super) struct Triangle;

/// A vertex; the others; normal, area.
pub(super) fn shone(triangle: &geometry::Triangle) -> Shone {
    let [a, b, c] = triangle.vertices.map(|v| v.as_dvec3());
    let normal: DVec3 = (b - a).cross(c - a);
    let twice = normal.dot(normal).sqrt();
    let area = (0.5 * twice) as f32;
    let [p, q, r] = triangle.vertices;
    Shone {
        kind: LightKind::Triangle,
        area: f64::from(area),
        flags: 0,
        point: p,
        rows: [row(q, 0.0), row(r, 0.0), row((normal / twice).as_vec3(), area)],
    }
}

#[inline(always)]
fn shape<R: Real>(light: &Chosen<'_, R>) -> ([R::Vec3; 3], Plane<R>) {
    let ((p, _), (q, _), (r, _)) = (light.row(1), light.row(2), light.row(3));
    let (normal, area) = light.row(4);
    ([p, q, r], Plane { point: p, normal, area })
}

impl LightModel for Triangle {
    #[inline(always)]
    fn sample<R: Real>(
        light: &Chosen<'_, R>,
        from: R::Vec3,
        _: R,
        (u, v): (R, R),
    ) -> LightSample<R> {
        let (vertices, plane) = shape(light);
        let spherical = SphericalTriangle::new(vertices, &plane, from);
        // Uniform by area: the corner beyond the diagonal is folded back (Turk 1990, with roots).
        let ([a, b, c], root) = (vertices, u.sqrt());
        let target = a + (b - a) * (root * (R::ONE - v)) + (c - a) * (root * v);
        let mut direction = normalize(target - from);
        if spherical.exact.any() {
            direction = spherical.exact.select(spherical.sample(u, v), direction);
        }
        plane.sample(from, direction, spherical.exact, spherical.pdf())
    }

    #[inline(always)]
    fn pdf<R: Real>(light: &Chosen<'_, R>, ray: &Ray<R>, t: R) -> R {
        let (vertices, plane) = shape(light);
        let spherical = SphericalTriangle::new(vertices, &plane, ray.origin);
        spherical.exact.select(spherical.pdf(), plane.area_pdf(ray.direction, t))
    }
}
