//! Triangle lights over lanes: uniform in their solid angle.

use super::spherical_triangle::SphericalTriangle;
use super::{Chosen, LightSamples, Planes};
use crate::simd::{Float, Vec3x};

/// [`TriangleLight`](crate::scene::TriangleLight) a lane.
#[derive(Clone, Copy)]
pub(super) struct Triangles {
    pub(super) vertices: [Vec3x; 3],
    pub(super) normal: Vec3x,
    pub(super) area: Float,
}

impl Triangles {
    #[inline(always)]
    fn new(lights: &Chosen<'_>) -> Self {
        let ((p, _), (q, _), (r, _)) = (lights.row(1), lights.row(2), lights.row(3));
        let (normal, area) = lights.row(4);
        Self { vertices: [p, q, r], normal, area }
    }

    #[inline(always)]
    fn planes(&self) -> Planes {
        Planes { point: self.vertices[0], normal: self.normal, area: self.area }
    }
}

#[inline(always)]
pub(super) fn sample(lights: &Chosen<'_>, from: Vec3x, (u, v): (Float, Float)) -> LightSamples {
    let triangles = Triangles::new(lights);
    let spherical = SphericalTriangle::new(&triangles, from);
    let ([a, b, c], root) = (triangles.vertices, u.sqrt());
    let target = a + (b - a) * (root * (Float::splat(1.0) - v)) + (c - a) * (root * v);
    let by_area = (target - from).normalize();
    let direction = Vec3x::select(spherical.exact, spherical.sample(u, v), by_area);
    triangles.planes().sample(from, direction, spherical.exact, spherical.pdf())
}

#[inline(always)]
pub(super) fn pdf(lights: &Chosen<'_>, (origin, direction): (Vec3x, Vec3x), t: Float) -> Float {
    let triangles = Triangles::new(lights);
    let spherical = SphericalTriangle::new(&triangles, origin);
    spherical.exact.select(spherical.pdf(), triangles.planes().area_pdf(direction, t))
}
