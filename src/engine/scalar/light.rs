//! Sampling a light from a point: a direction, its density, and how far the light is.

use glam::Vec3;
use std::f32::consts::PI;

use super::spherical_rectangle::SphericalRectangle;
use crate::geometry::{PreparedRay, Primitive, Quad, Ray, Sphere};
use crate::math::warp::{uniform_cone, uniform_cone_pdf, uniform_sphere};
use crate::math::{dot, length, normalize};
use crate::scene::{Light, Scene};

/// A direction from a point to a light.
pub(super) struct LightSample {
    /// Of unit length.
    pub(super) direction: Vec3,
    /// To the light's surface: what a shadow ray must cross freely.
    ///
    /// It is what the light's own test gives for the shadow ray, so that the light never
    /// shadows itself and no epsilon is needed.
    pub(super) distance: f32,
    /// Density of the direction per unit solid angle.
    pub(super) pdf: f32,
    /// Whether the direction meets the light's front.
    pub(super) front: bool,
}

/// A sample of `light` as seen from `from`; `None` where it cannot be seen.
pub(super) fn sample(
    scene: &Scene,
    light: &Light,
    from: Vec3,
    time: f32,
    (u, v): (f32, f32),
) -> Option<LightSample> {
    match (scene.geometry().get(light.primitive), &light.shape) {
        (Primitive::Sphere(sphere), _) => Some(sample_sphere(sphere, from, time, u, v)),
        (Primitive::Quad(quad), shape) => {
            let (target, pdf) = match SphericalRectangle::of(shape, from) {
                Some(spherical) => (spherical.sample(u, v), Some(spherical.pdf())),
                None => (quad.q + quad.u * u + quad.v * v, None),
            };
            let ray = Ray { origin: from, direction: normalize(target - from), time };
            let distance = quad.plane_distance(&ray);
            let pdf = pdf.unwrap_or_else(|| area_pdf(quad, &ray, distance));
            let visible = distance > 0.0 && distance.is_finite() && pdf > 0.0 && pdf.is_finite();
            let front = dot(quad.normal, ray.direction) < 0.0;
            visible.then_some(LightSample { direction: ray.direction, distance, pdf, front })
        }
        (Primitive::Triangle(_), _) => None,
    }
}

/// Density with which [`sample`] at `ray.origin` draws `ray.direction`, which meets the light
/// at distance `t`.
pub(super) fn pdf(scene: &Scene, light: &Light, ray: &Ray, t: f32) -> f32 {
    match (scene.geometry().get(light.primitive), &light.shape) {
        (Primitive::Sphere(sphere), _) => Cone::new(sphere, ray.origin, ray.time).pdf(),
        (Primitive::Quad(quad), shape) => match SphericalRectangle::of(shape, ray.origin) {
            Some(spherical) => spherical.pdf(),
            None => area_pdf(quad, ray, t),
        },
        (Primitive::Triangle(_), _) => 0.0,
    }
}

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

fn sample_sphere(sphere: &Sphere, from: Vec3, time: f32, u: f32, v: f32) -> LightSample {
    let cone = Cone::new(sphere, from, time);
    let direction = match cone.one_minus_cos {
        Some(one_minus_cos) => uniform_cone(normalize(cone.to_center), one_minus_cos, u, v),
        None => uniform_sphere(u, v),
    };
    let ray = Ray { origin: from, direction, time };
    let distance = Primitive::Sphere(sphere)
        .intersect(&PreparedRay::new(&ray), 0.0, f32::INFINITY)
        // At the silhouette rounding may miss the sphere, which is then as far as its centre.
        .unwrap_or_else(|| dot(cone.to_center, direction));
    LightSample { direction, distance, pdf: cone.pdf(), front: cone.one_minus_cos.is_some() }
}

/// Density per unit solid angle of points uniform on `quad`, at `distance` along `ray`.
fn area_pdf(quad: &Quad, ray: &Ray, distance: f32) -> f32 {
    distance * distance / (quad.area() * dot(quad.normal, ray.direction).abs())
}
