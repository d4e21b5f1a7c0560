//! Spheres, which are still or move linearly.

pub(crate) mod lanes;

use glam::Vec3;
use std::f32::consts::PI;

use super::{Bounds, PreparedRay, PrimitiveModel, Ray, Shape, Surface};
use crate::math::{
    Mask, Real, Row, UNIT_ROUNDOFF, Vector, acos, atan2, clamp, dot, max, max_element, normalize,
    row,
};

/// A sphere whose centre moves linearly from `center` at time 0 to `center1` at time 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre at time 0.
    pub center: Vec3,
    /// Centre at time 1, equal to `center` for a still sphere.
    pub center1: Vec3,
    /// Radius, above 0.
    pub radius: f32,
}

impl Sphere {
    /// A sphere that does not move.
    pub fn still(center: Vec3, radius: f32) -> Self {
        Self { center, center1: center, radius }
    }

    /// Displacement of the centre from time 0 to time 1.
    #[inline]
    pub fn motion(&self) -> Vec3 {
        self.center1 - self.center
    }

    /// Centre at `time`.
    #[inline]
    pub fn center_at(&self, time: f32) -> Vec3 {
        self.center + self.motion() * time
    }
}

impl PrimitiveModel for Sphere {
    /// The centre at time 0, the radius, the centre at time 1, and 0.
    type Record = [f32; 8];

    /// Finds the first root in the open interval.
    ///
    /// With `f` from the centre to the origin and `l` the part of it perpendicular to the ray, the
    /// discriminant is r² − l·l, which does not cancel for far or huge spheres (Haines et al. 2019,
    /// "Precision Improvements for Ray/Sphere Intersection"). The root whose terms would cancel is
    /// computed as the product of the roots over the other root. It is clamped to the other root's
    /// magnitude, which it cannot exceed: along a tangent from the surface, both the product and
    /// the other root are mere rounding errors, and so is their quotient.
    #[inline(always)]
    fn intersect(&self, prepared: &PreparedRay, t_min: f32, t_max: f32) -> Option<f32> {
        let ray = &prepared.ray;
        let f = ray.origin - self.center_at(ray.time);
        let b = -dot(f, ray.direction);
        let l = f + ray.direction * (b * prepared.inv_length2);
        let discriminant = self.radius * self.radius - dot(l, l);
        // Negated so that NaN misses.
        if !(discriminant >= 0.0) {
            return None;
        }
        let q = b + (prepared.length2 * discriminant).sqrt().copysign(b);
        let c = dot(f, f) - self.radius * self.radius;
        let by_sum = q * prepared.inv_length2;
        let by_product = clamp(c / q, -by_sum.abs(), by_sum.abs());
        let (near, far) = if b > 0.0 { (by_product, by_sum) } else { (by_sum, by_product) };
        let t = if near > t_min { near } else { far };
        (t > t_min && t < t_max).then_some(t)
    }

    fn bounds(&self) -> Bounds {
        // The centre's components are monotonic in time, even with rounding.
        let centers = Bounds::of([self.center_at(0.0), self.center_at(1.0)]);
        Bounds { min: centers.min - self.radius, max: centers.max + self.radius }.widened(1)
    }

    fn shape(&self) -> Shape {
        if self.motion() == Vec3::ZERO { Shape::Sphere } else { Shape::MovingSphere }
    }

    fn identity(&self) -> [Vec3; 3] {
        [self.center, self.motion(), Vec3::splat(self.radius)]
    }

    fn record(&self) -> [f32; 8] {
        let ([x, y, z], [x1, y1, z1]) = (self.center.to_array(), self.center1.to_array());
        [x, y, z, self.radius, x1, y1, z1, 0.0]
    }

    fn from_record(&[x, y, z, radius, x1, y1, z1, _]: &[f32; 8]) -> Result<Self, &'static str> {
        let (center, center1) = (Vec3::new(x, y, z), Vec3::new(x1, y1, z1));
        let sphere = Self { center, center1, radius };
        (radius > 0.0).then_some(sphere).ok_or("the radius must be above 0")
    }
}

/// The row of a sphere at time 0: the centre and the radius.
pub(super) fn row_at_start(sphere: &Sphere) -> Row {
    // `center_at` gives the position of a still sphere at any time, including the sign of zeros.
    row(sphere.center_at(0.0), sphere.radius)
}

/// The point that a ray hits at distance `t`, on a sphere that is at `center` at the ray's time.
#[inline(always)]
pub(super) fn surface<R: Real>(center: R::Vec3, radius: R, ray: &Ray<R>, t: R) -> Surface<R> {
    let normal = normalize(ray.origin + ray.direction * t - center);
    // With u the unit roundoff, the point is off by 4u r along the normal and by its rounding u|p|,
    // and the new ray's origin is off by u|p| again. From a distance of 4u r on, the sign of
    // f·f − r² is certain.
    let extent = max(max_element(center.abs()), radius);
    let offset = (radius * 10.0 + extent * 6.0) * UNIT_ROUNDOFF;
    Surface::flat(center + normal * radius, normal, offset)
}

/// Like [`Sphere::intersect`], returns the distance of the first hit above 0, for a sphere at
/// `center` or for one sphere per lane. The distance is valid only if the mask is set.
#[inline(always)]
pub(crate) fn distance<R: Real>(ray: &Ray<R>, center: R::Vec3, radius: R) -> (R, R::Mask) {
    let length2 = dot(ray.direction, ray.direction);
    let inv_length2 = R::ONE / length2;
    let f = ray.origin - center;
    let b = -dot(f, ray.direction);
    let l = f + ray.direction * (b * inv_length2);
    let discriminant = radius * radius - dot(l, l);
    let q = b + (length2 * discriminant).sqrt().copysign(b);
    let c = dot(f, f) - radius * radius;
    let by_sum = q * inv_length2;
    let by_product = clamp(c / q, -by_sum.abs(), by_sum.abs());
    let ahead = b.gt(R::ZERO);
    let (near, far) = (ahead.select(by_product, by_sum), ahead.select(by_sum, by_product));
    let t = near.gt(R::ZERO).select(near, far);
    (t, discriminant.ge(R::ZERO) & t.gt(R::ZERO) & t.lt(R::INFINITY))
}

/// The texture coordinates for a normal: the longitude and the colatitude from the lower pole, both
/// divided by their full range.
#[inline(always)]
pub(super) fn uv<R: Real>(normal: R::Vec3) -> (R, R) {
    ((atan2(-normal[2], normal[0]) + PI) * (1.0 / (2.0 * PI)), acos(-normal[1]) * (1.0 / PI))
}

/// ∂p/∂u and ∂p/∂v for the coordinates of [`uv`], on a sphere of this radius. Not finite at the poles.
#[inline(always)]
pub(super) fn partials<R: Real>(normal: R::Vec3, radius: R) -> [R::Vec3; 2] {
    let (x, y, z) = (normal[0], normal[1], normal[2]);
    let sine = (x * x + z * z).sqrt();
    let toward_pole = -y / sine;
    let u = <R::Vec3 as Vector>::new(z, R::ZERO, -x) * (radius * (2.0 * PI));
    let v = <R::Vec3 as Vector>::new(x * toward_pole, sine, z * toward_pole) * (radius * PI);
    [u, v]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;
    use crate::math::warp::{uniform_hemisphere, uniform_sphere};

    fn ray(origin: Vec3, direction: Vec3) -> Ray {
        Ray { origin, direction, time: 0.0 }
    }

    fn hit(sphere: &Sphere, ray: &Ray) -> Option<f32> {
        sphere.intersect(&PreparedRay::new(ray), 0.0, f32::INFINITY)
    }

    #[test]
    fn hits_from_outside_inside_and_behind() {
        let s = Sphere::still(Vec3::new(0.0, 0.0, 5.0), 1.0);
        assert_eq!(hit(&s, &ray(Vec3::ZERO, Vec3::Z)), Some(4.0));
        assert_eq!(hit(&s, &ray(Vec3::ZERO, Vec3::Z * 2.0)), Some(2.0));
        assert_eq!(hit(&s, &ray(s.center, Vec3::Z)), Some(1.0));
        assert_eq!(hit(&s, &ray(Vec3::ZERO, Vec3::NEG_Z)), None);
        assert_eq!(hit(&s, &ray(Vec3::new(2.0, 0.0, 0.0), Vec3::Z)), None);
        assert_eq!(hit(&s, &ray(Vec3::ZERO, Vec3::ZERO)), None);
        assert_eq!(hit(&s, &ray(Vec3::NAN, Vec3::Z)), None);
        let prepared = PreparedRay::new(&ray(Vec3::ZERO, Vec3::Z));
        assert_eq!(s.intersect(&prepared, 0.0, 4.0), None, "the interval is open");
        assert_eq!(s.intersect(&prepared, 4.0, 9.0), Some(6.0));
    }

    #[test]
    fn a_moving_sphere_is_where_its_time_says() {
        let s = Sphere { center: Vec3::Z * 5.0, center1: Vec3::Z * 7.0, radius: 1.0 };
        let late = Ray { time: 0.5, ..ray(Vec3::ZERO, Vec3::Z) };
        assert_eq!(hit(&s, &late), Some(5.0));
        assert_eq!(
            s.bounds(),
            Bounds::of([Vec3::new(-1.0, -1.0, 4.0), Vec3::new(1.0, 1.0, 8.0)]).widened(1)
        );
    }

    #[test]
    fn no_ray_meets_the_sphere_that_it_leaves() {
        let mut random = Stream::new(5);
        for (center, radius) in [
            (Vec3::new(0.0, -1000.0, 0.0), 1000.0),
            (Vec3::new(4.0, 1.0, 0.0), 1.0),
            (Vec3::new(-300.0, 7.0, 9000.0), 0.2),
            (Vec3::new(1e-3, 2e-3, -1e-3), 1e-5),
            (Vec3::new(1e6, -1e5, 3e6), 4e5),
        ] {
            let sphere = Sphere::still(center, radius);
            for _ in 0..200_000 {
                let far =
                    center + uniform_sphere(random.uniform(), random.uniform()) * (radius * 3.0);
                let to = center + uniform_sphere(random.uniform(), random.uniform()) * radius;
                let first = ray(far, normalize(to - far));
                let Some(t) = hit(&sphere, &first) else { continue };
                let surface = surface(center, radius, &first, t);
                // Cubing `u` makes many directions grazing.
                let u = random.uniform();
                let (out, _) =
                    uniform_hemisphere(surface.normal, 1.0 - u * u * u, random.uniform());
                let leaving = ray(surface.spawn(surface.normal), out);
                assert_eq!(hit(&sphere, &leaving), None, "{sphere:?} {leaving:?}");
                // An inward ray must hit the far side, not the point that it starts from.
                let inward = ray(surface.spawn(-surface.normal), -out);
                let chord = hit(&sphere, &inward).expect("an inward ray hits the far side");
                let want = 2.0 * radius * dot(out, surface.normal);
                // The offset alone lengthens the chord of a tangent from 0 to √(2 r offset).
                let bound = 2.0 * (2.0 * radius * surface.offset).sqrt();
                assert!((chord - want).abs() <= bound, "{chord} {want}");
            }
        }
    }

    /// Tests near-tangents from points within a few roundings of the sphere, inside or outside.
    #[test]
    fn hits_are_on_the_sphere() {
        let mut random = Stream::new(7);
        let (mut hits, rays) = (0, 500_000);
        for _ in 0..rays {
            let [x, y, z] = [(); 3].map(|()| random.between(-100.0, 100.0));
            let sphere = Sphere::still(Vec3::new(x, y, z), random.between(1.0, 21.0));
            let normal = uniform_sphere(random.uniform(), random.uniform());
            let aside = random.between(-1.0, 1.0) * 4.0 * f32::EPSILON;
            let origin = sphere.center + normal * (sphere.radius * (1.0 + aside));
            let any = uniform_sphere(random.uniform(), random.uniform());
            let up = random.between(-1.0, 1.0) * 4.0 * f32::EPSILON;
            let ray = ray(origin, any - normal * (dot(any, normal) + up));
            let Some(t) = hit(&sphere, &ray) else { continue };
            hits += 1;
            let point = ray.origin.as_dvec3() + ray.direction.as_dvec3() * f64::from(t);
            let radius = f64::from(sphere.radius);
            let off = (point - sphere.center.as_dvec3()).length() - radius;
            // The constant covers the rounding of the origin, which scales with its coordinates.
            assert!(off.abs() < 1e-6 * radius + 2e-5, "{off}: {sphere:?} {ray:?}");
        }
        assert!(hits > rays / 4, "{hits}");
    }

    #[test]
    fn uv_covers_the_map() {
        assert_eq!(uv::<f32>(Vec3::NEG_Y).1, 0.0);
        assert_eq!(uv::<f32>(Vec3::Y).1, 1.0);
        assert!((uv::<f32>(Vec3::X).0 - 0.5).abs() < 1e-6);
        assert!((uv::<f32>(Vec3::NEG_Z).0 - 0.75).abs() < 1e-6);
    }
}
