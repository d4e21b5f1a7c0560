//! Quad lights: rectangles uniform in their solid angle, other parallelograms by area.

use glam::Vec3;

use super::spherical_rectangle::SphericalRectangle;
use super::{LightSample, Plane};
use crate::geometry::Ray;
use crate::math::normalize;
use crate::scene::QuadLight;

pub(super) fn sample(light: &QuadLight, from: Vec3, u: f32, v: f32) -> Option<LightSample> {
    let (target, pdf) = match SphericalRectangle::of(light, from) {
        Some(spherical) => (spherical.sample(u, v), Some(spherical.pdf())),
        None => {
            let ([x, y, _], (width, height)) = (light.axes, light.size);
            (light.corner + x * (u * width) + y * (v * height), None)
        }
    };
    plane(light).sample(from, normalize(target - from), pdf)
}

pub(super) fn pdf(light: &QuadLight, ray: &Ray, t: f32) -> f32 {
    match SphericalRectangle::of(light, ray.origin) {
        Some(spherical) => spherical.pdf(),
        None => plane(light).area_pdf(ray.direction, t),
    }
}

fn plane(light: &QuadLight) -> Plane {
    Plane { point: light.corner, normal: light.axes[2], area: light.area }
}
