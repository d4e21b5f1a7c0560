//! Triangles, watertight at shared edges and vertices.

use glam::Vec3;

use super::{Bounds, PreparedRay, Ray, Surface};
use crate::math::{UNIT_ROUNDOFF, cross, length, max, max_element, normalize};

/// A two-sided triangle; its front is where the vertices run counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// The vertices.
    pub vertices: [Vec3; 3],
}

/// Scaled barycentric coordinates of the ray in the triangle, one a vertex, and the
/// vertices' heights above the ray's origin.
struct Sheared {
    weights: Vec3,
    heights: Vec3,
}

impl Triangle {
    /// The ray becomes the z-axis by a shear that all triangles share, and an edge of two
    /// triangles gives both the same edge function but for its sign. A rounded difference
    /// of rounded products is never on the wrong side of 0, and 0 counts as inside, so no
    /// ray slips between neighbours (Woop, Benthin, Wald 2013, "Watertight Ray/Triangle
    /// Intersection"). The paper's second pass in f64 only thins out double hits, which
    /// the rule for ties settles here.
    #[inline]
    fn shear(&self, prepared: &PreparedRay) -> Sheared {
        let [x, y, z] = prepared.axes;
        let s = prepared.shear;
        let place = |vertex: Vec3| {
            let p = vertex - prepared.ray.origin;
            (p[x] - s.x * p[z], p[y] - s.y * p[z], s.z * p[z])
        };
        let [a, b, c] = self.vertices.map(place);
        let edge = |from: (f32, f32, f32), to: (f32, f32, f32)| from.0 * to.1 - from.1 * to.0;
        Sheared {
            weights: Vec3::new(edge(b, c), edge(c, a), edge(a, b)),
            heights: Vec3::new(a.2, b.2, c.2),
        }
    }

    #[inline]
    pub(super) fn intersect(&self, prepared: &PreparedRay, t_min: f32, t_max: f32) -> Option<f32> {
        let Sheared { weights: w, heights: h } = self.shear(prepared);
        let some_negative = w.x < 0.0 || w.y < 0.0 || w.z < 0.0;
        let some_positive = w.x > 0.0 || w.y > 0.0 || w.z > 0.0;
        if some_negative && some_positive {
            return None;
        }
        let sum = w.x + w.y + w.z;
        let t = (w.x * h.x + w.y * h.y + w.z * h.z) / sum;
        // A ray within the plane has sum 0 and t NaN.
        (t > t_min && t < t_max).then_some(t)
    }

    #[inline]
    fn barycentric(&self, ray: &Ray) -> Vec3 {
        let w = self.shear(&PreparedRay::new(ray)).weights;
        w / (w.x + w.y + w.z)
    }

    #[inline]
    pub(super) fn surface(&self, ray: &Ray) -> Surface {
        let [a, b, c] = self.vertices;
        let w = self.barycentric(ray);
        let (e1, e2) = (b - a, c - a);
        let extent = self.vertices.iter().fold(0.0, |m, v| max(m, max_element(v.abs())));
        Surface {
            point: a * w.x + b * w.y + c * w.z,
            normal: normalize(cross(e1, e2)),
            offset: UNIT_ROUNDOFF * (16.0 * (length(e1) + length(e2)) + 12.0 * extent),
        }
    }

    #[inline]
    pub(super) fn uv(&self, ray: &Ray) -> (f32, f32) {
        let w = self.barycentric(ray);
        (w.y, w.z)
    }

    pub(super) fn bounds(&self) -> Bounds {
        Bounds::of(self.vertices)
    }

    /// Whether the vertices are on a line, so that no ray can hit it.
    pub fn is_degenerate(&self) -> bool {
        let [a, b, c] = self.vertices.map(|v| v.as_dvec3());
        !((b - a).cross(c - a).length_squared() > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::dot;
    use crate::math::random::Stream;
    use crate::math::warp::{uniform_hemisphere, uniform_sphere};

    fn hit(triangle: &Triangle, ray: &Ray) -> Option<f32> {
        triangle.intersect(&PreparedRay::new(ray), 0.0, f32::INFINITY)
    }

    fn ray(origin: Vec3, direction: Vec3) -> Ray {
        Ray { origin, direction, time: 0.0 }
    }

    #[test]
    fn hits_inside_only_and_from_both_sides() {
        let triangle = Triangle { vertices: [Vec3::Z, Vec3::Z + Vec3::X, Vec3::Z + Vec3::Y] };
        let at = |x, y| ray(Vec3::new(x, y, 0.0), Vec3::Z);
        assert_eq!(hit(&triangle, &at(0.25, 0.5)), Some(1.0));
        assert_eq!(hit(&triangle, &at(0.75, 0.5)), None);
        assert_eq!(hit(&triangle, &at(0.5, 0.5)), Some(1.0), "edges belong to it");
        assert_eq!(hit(&triangle, &ray(Vec3::new(0.2, 0.2, 3.0), Vec3::NEG_Z)), Some(2.0));
        assert_eq!(hit(&triangle, &ray(Vec3::Z, Vec3::X)), None, "within the plane");
        let surface = triangle.surface(&at(0.25, 0.5));
        assert_eq!((surface.point, surface.normal), (Vec3::new(0.25, 0.5, 1.0), Vec3::Z));
        assert_eq!(triangle.uv(&at(0.25, 0.5)), (0.25, 0.5));
        let line = Triangle { vertices: [Vec3::ZERO, Vec3::ONE, Vec3::ONE * 3.0] };
        assert!(line.is_degenerate() && !triangle.is_degenerate());
    }

    #[test]
    fn no_ray_slips_between_the_faces_of_a_closed_fan() {
        // An octahedron with one vertex pulled far out; rays from inside aimed at its
        // vertices and edges, where leaks would be.
        let v = [Vec3::X * 90.0, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
        let faces = [
            (0, 2, 4),
            (2, 1, 4),
            (1, 3, 4),
            (3, 0, 4),
            (2, 0, 5),
            (1, 2, 5),
            (3, 1, 5),
            (0, 3, 5),
        ];
        let mesh = faces.map(|(a, b, c)| Triangle { vertices: [v[a], v[b], v[c]] });
        let mut random = Stream::new(8);
        for i in 0..400_000 {
            let origin = uniform_sphere(random.uniform(), random.uniform()) * 0.3;
            let (a, b, _) = faces[i % 8];
            let along = if i % 3 == 0 { 0.0 } else { random.uniform() };
            let direction = v[a] * (1.0 - along) + v[b] * along - origin;
            let ray = ray(origin, direction);
            assert!(mesh.iter().any(|triangle| hit(triangle, &ray).is_some()), "{ray:?}");
        }
    }

    #[test]
    fn no_ray_meets_the_triangle_that_it_leaves() {
        let mut random = Stream::new(9);
        for scale in [1e-3, 1.0, 1e3] {
            for _ in 0..200_000 {
                let mut point = || uniform_sphere(random.uniform(), random.uniform()) * scale;
                let triangle = Triangle { vertices: [point(), point(), point()] };
                let (origin, middle) =
                    (point() * 5.0, triangle.vertices.iter().sum::<Vec3>() / 3.0);
                let (e1, e2) = (
                    triangle.vertices[1] - triangle.vertices[0],
                    triangle.vertices[2] - triangle.vertices[0],
                );
                // Needles are a documented weakness of f32.
                if length(cross(e1, e2)) < 0.05 * length(e1) * length(e2) {
                    continue;
                }
                let first = ray(origin, normalize(middle - origin));
                if hit(&triangle, &first).is_none() {
                    continue;
                }
                let surface = triangle.surface(&first);
                let side = if dot(surface.normal, first.direction) < 0.0 {
                    surface.normal
                } else {
                    -surface.normal
                };
                let out = uniform_hemisphere(side, random.uniform(), random.uniform()).0;
                let leaving = ray(surface.spawn(side), out);
                assert_eq!(hit(&triangle, &leaving), None, "{triangle:?} {leaving:?}");
            }
        }
    }
}
