//! Sampling a light from points, over lanes: what the scalar engine finds, to the bit.

mod rectangle;

use std::f32::consts::PI;

use crate::engine::contract::SHADOW_REACH;
use crate::geometry::lanes::{RayLanes, sphere};
use crate::geometry::{Primitive, Quad, Sphere};
use crate::scene::{Light, LightShape, Scene};
use crate::simd::warp::{uniform_cone, uniform_cone_pdf, uniform_sphere};
use crate::simd::{Float, Mask, Vec3x};
use rectangle::SphericalRectangle;

/// A direction to a light a lane.
#[derive(Clone, Copy)]
pub(super) struct LightSamples {
    /// Of unit length.
    pub(super) direction: Vec3x,
    /// What a shadow ray must cross freely.
    pub(super) reach: Float,
    /// Density of the direction per unit solid angle.
    pub(super) pdf: Float,
    /// Whether the direction meets the light's front.
    pub(super) front: Mask,
    /// Whether the light can be seen at all; where it cannot, the rest means nothing.
    pub(super) visible: Mask,
}

/// Samples of `light` as seen from `from`.
#[inline(always)]
pub(super) fn sample(
    scene: &Scene,
    light: &Light,
    from: Vec3x,
    time: Float,
    (u, v): (Float, Float),
) -> LightSamples {
    match (scene.geometry().get(light.primitive), &light.shape) {
        (Primitive::Sphere(sphere), _) => sample_sphere(sphere, from, time, u, v),
        (Primitive::Quad(quad), shape) => sample_quad(quad, shape, from, u, v),
        (Primitive::Triangle(_), _) => unreachable!("triangles are not sampled"),
    }
}

/// Density with which [`sample`] at `origin` draws `direction`, which meets the light at distance
/// `t`.
#[inline(always)]
pub(super) fn pdf(
    scene: &Scene,
    light: &Light,
    (origin, direction): (Vec3x, Vec3x),
    time: Float,
    t: Float,
) -> Float {
    match (scene.geometry().get(light.primitive), &light.shape) {
        (Primitive::Sphere(sphere), _) => Cones::new(sphere, origin, time).pdf(),
        (Primitive::Quad(quad), LightShape::Rectangle(rectangle)) => {
            let spherical = SphericalRectangle::new(rectangle, origin);
            spherical.exact.select(spherical.pdf(), area_pdf(quad, direction, t))
        }
        (Primitive::Quad(quad), _) => area_pdf(quad, direction, t),
        (Primitive::Triangle(_), _) => unreachable!("triangles are not sampled"),
    }
}

/// The cones that a sphere fills as seen from points.
struct Cones {
    center: Vec3x,
    to_center: Vec3x,
    /// Whether the point is outside the sphere.
    outside: Mask,
    /// 1 − cos of the half angle, there.
    one_minus_cos: Float,
}

impl Cones {
    #[inline(always)]
    fn new(sphere: &Sphere, from: Vec3x, time: Float) -> Self {
        let center = Vec3x::splat(sphere.center) + Vec3x::splat(sphere.motion()) * time;
        let to_center = center - from;
        let (d, r) = (to_center.dot(to_center).sqrt(), Float::splat(sphere.radius));
        let d2 = d * d;
        let cos = ((d - r) * (d + r) / d2).sqrt();
        let one_minus_cos = (r * r / d2) / (Float::splat(1.0) + cos);
        Self { center, to_center, outside: d.gt(r), one_minus_cos }
    }

    #[inline(always)]
    fn pdf(&self) -> Float {
        self.outside.select(uniform_cone_pdf(self.one_minus_cos), Float::splat(0.25 / PI))
    }
}

#[inline(always)]
fn sample_sphere(light: &Sphere, from: Vec3x, time: Float, u: Float, v: Float) -> LightSamples {
    let cones = Cones::new(light, from, time);
    let in_cone = uniform_cone(cones.to_center.normalize(), cones.one_minus_cos, u, v);
    let direction = Vec3x::select(cones.outside, in_cone, uniform_sphere(u, v));
    let ray = RayLanes::new(from, direction, time, Float::ZERO);
    // At the silhouette rounding may miss the sphere, which is then as far as its centre.
    let missed = cones.to_center.dot(direction);
    let distance = match sphere::<false>(&ray, cones.center, Float::splat(light.radius)) {
        Some(hits) => (hits.hit & hits.t.lt(Float::INFINITY)).select(hits.t, missed),
        None => missed,
    };
    LightSamples {
        direction,
        reach: distance * Float::splat(SHADOW_REACH),
        pdf: cones.pdf(),
        front: cones.outside,
        visible: Mask::all(),
    }
}

#[inline(always)]
fn sample_quad(quad: &Quad, shape: &LightShape, from: Vec3x, u: Float, v: Float) -> LightSamples {
    let by_area = Vec3x::splat(quad.q) + Vec3x::splat(quad.u) * u + Vec3x::splat(quad.v) * v;
    let (target, spherical) = match shape {
        LightShape::Rectangle(rectangle) => {
            let spherical = SphericalRectangle::new(rectangle, from);
            let target = Vec3x::select(spherical.exact, spherical.sample(u, v), by_area);
            (target, Some((spherical.exact, spherical.pdf())))
        }
        LightShape::Sphere | LightShape::Parallelogram => (by_area, None),
    };
    let direction = (target - from).normalize();
    let normal = Vec3x::splat(quad.normal);
    let slope = normal.dot(direction);
    let distance = -normal.dot(from - Vec3x::splat(quad.q)) / slope;
    let area_pdf = area_pdf(quad, direction, distance);
    let pdf = match spherical {
        Some((exact, pdf)) => exact.select(pdf, area_pdf),
        None => area_pdf,
    };
    let positive = |x: Float| x.gt(Float::ZERO) & x.lt(Float::INFINITY);
    LightSamples {
        direction,
        reach: distance * Float::splat(SHADOW_REACH),
        pdf,
        front: slope.lt(Float::ZERO),
        visible: positive(distance) & positive(pdf),
    }
}

/// Density per unit solid angle of points uniform on `quad`, at `distance` along `direction`.
#[inline(always)]
fn area_pdf(quad: &Quad, direction: Vec3x, distance: Float) -> Float {
    let slope = Vec3x::splat(quad.normal).dot(direction).abs();
    distance * distance / (Float::splat(quad.area()) * slope)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::engine::scalar::light;
    use crate::geometry::Ray;
    use crate::math::random::Stream;
    use crate::simd::{LANES, axes};

    #[test]
    fn lanes_are_the_scalar_samples() {
        let mut random = Stream::new(8);
        let lights = r#"(
            camera: (look_from: (0, 0, 9), look_at: (0, 0, 0), vfov: 40),
            materials: {"lamp": light(radiance: (1, 1, 1))},
            primitives: [
                quad(q: (3, 2, 1), u: (-1, 0.3, 0.1), v: (0.1, 0.2, -1), material: "lamp"),
                quad(q: (-2, 4, -1), u: (3, 0, 0), v: (0, 0, 2), material: "lamp"),
                quad(q: (0.9, 0.5, 0.5), u: (0, 1e-3, 0), v: (0, 0, 1e-3), material: "lamp"),
                sphere(center: (1, 1, 1), radius: 1.5, material: "lamp"),
                moving_sphere(center: (5, 4, 3), center1: (6, 4.5, 3), radius: 0.01, material: "lamp"),
            ],
        )"#;
        let scene = Scene::from_ron(lights).unwrap();
        assert_eq!(scene.lights().len(), 5);
        let (mut seen, mut unseen) = (0, 0);
        for light in (0..20_000).flat_map(|_| scene.lights()) {
            let mut numbers = |size: f32| [(); LANES].map(|()| size * random.uniform());
            let (from, [u, v, time]) =
                ([(); 3].map(|()| numbers(8.0)), [(); 3].map(|()| numbers(1.0)));
            // Some in a light's plane.
            let from = [from[0], from[1].map(|y| if y < 1.0 { 4.0 } else { y }), from[2]];
            let [fu, fv, ft] = [u, v, time].map(Float::new);
            let origin = Vec3x::new(&from);
            let samples = sample(&scene, light, origin, ft, (fu, fv));
            let t = numbers(5.0);
            let found = pdf(&scene, light, (origin, samples.direction), ft, Float::new(t));
            let direction = axes(|axis| samples.direction[axis].to_array());
            for lane in 0..LANES {
                let at = |v: &[[f32; LANES]; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
                let one = light::sample(&scene, light, at(&from), time[lane], (u[lane], v[lane]));
                assert_eq!(samples.visible.bits() >> lane & 1 == 1, one.is_some());
                let Some(one) = one else {
                    unseen += 1;
                    continue;
                };
                seen += 1;
                let bits = |v: Vec3| v.to_array().map(f32::to_bits);
                assert_eq!(bits(at(&direction)), bits(one.direction));
                assert_eq!(samples.reach.to_array()[lane].to_bits(), one.reach.to_bits());
                assert_eq!(samples.pdf.to_array()[lane].to_bits(), one.pdf.to_bits());
                assert_eq!(samples.front.bits() >> lane & 1 == 1, one.front);
                let ray = Ray { origin: at(&from), direction: one.direction, time: time[lane] };
                let want = light::pdf(&scene, light, &ray, t[lane]);
                assert_eq!(found.to_array()[lane].to_bits(), want.to_bits());
            }
        }
        assert!(seen > 500_000 && unseen > 1000, "{seen} {unseen}");
    }
}
