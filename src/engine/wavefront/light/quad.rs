//! Quad lights over lanes: rectangles uniform in their solid angle, other parallelograms by area.

use super::spherical_rectangle::SphericalRectangle;
use super::table::RECTANGLE;
use super::{Chosen, LightSamples, Planes, is_set};
use crate::simd::{Float, Mask, Vec3x};

/// [`QuadLight`](crate::scene::QuadLight) a lane.
#[derive(Clone, Copy)]
pub(super) struct Quads {
    pub(super) corner: Vec3x,
    pub(super) axes: [Vec3x; 3],
    pub(super) size: (Float, Float),
    area: Float,
    rectangle: Mask,
}

impl Quads {
    #[inline(always)]
    fn new(lights: &Chosen<'_>) -> Self {
        let ((_, flags), (corner, _)) = (lights.row(0), lights.row(1));
        let ((x, width), (y, height)) = (lights.row(2), lights.row(3));
        let (normal, area) = lights.row(4);
        let rectangle = is_set(flags, RECTANGLE);
        Self { corner, axes: [x, y, normal], size: (width, height), area, rectangle }
    }

    #[inline(always)]
    fn planes(&self) -> Planes {
        Planes { point: self.corner, normal: self.axes[2], area: self.area }
    }
}

#[inline(always)]
pub(super) fn sample(lights: &Chosen<'_>, from: Vec3x, (u, v): (Float, Float)) -> LightSamples {
    let quads = Quads::new(lights);
    let ([x, y, _], (width, height)) = (quads.axes, quads.size);
    let spherical = SphericalRectangle::new(&quads, from);
    let exact = quads.rectangle & spherical.exact;
    let by_area = quads.corner + x * (u * width) + y * (v * height);
    let target = Vec3x::select(exact, spherical.sample(u, v), by_area);
    quads.planes().sample(from, (target - from).normalize(), exact, spherical.pdf())
}

#[inline(always)]
pub(super) fn pdf(lights: &Chosen<'_>, (origin, direction): (Vec3x, Vec3x), t: Float) -> Float {
    let quads = Quads::new(lights);
    let spherical = SphericalRectangle::new(&quads, origin);
    let exact = quads.rectangle & spherical.exact;
    exact.select(spherical.pdf(), quads.planes().area_pdf(direction, t))
}
