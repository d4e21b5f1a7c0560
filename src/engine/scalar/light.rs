//! Sampling a light from a point: a direction, its density, and how far the light is.

use glam::Vec3;
use std::f32::consts::PI;

use super::spherical_rectangle::SphericalRectangle;
use crate::geometry::{PreparedRay, Primitive, Quad, Ray, Sphere};
use crate::math::warp::{uniform_cone, uniform_cone_pdf, uniform_sphere};
use crate::math::{dot, length, normalize};
use crate::scene::{Light, LightShape, Scene};

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
        (Primitive::Quad(quad), LightShape::Rectangle(rectangle)) => {
            let target = match SphericalRectangle::new(rectangle, from) {
                Some(spherical) => spherical.sample(u, v),
                None => quad.q + quad.u * u + quad.v * v,
            };
            sample_quad(light, quad, from, time, target)
        }
        (Primitive::Quad(quad), _) => {
            sample_quad(light, quad, from, time, quad.q + quad.u * u + quad.v * v)
        }
        (Primitive::Triangle(_), _) => None,
    }
}

/// Density with which [`sample`] at `ray.origin` draws `ray.direction`, which meets the light
/// at distance `t`.
pub(super) fn pdf(scene: &Scene, light: &Light, ray: &Ray, t: f32) -> f32 {
    match (scene.geometry().get(light.primitive), &light.shape) {
        (Primitive::Sphere(sphere), _) => Cone::new(sphere, ray.origin, ray.time).pdf(),
        (Primitive::Quad(quad), shape) => quad_pdf(shape, quad, ray, t),
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

fn sample_quad(
    light: &Light,
    quad: &Quad,
    from: Vec3,
    time: f32,
    target: Vec3,
) -> Option<LightSample> {
    let direction = normalize(target - from);
    let ray = Ray { origin: from, direction, time };
    let distance = quad.plane_distance(&ray);
    let pdf = quad_pdf(&light.shape, quad, &ray, distance);
    let visible = distance > 0.0 && distance.is_finite() && pdf > 0.0 && pdf.is_finite();
    let front = dot(quad.normal, direction) < 0.0;
    visible.then_some(LightSample { direction, distance, pdf, front })
}

fn quad_pdf(shape: &LightShape, quad: &Quad, ray: &Ray, distance: f32) -> f32 {
    let by_area = |area: f32| distance * distance / (area * dot(quad.normal, ray.direction).abs());
    match shape {
        LightShape::Rectangle(rectangle) => match SphericalRectangle::new(rectangle, ray.origin) {
            Some(spherical) => spherical.pdf(),
            None => by_area(rectangle.area),
        },
        LightShape::Parallelogram { area } => by_area(*area),
        LightShape::Sphere => 0.0,
    }
}
