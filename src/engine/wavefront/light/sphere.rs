//! Sphere lights over lanes: uniform in the cones that they fill.

use std::f32::consts::PI;

use super::{Chosen, LightSamples};
use crate::geometry::lanes::{RayLanes, sphere};
use crate::simd::warp::{uniform_cone, uniform_cone_pdf, uniform_sphere};
use crate::simd::{Float, Mask, Vec3x};

/// The cones that spheres fill as seen from points.
struct Cones {
    center: Vec3x,
    radius: Float,
    to_center: Vec3x,
    /// Whether the point is outside the sphere.
    outside: Mask,
    /// 1 − cos of the half angle, there.
    one_minus_cos: Float,
}

impl Cones {
    #[inline(always)]
    fn new(lights: &Chosen<'_>, from: Vec3x, time: Float) -> Self {
        let ((center, _), (motion, r)) = (lights.row(1), lights.row(2));
        let center = center + motion * time;
        let to_center = center - from;
        let d = to_center.dot(to_center).sqrt();
        let d2 = d * d;
        let cos = ((d - r) * (d + r) / d2).sqrt();
        let one_minus_cos = (r * r / d2) / (Float::splat(1.0) + cos);
        Self { center, radius: r, to_center, outside: d.gt(r), one_minus_cos }
    }

    #[inline(always)]
    fn pdf(&self) -> Float {
        self.outside.select(uniform_cone_pdf(self.one_minus_cos), Float::splat(0.25 / PI))
    }
}

#[inline(always)]
pub(super) fn sample(
    lights: &Chosen<'_>,
    from: Vec3x,
    time: Float,
    (u, v): (Float, Float),
) -> LightSamples {
    let cones = Cones::new(lights, from, time);
    let in_cone = uniform_cone(cones.to_center.normalize(), cones.one_minus_cos, u, v);
    let direction = Vec3x::select(cones.outside, in_cone, uniform_sphere(u, v));
    let ray = RayLanes::new(from, direction, time, Float::ZERO);
    // At the silhouette rounding may miss the sphere, which is then as far as its centre.
    let missed = cones.to_center.dot(direction);
    let distance = match sphere::<false>(&ray, cones.center, cones.radius) {
        Some(hits) => (hits.hit & hits.t.lt(Float::INFINITY)).select(hits.t, missed),
        None => missed,
    };
    LightSamples {
        direction,
        distance,
        pdf: cones.pdf(),
        front: cones.outside,
        visible: Mask::all(),
    }
}

#[inline(always)]
pub(super) fn pdf(lights: &Chosen<'_>, origin: Vec3x, time: Float) -> Float {
    Cones::new(lights, origin, time).pdf()
}
