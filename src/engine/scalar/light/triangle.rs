//! Triangle lights: uniform in their solid angle.

use glam::Vec3;

use super::spherical_triangle::SphericalTriangle;
use super::{LightSample, Plane};
use crate::geometry::Ray;
use crate::math::normalize;
use crate::scene::TriangleLight;

pub(super) fn sample(light: &TriangleLight, from: Vec3, u: f32, v: f32) -> Option<LightSample> {
    let (direction, pdf) = match SphericalTriangle::new(light, from) {
        Some(spherical) => (spherical.sample(u, v), Some(spherical.pdf())),
        None => {
            // Uniform by area: the corner beyond the diagonal is folded back (Turk 1990, with roots).
            let [a, b, c] = light.vertices;
            let root = u.sqrt();
            let target = a + (b - a) * (root * (1.0 - v)) + (c - a) * (root * v);
            (normalize(target - from), None)
        }
    };
    plane(light).sample(from, direction, pdf)
}

pub(super) fn pdf(light: &TriangleLight, ray: &Ray, t: f32) -> f32 {
    match SphericalTriangle::new(light, ray.origin) {
        Some(spherical) => spherical.pdf(),
        None => plane(light).area_pdf(ray.direction, t),
    }
}

fn plane(light: &TriangleLight) -> Plane {
    Plane { point: light.vertices[0], normal: light.normal, area: light.area }
}
