//! Scattering at a surface, a function a material.

use glam::Vec3;
use std::f32::consts::PI;

use crate::engine::dimension::{Dimension, Randoms};
use crate::geometry::{Ray, Surface};
use crate::math::warp::{cosine_hemisphere, uniform_ball, uniform_hemisphere};
use crate::math::{dot, max, min, normalize};

/// The next segment of a path.
pub(super) struct Scatter {
    pub(super) origin: Vec3,
    /// Of unit length.
    pub(super) direction: Vec3,
    /// f·cos θ/pdf.
    pub(super) weight: Vec3,
}

/// A diffuse surface seen from one side: Lambert's law (`cosine`; report, III.C) or the
/// report's ideal diffuse, uniform over the hemisphere (III.B).
pub(super) struct Diffuse {
    /// On the side that was hit.
    pub(super) normal: Vec3,
    /// ρ, which is also the weight of every sample.
    pub(super) albedo: Vec3,
    pub(super) cosine: bool,
}

impl Diffuse {
    /// A direction and its density per unit solid angle.
    pub(super) fn sample(&self, (u, v): (f32, f32)) -> (Vec3, f32) {
        if self.cosine {
            let (direction, cos) = cosine_hemisphere(self.normal, u, v);
            (direction, cos * (1.0 / PI))
        } else {
            (uniform_hemisphere(self.normal, u, v).0, 0.5 / PI)
        }
    }

    /// f·cos θ without ρ, and the density with which [`Self::sample`] draws a direction at
    /// angle θ: they are equal, and 0 below the surface.
    pub(super) fn evaluate(&self, cos: f32) -> (f32, f32) {
        let value = match cos > 0.0 {
            true if self.cosine => cos * (1.0 / PI),
            true => 0.5 / PI,
            false => 0.0,
        };
        (value, value)
    }
}

/// Mirror direction moved by `fuzz` times a point of the unit ball; `None` where that lies
/// below the surface and is absorbed (report, III.D).
pub(super) fn metal(
    ray: &Ray,
    surface: &Surface,
    normal: Vec3,
    albedo: Vec3,
    fuzz: f32,
    randoms: &Randoms,
) -> Option<Scatter> {
    let mirror = reflect(ray.direction, normal);
    let (u, v) = randoms.two(Dimension::SCATTER);
    let blur = uniform_ball(u, v, randoms.one(Dimension::BALL));
    let direction = normalize(mirror + blur * fuzz);
    // False for NaN too, where the blur undoes the mirror direction exactly.
    let above = dot(direction, normal) > 0.0;
    above.then(|| Scatter { origin: surface.spawn(normal), direction, weight: albedo })
}

/// Reflection or refraction, chosen by Schlick's approximation (report, III.E).
pub(super) fn dielectric(
    ray: &Ray,
    surface: &Surface,
    normal: Vec3,
    front: bool,
    ior: f32,
    randoms: &Randoms,
) -> Scatter {
    let eta = if front { 1.0 / ior } else { ior };
    let cos = min(-dot(ray.direction, normal), 1.0);
    let sin2_refracted = eta * eta * (1.0 - cos * cos);
    let reflected = sin2_refracted > 1.0 || randoms.one(Dimension::LOBE) < schlick(cos, ior);
    let (side, direction) = if reflected {
        (normal, normalize(reflect(ray.direction, normal)))
    } else {
        let along = eta * cos - max(0.0, 1.0 - sin2_refracted).sqrt();
        (-normal, normalize(ray.direction * eta + normal * along))
    };
    Scatter { origin: surface.spawn(side), direction, weight: Vec3::ONE }
}

fn reflect(direction: Vec3, normal: Vec3) -> Vec3 {
    direction - normal * (2.0 * dot(direction, normal))
}

/// Reflectance at the cosine of the angle of incidence (Schlick 1994).
fn schlick(cos: f32, ior: f32) -> f32 {
    let r = (1.0 - ior) / (1.0 + ior);
    let r0 = r * r;
    let x = 1.0 - cos;
    let x2 = x * x;
    r0 + (1.0 - r0) * (x2 * x2 * x)
}
