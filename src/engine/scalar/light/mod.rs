//! Sampling a light from a point: a direction, its density, and how far the light is.

mod quad;
mod sphere;
mod spherical_rectangle;
mod spherical_triangle;
mod triangle;

use glam::Vec3;

use crate::geometry::Ray;
use crate::math::dot;
use crate::scene::{Light, LightShape};

/// A direction from a point to a light.
pub(in crate::engine) struct LightSample {
    /// Of unit length.
    pub(in crate::engine) direction: Vec3,
    /// How far the light is.
    pub(in crate::engine) distance: f32,
    /// Density of the direction per unit solid angle.
    pub(in crate::engine) pdf: f32,
    /// Whether the direction meets the light's front.
    pub(in crate::engine) front: bool,
}

/// A sample of `light` as seen from `from`; `None` where it cannot be seen.
pub(in crate::engine) fn sample(
    light: &Light,
    from: Vec3,
    time: f32,
    (u, v): (f32, f32),
) -> Option<LightSample> {
    match &light.shape {
        LightShape::Sphere(light) => Some(sphere::sample(light, from, time, u, v)),
        LightShape::Quad(light) => quad::sample(light, from, u, v),
        LightShape::Triangle(light) => triangle::sample(light, from, u, v),
    }
}

/// Density with which [`sample`] at `ray.origin` draws `ray.direction`, which meets the light
/// at distance `t`.
pub(in crate::engine) fn pdf(light: &Light, ray: &Ray, t: f32) -> f32 {
    match &light.shape {
        LightShape::Sphere(light) => sphere::pdf(light, ray),
        LightShape::Quad(light) => quad::pdf(light, ray, t),
        LightShape::Triangle(light) => triangle::pdf(light, ray, t),
    }
}

/// A flat light's plane.
struct Plane {
    point: Vec3,
    normal: Vec3,
    area: f32,
}

impl Plane {
    /// The sample in this direction: of density `pdf`, or that of a point uniform by area.
    fn sample(&self, from: Vec3, direction: Vec3, pdf: Option<f32>) -> Option<LightSample> {
        let slope = dot(self.normal, direction);
        let distance = -dot(self.normal, from - self.point) / slope;
        let pdf = pdf.unwrap_or_else(|| self.area_pdf(direction, distance));
        let visible = distance > 0.0 && distance.is_finite() && pdf > 0.0 && pdf.is_finite();
        visible.then_some(LightSample { direction, distance, pdf, front: slope < 0.0 })
    }

    /// Density per unit solid angle of points uniform by area, at `distance` in this direction.
    fn area_pdf(&self, direction: Vec3, distance: f32) -> f32 {
        distance * distance / (self.area * dot(self.normal, direction).abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::contract::SHADOW_REACH;
    use crate::geometry::Primitive;
    use crate::math::random::Stream;
    use crate::scene::Scene;

    /// What a program with other rounding finds: the light beyond the reach of every shadow ray.
    #[test]
    fn shadow_rays_end_just_before_their_light() {
        let mut random = Stream::new(3);
        let tilted = r#"(
            camera: (look_from: (0, 0, 9), look_at: (0, 0, 0), vfov: 40),
            materials: {"lamp": light(radiance: (1, 1, 1))},
            primitives: [
                quad(q: (343, 300, 332), u: (-130, 37, 11), v: (13, 20, -105), material: "lamp"),
                moving_sphere(center: (50, 40, 30), center1: (60, 45, 30), radius: 40, material: "lamp"),
                triangles(vertices: [(300, 200, 400), (420, 230, 380), (350, 310, 420)], indices: [(0, 1, 2)],
                          material: "lamp"),
            ],
        )"#;
        let scenes = [
            ("cornell", Scene::load("cornell"), 555.0),
            ("checker", Scene::load("checker"), 20.0),
            ("tilted", Scene::from_ron(tilted), 555.0),
        ];
        for (name, scene, extent) in scenes {
            let scene = scene.unwrap();
            let mut checked = 0;
            for light in scene.lights().all() {
                for _ in 0..100_000 {
                    let [x, y, z, u, v, time] = [(); 6].map(|()| random.uniform());
                    let from = Vec3::new(x, y, z) * extent;
                    let Some(sample) = sample(light, from, time, (u, v)) else { continue };
                    let (origin, direction) = (from.as_dvec3(), sample.direction.as_dvec3());
                    let on_plane = |point: Vec3, u: Vec3, v: Vec3| {
                        let normal = u.as_dvec3().cross(v.as_dvec3()).normalize();
                        let slope = normal.dot(direction);
                        // Grazing rays see the plane's rounding magnified.
                        (slope.abs() > 0.01).then(|| normal.dot(point.as_dvec3() - origin) / slope)
                    };
                    let distance = match scene.geometry().get(light.primitive) {
                        Primitive::Quad(quad) => on_plane(quad.q, quad.u, quad.v),
                        Primitive::Triangle(triangle) => {
                            let [a, b, c] = triangle.vertices;
                            on_plane(a, b - a, c - a)
                        }
                        Primitive::Sphere(sphere) => {
                            let to_center = sphere.center_at(time).as_dvec3() - origin;
                            let ahead = to_center.dot(direction);
                            let distance2 = to_center.dot(to_center);
                            let aside2 = distance2 - ahead * ahead;
                            let radius2 = f64::from(sphere.radius) * f64::from(sphere.radius);
                            // Not from inside, nor at the silhouette where rounding is root of ε.
                            (distance2 > radius2 && radius2 - aside2 > 0.01 * radius2)
                                .then(|| ahead - (radius2 - aside2).sqrt())
                        }
                    };
                    let Some(distance) = distance else { continue };
                    let short = 1.0 - f64::from(sample.distance * SHADOW_REACH) / distance;
                    assert!((short - 1e-4).abs() < 5e-5, "{name} {from}: {short:e}");
                    checked += 1;
                }
            }
            assert!(checked > 50_000, "{name}: {checked}");
        }
    }
}
