//! Quads: parallelograms `q + a u + b v` with a and b in [0, 1].

pub(crate) mod lanes;

use glam::{DVec3, Vec3};

use super::primitive::{components, vectors};
use super::{Bounds, PreparedRay, PrimitiveModel, Ray, Shape};
use crate::math::{Row, UNIT_ROUNDOFF, dot, length, row};

/// A two-sided parallelogram, with precomputed values for its test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quad {
    /// Corner.
    pub q: Vec3,
    /// Edge from the corner.
    pub u: Vec3,
    /// The other edge from the corner.
    pub v: Vec3,
    /// Unit normal, along `u × v`.
    pub normal: Vec3,
    /// Dual edges: `a = p·dual_u` and `b = p·dual_v` for `p = a u + b v`.
    dual_u: Vec3,
    dual_v: Vec3,
    /// The [`Surface::offset`](super::Surface::offset) of every point of the quad.
    offset: f32,
    area: f32,
}

impl Quad {
    /// The sine of the angle between the edges must exceed this.
    pub const MIN_SINE: f64 = 1e-2;

    /// The quad at corner `q` with edges `u` and `v`. Returns `None` if an edge is zero or the
    /// edges are parallel to within [`Quad::MIN_SINE`].
    pub fn new(q: Vec3, u: Vec3, v: Vec3) -> Option<Self> {
        // Computed in f64 and rounded once, so that the plane is as exact as f32 allows.
        let (du, dv) = (u.as_dvec3(), v.as_dvec3());
        let n = du.cross(dv);
        let n2 = n.dot(n);
        let edges2 = du.dot(du) * dv.dot(dv);
        if !(n2 > Self::MIN_SINE * Self::MIN_SINE * edges2 && n2 > 0.0 && n2.is_finite()) {
            return None;
        }
        let round = |d: DVec3| d.as_vec3();
        let normal = round(n / n2.sqrt());
        Some(Self {
            q,
            u,
            v,
            normal,
            dual_u: round(dv.cross(n) / n2),
            dual_v: round(n.cross(du) / n2),
            // Bounds the errors along the normal, component by component: the point is off by 3
            // roundings of q and 4 of the edges, the new ray's origin by 1, and the plane's
            // distance by 5.
            offset: UNIT_ROUNDOFF * dot(normal.abs(), q.abs() * 6.0 + (u.abs() + v.abs()) * 10.0),
            area: n2.sqrt() as f32,
        })
    }

    /// Distance of the quad's plane along the ray. NaN or infinite if the ray is parallel to it.
    #[inline]
    pub fn plane_distance(&self, ray: &Ray) -> f32 {
        -dot(self.normal, ray.origin - self.q) / dot(self.normal, ray.direction)
    }

    /// The coordinates (a, b) of the plane's point at distance `t`.
    #[inline]
    fn coordinates(&self, ray: &Ray, t: f32) -> (f32, f32) {
        let p = (ray.origin - self.q) + ray.direction * t;
        (dot(p, self.dual_u), dot(p, self.dual_v))
    }

    /// 1/sin of the angle between the edges. It is the factor by which errors of (a, b) are
    /// magnified.
    pub fn condition(&self) -> f32 {
        length(self.u) * length(self.v) / self.area()
    }

    /// The dual edges: a point at `p` from the corner has (a, b) = (p·dual_u, p·dual_v).
    pub(crate) fn duals(&self) -> [Vec3; 2] {
        [self.dual_u, self.dual_v]
    }

    /// The area.
    pub fn area(&self) -> f32 {
        self.area
    }

    /// Whether the edges are perpendicular to within f32 rounding.
    pub fn is_rectangle(&self) -> bool {
        dot(self.u, self.v).abs() <= 16.0 * UNIT_ROUNDOFF * length(self.u) * length(self.v)
    }
}

impl PrimitiveModel for Quad {
    /// The corner, then both edges.
    type Record = [f32; 9];

    #[inline]
    fn intersect(&self, prepared: &PreparedRay, t_min: f32, t_max: f32) -> Option<f32> {
        let t = self.plane_distance(&prepared.ray);
        // NaN and infinity fail this test, so rays parallel to the plane never hit.
        if !(t > t_min && t < t_max) {
            return None;
        }
        let (a, b) = self.coordinates(&prepared.ray, t);
        ((0.0..=1.0).contains(&a) && (0.0..=1.0).contains(&b)).then_some(t)
    }

    fn bounds(&self) -> Bounds {
        let Self { q, u, v, .. } = *self;
        Bounds::of([q, q + u, q + v, q + u + v]).widened(4)
    }

    fn shape(&self) -> Shape {
        Shape::Quad
    }

    fn identity(&self) -> [Vec3; 3] {
        [self.q, self.u, self.v]
    }

    fn record(&self) -> [f32; 9] {
        components(self.identity())
    }

    fn from_record(record: &[f32; 9]) -> Result<Self, &'static str> {
        let [q, u, v] = vectors(record);
        Self::new(q, u, v).ok_or("the edges of a quad must be neither zero nor nearly parallel")
    }
}

/// The rows of a quad: the corner with the offset, the edges `u` and `v` with the normal's x and y,
/// and the dual edges with the normal's z and 0.
pub(super) fn rows(quad: &Quad) -> [Row; 5] {
    let Quad { q, u, v, normal: Vec3 { x, y, z }, dual_u, dual_v, offset, .. } = *quad;
    [row(q, offset), row(u, x), row(v, y), row(dual_u, z), row(dual_v, 0.0)]
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::geometry::{Geometry, Hit, Surfaces};
    use crate::math::warp::uniform_hemisphere;
    use crate::math::{Stream, normalize};

    fn hit(quad: &Quad, ray: &Ray) -> Option<f32> {
        quad.intersect(&PreparedRay::new(ray), 0.0, f32::INFINITY)
    }

    fn ray(origin: Vec3, direction: Vec3) -> Ray {
        Ray { origin, direction, time: 0.0 }
    }

    #[test]
    fn hits_inside_only_and_from_both_sides() {
        let quad = Quad::new(Vec3::Z, Vec3::X * 2.0, Vec3::Y).unwrap();
        let at = |x, y| ray(Vec3::new(x, y, 0.0), Vec3::Z);
        assert_eq!(hit(&quad, &at(1.9, 0.9)), Some(1.0));
        assert_eq!(hit(&quad, &at(0.0, 0.0)), Some(1.0), "corners belong to the quad");
        assert_eq!(hit(&quad, &at(2.1, 0.5)), None);
        assert_eq!(hit(&quad, &at(1.0, -0.1)), None);
        assert_eq!(hit(&quad, &ray(Vec3::new(1.0, 0.5, 3.0), Vec3::NEG_Z)), Some(2.0));
        assert_eq!(hit(&quad, &ray(Vec3::ZERO, Vec3::X)), None, "parallel");
        assert_eq!(hit(&quad, &ray(Vec3::Z, Vec3::X)), None, "within the plane");
        assert_eq!(quad.coordinates(&at(1.0, 0.25), 1.0), (0.5, 0.25));
        assert_eq!(quad.area(), 2.0);
        assert!(quad.is_rectangle());
        assert!(!Quad::new(Vec3::ZERO, Vec3::X, Vec3::ONE).unwrap().is_rectangle());
    }

    #[test]
    fn quads_without_area_are_rejected() {
        assert!(Quad::new(Vec3::ZERO, Vec3::X, Vec3::X * 3.0).is_none());
        assert!(Quad::new(Vec3::ZERO, Vec3::ZERO, Vec3::Y).is_none());
        assert!(Quad::new(Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1e-6, 0.0)).is_none());
        assert!(Quad::new(Vec3::ZERO, Vec3::X * 1e-6, Vec3::Y * 1e-6).is_some());
    }

    #[test]
    fn no_ray_meets_the_quad_that_it_leaves() {
        let mut random = Stream::new(6);
        for quad in [
            Quad::new(Vec3::new(343.0, 554.0, 332.0), Vec3::X * -130.0, Vec3::Z * -105.0),
            Quad::new(
                Vec3::new(1e4, 1.0, -3e4),
                Vec3::new(1.0, 2.0, 3.0),
                Vec3::new(3.0, 2.0, 1.0),
            ),
            Quad::new(Vec3::ONE, Vec3::new(1.0, 2e-2, 0.0), Vec3::new(1.0, 0.0, 2e-2)),
            Quad::new(Vec3::new(0.1, 0.2, 0.3), Vec3::X * 1e-4, Vec3::new(1e-5, 300.0, 7.0)),
        ] {
            let quad = quad.unwrap();
            let geometry = Geometry { quads: vec![quad], ..Geometry::default() };
            let surfaces = Surfaces::new(&Arc::new(geometry));
            for _ in 0..200_000 {
                let target = quad.q + quad.u * random.uniform() + quad.v * random.uniform();
                let out = uniform_hemisphere(quad.normal, random.uniform(), random.uniform()).0;
                let start = target + out * 1000.0 * random.uniform();
                let first = ray(start, normalize(target - start));
                let Some(t) = hit(&quad, &first) else { continue };
                let surface = surfaces.find::<f32>(Shape::Quad, &first, Hit::of(0, t), false);
                let u = random.uniform();
                for side in [surface.normal, -surface.normal] {
                    let out = uniform_hemisphere(side, 1.0 - u * u * u, random.uniform()).0;
                    let leaving = ray(surface.spawn(side), out);
                    assert_eq!(hit(&quad, &leaving), None, "{quad:?} {leaving:?}");
                }
            }
        }
    }
}
