//! Sphere lights, sampled uniformly in the cone that they subtend.

use std::f32::consts::PI;

use super::sample::LightSample;
use super::{LightModel, PrimitiveLight};
use crate::geometry::{Primitive, Ray, sphere_distance};
use crate::math::warp::{uniform_cone, uniform_cone_pdf, uniform_sphere};
use crate::math::{Mask, Real, Row, Vector, dot, length, normalize, row};

#[derive(Clone, Copy, Debug)]
pub(super) struct SphereLight {
    /// Centre at time 0, radius.
    center: Row,
    /// (motion from time 0 to time 1, 0).
    motion: Row,
}

/// The cone that a sphere subtends at a point.
struct Cone<R: Real> {
    center: R::Vec3,
    radius: R,
    to_center: R::Vec3,
    /// Whether the point is outside the sphere.
    outside: R::Mask,
    /// 1 − cos of the cone's half angle, for points outside the sphere.
    one_minus_cos: R,
}

impl<R: Real> Cone<R> {
    #[inline(always)]
    fn new(table: &[SphereLight], index: R::Index, from: R::Vec3, time: R) -> Self {
        let (center, r) = R::gather(table, index, |light| &light.center);
        let (motion, _) = R::gather(table, index, |light| &light.motion);
        let center = center + motion * time;
        let to_center = center - from;
        let d = length(to_center);
        let d2 = d * d;
        // Computes cos² as a product, because 1 − sin² would cancel for points near the surface.
        // Computes 1 − cos as sin²/(1 + cos), because it would cancel for narrow cones.
        let cos = ((d - r) * (d + r) / d2).sqrt();
        let one_minus_cos = (r * r / d2) / (R::ONE + cos);
        Self { center, radius: r, to_center, outside: d.gt(r), one_minus_cos }
    }

    #[inline(always)]
    fn pdf(&self) -> R {
        self.outside.select(uniform_cone_pdf(self.one_minus_cos), R::splat(0.25 / PI))
    }
}

impl LightModel for SphereLight {
    fn of(primitive: Primitive) -> Option<PrimitiveLight<Self>> {
        let Primitive::Sphere(sphere) = primitive else { return None };
        let radius = f64::from(sphere.radius);
        let light =
            Self { center: row(sphere.center, sphere.radius), motion: row(sphere.motion(), 0.0) };
        let area = 4.0 * std::f64::consts::PI * radius * radius;
        Some(PrimitiveLight { light, area, normal: None })
    }

    #[inline(always)]
    fn sample<R: Real>(
        table: &[Self],
        index: R::Index,
        from: R::Vec3,
        time: R,
        (u, v): (R, R),
    ) -> LightSample<R> {
        let cone = Cone::new(table, index, from, time);
        let mut direction = uniform_sphere(u, v);
        if cone.outside.any() {
            let inside = uniform_cone(normalize(cone.to_center), cone.one_minus_cos, u, v);
            direction = cone.outside.select(inside, direction);
        }
        let ray = Ray { origin: from, direction, time };
        let (t, hit) = sphere_distance(&ray, cone.center, cone.radius);
        // At the silhouette, the ray may miss the sphere by rounding error. Then use the ray's
        // point nearest to the centre.
        let distance = hit.select(t, dot(cone.to_center, direction));
        let (pdf, front) = (cone.pdf(), cone.outside);
        let tint = R::Vec3::gray(R::ONE);
        LightSample { direction, distance, pdf, tint, front, visible: R::Mask::ALL }
    }

    #[inline(always)]
    fn pdf<R: Real>(table: &[Self], index: R::Index, ray: &Ray<R>, _: R) -> R {
        Cone::new(table, index, ray.origin, ray.time).pdf()
    }
}
