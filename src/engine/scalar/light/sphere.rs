//! Sphere lights: uniform in the cone that they fill.

use glam::Vec3;
use std::f32::consts::PI;

use super::LightSample;
use crate::geometry::{PreparedRay, Primitive, Ray, Sphere};
use crate::math::warp::{uniform_cone, uniform_cone_pdf, uniform_sphere};
use crate::math::{dot, length, normalize};

/// The cone that a sphere fills as seen from a point.
struct Cone {
    to_center: Vec3,
    /// 1 − cos of the half angle; `None` inside the sphere.
    one_minus_cos: Option<f32>,
}

impl Cone {
    fn new(sphere: &Sphere, from: Vec3, time: f32) -> Self {
        let to_center = sphere.center_at(time) - from;
        let (d, r) = (length(to_center), sphere.radius);
        let one_minus_cos = (d > r).then(|| {
            let d2 = d * d;
            // cos² as a product: 1 − sin² would cancel for narrow cones and near surfaces.
            let cos = ((d - r) * (d + r) / d2).sqrt();
            (r * r / d2) / (1.0 + cos)
        });
        Self { to_center, one_minus_cos }
    }

    fn pdf(&self) -> f32 {
        self.one_minus_cos.map_or(0.25 / PI, uniform_cone_pdf)
    }
}

pub(super) fn sample(light: &Sphere, from: Vec3, time: f32, u: f32, v: f32) -> LightSample {
    let cone = Cone::new(light, from, time);
    let direction = match cone.one_minus_cos {
        Some(one_minus_cos) => uniform_cone(normalize(cone.to_center), one_minus_cos, u, v),
        None => uniform_sphere(u, v),
    };
    let ray = Ray { origin: from, direction, time };
    let distance = Primitive::Sphere(light)
        .intersect(&PreparedRay::new(&ray), 0.0, f32::INFINITY)
        // At the silhouette rounding may miss the sphere, which is then as far as its centre.
        .unwrap_or_else(|| dot(cone.to_center, direction));
    let front = cone.one_minus_cos.is_some();
    LightSample { direction, distance, pdf: cone.pdf(), front }
}

pub(super) fn pdf(light: &Sphere, ray: &Ray) -> f32 {
    Cone::new(light, ray.origin, ray.time).pdf()
}
