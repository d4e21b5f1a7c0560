//! Sampling a light from a point: a direction, its density, and how far the light is.

use glam::Vec3;
use std::f32::consts::PI;

use super::spherical_rectangle::SphericalRectangle;
use crate::engine::contract::SHADOW_REACH;
use crate::geometry::{PreparedRay, Primitive, Quad, Ray, Sphere};
use crate::math::warp::{uniform_cone, uniform_cone_pdf, uniform_sphere};
use crate::math::{dot, length, normalize};
use crate::scene::{Light, Scene};

/// A direction from a point to a light.
pub(in crate::engine) struct LightSample {
    /// Of unit length.
    pub(in crate::engine) direction: Vec3,
    /// What a shadow ray must cross freely: the way to the light, but for its last 10⁻⁴.
    ///
    /// There lie the light itself, with what rounding does to its distance in this or another
    /// program (but for grazing rays and silhouettes), and surfaces that are flush with it.
    pub(in crate::engine) reach: f32,
    /// Density of the direction per unit solid angle.
    pub(in crate::engine) pdf: f32,
    /// Whether the direction meets the light's front.
    pub(in crate::engine) front: bool,
}

/// A sample of `light` as seen from `from`; `None` where it cannot be seen.
pub(in crate::engine) fn sample(
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
            let reach = distance * SHADOW_REACH;
            visible.then_some(LightSample { direction: ray.direction, reach, pdf, front })
        }
        (Primitive::Triangle(_), _) => None,
    }
}

/// Density with which [`sample`] at `ray.origin` draws `ray.direction`, which meets the light
/// at distance `t`.
pub(in crate::engine) fn pdf(scene: &Scene, light: &Light, ray: &Ray, t: f32) -> f32 {
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
    let front = cone.one_minus_cos.is_some();
    LightSample { direction, reach: distance * SHADOW_REACH, pdf: cone.pdf(), front }
}

/// Density per unit solid angle of points uniform on `quad`, at `distance` along `ray`.
fn area_pdf(quad: &Quad, ray: &Ray, distance: f32) -> f32 {
    distance * distance / (quad.area() * dot(quad.normal, ray.direction).abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;

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
            for light in scene.lights() {
                for _ in 0..100_000 {
                    let [x, y, z, u, v, time] = [(); 6].map(|()| random.uniform());
                    let from = Vec3::new(x, y, z) * extent;
                    let Some(sample) = sample(&scene, light, from, time, (u, v)) else { continue };
                    let (origin, direction) = (from.as_dvec3(), sample.direction.as_dvec3());
                    let distance = match scene.geometry().get(light.primitive) {
                        Primitive::Quad(quad) => {
                            let normal = quad.u.as_dvec3().cross(quad.v.as_dvec3()).normalize();
                            // Grazing rays see the plane's rounding magnified.
                            if normal.dot(direction).abs() < 0.01 {
                                continue;
                            }
                            normal.dot(quad.q.as_dvec3() - origin) / normal.dot(direction)
                        }
                        Primitive::Sphere(sphere) => {
                            let to_center = sphere.center_at(time).as_dvec3() - origin;
                            let ahead = to_center.dot(direction);
                            let aside2 = to_center.dot(to_center) - ahead * ahead;
                            let radius = f64::from(sphere.radius);
                            let radius2 = radius * radius;
                            // From inside, and at the silhouette where rounding is root of ε.
                            if to_center.dot(to_center) < radius2
                                || radius2 - aside2 < 0.01 * radius2
                            {
                                continue;
                            }
                            ahead - (radius2 - aside2).sqrt()
                        }
                        Primitive::Triangle(_) => unreachable!("triangles are not sampled"),
                    };
                    let short = 1.0 - f64::from(sample.reach) / distance;
                    assert!((short - 1e-4).abs() < 5e-5, "{name} {from}: {short:e}");
                    checked += 1;
                }
            }
            assert!(checked > 50_000, "{name}: {checked}");
        }
    }
}
