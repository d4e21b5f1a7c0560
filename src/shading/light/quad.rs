//! Quad lights. Rectangles are sampled uniformly in solid angle, other parallelograms by area.

use super::sample::{LightSample, Plane};
use super::spherical_rectangle::{Rectangle, SphericalRectangle};
use super::{LightModel, PrimitiveLight};
use crate::geometry::{Primitive, Ray};
use crate::math::{Mask, Real, Row, normalize, row};

#[derive(Clone, Copy, Debug)]
pub(super) struct QuadLight {
    /// Corner, and 1 for a rectangle or 0 for another parallelogram.
    corner: Row,
    /// Unit vector along the edge `u`, and the width.
    x: Row,
    /// Unit vector along the edge `v`, and the height.
    y: Row,
    /// Normal and area.
    normal: Row,
}

/// Returns the quads as if all were rectangles, their planes, and a mask of those that really are
/// rectangles.
#[inline(always)]
fn shape<R: Real>(table: &[QuadLight], index: R::Index) -> (Rectangle<R>, Plane<R>, R::Mask) {
    let (corner, rectangular) = R::gather(table, index, |light| &light.corner);
    let (x, width) = R::gather(table, index, |light| &light.x);
    let (y, height) = R::gather(table, index, |light| &light.y);
    let (normal, area) = R::gather(table, index, |light| &light.normal);
    let rectangle = Rectangle { corner, axes: [x, y, normal], size: (width, height) };
    (rectangle, Plane { point: corner, normal, area }, rectangular.gt(R::ZERO))
}

impl LightModel for QuadLight {
    fn of(primitive: Primitive) -> Option<PrimitiveLight<Self>> {
        let Primitive::Quad(quad) = primitive else { return None };
        let (u, v) = (quad.u.as_dvec3(), quad.v.as_dvec3());
        let (width, height) = (u.dot(u).sqrt(), v.dot(v).sqrt());
        let light = Self {
            corner: row(quad.q, f32::from(u8::from(quad.is_rectangle()))),
            x: row((u / width).as_vec3(), width as f32),
            y: row((v / height).as_vec3(), height as f32),
            normal: row(quad.normal, quad.area()),
        };
        let normal = Some(quad.normal.as_dvec3());
        Some(PrimitiveLight { light, area: f64::from(quad.area()), normal })
    }

    #[inline(always)]
    fn sample<R: Real>(
        table: &[Self],
        index: R::Index,
        from: R::Vec3,
        _: R,
        (u, v): (R, R),
    ) -> LightSample<R> {
        let (rectangle, plane, rectangular) = shape::<R>(table, index);
        let spherical = SphericalRectangle::new(&rectangle, from);
        let exact = rectangular & spherical.exact;
        let ([x, y, _], (width, height)) = (rectangle.axes, rectangle.size);
        let mut target = rectangle.corner + x * (u * width) + y * (v * height);
        if exact.any() {
            target = exact.select(spherical.sample(u, v), target);
        }
        plane.sample(from, normalize(target - from), exact, spherical.pdf())
    }

    #[inline(always)]
    fn pdf<R: Real>(table: &[Self], index: R::Index, ray: &Ray<R>, t: R) -> R {
        let (rectangle, plane, rectangular) = shape::<R>(table, index);
        let spherical = SphericalRectangle::new(&rectangle, ray.origin);
        let exact = rectangular & spherical.exact;
        exact.select(spherical.pdf(), plane.area_pdf(ray.direction, t))
    }
}
