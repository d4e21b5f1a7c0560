//! Quad lights: rectangles uniform in their solid angle, other parallelograms by area.

use super::spherical_rectangle::{Rectangle, SphericalRectangle};
use super::{Chosen, LightKind, LightModel, LightSample, Plane, RECTANGLE, Shone};
use crate::geometry::{self, Ray};
use crate::math::{Mask, Real, normalize, row};

pub(super) struct Quad;

/// Corner; unit edge, width; unit edge, height; normal, area.
pub(super) fn shone(quad: &geometry::Quad) -> Shone {
    let (u, v) = (quad.u.as_dvec3(), quad.v.as_dvec3());
    let (width, height) = (u.dot(u).sqrt(), v.dot(v).sqrt());
    Shone {
        kind: LightKind::Quad,
        area: f64::from(quad.area()),
        flags: if quad.is_rectangle() { RECTANGLE } else { 0 },
        point: quad.q,
        rows: [
            row((u / width).as_vec3(), width as f32),
            row((v / height).as_vec3(), height as f32),
            row(quad.normal, quad.area()),
        ],
    }
}

#[inline(always)]
fn shape<R: Real>(light: &Chosen<'_, R>) -> (Rectangle<R>, Plane<R>) {
    let (corner, _) = light.row(1);
    let ((x, width), (y, height), (normal, area)) = (light.row(2), light.row(3), light.row(4));
    let rectangle = Rectangle { corner, axes: [x, y, normal], size: (width, height) };
    (rectangle, Plane { point: corner, normal, area })
}

impl LightModel for Quad {
    #[inline(always)]
    fn sample<R: Real>(
        light: &Chosen<'_, R>,
        from: R::Vec3,
        _: R,
        (u, v): (R, R),
    ) -> LightSample<R> {
        let (rectangle, plane) = shape(light);
        let spherical = SphericalRectangle::new(&rectangle, from);
        let exact = light.has(RECTANGLE) & spherical.exact;
        let ([x, y, _], (width, height)) = (rectangle.axes, rectangle.size);
        let mut target = rectangle.corner + x * (u * width) + y * (v * height);
        if exact.any() {
            target = exact.select(spherical.sample(u, v), target);
        }
        plane.sample(from, normalize(target - from), exact, spherical.pdf())
    }

    #[inline(always)]
    fn pdf<R: Real>(light: &Chosen<'_, R>, ray: &Ray<R>, t: R) -> R {
        let (rectangle, plane) = shape(light);
        let spherical = SphericalRectangle::new(&rectangle, ray.origin);
        let exact = light.has(RECTANGLE) & spherical.exact;
        exact.select(spherical.pdf(), plane.area_pdf(ray.direction, t))
    }
}
