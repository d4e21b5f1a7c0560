//! Triangles with a test that is watertight at shared edges and vertices.

mod inset;
pub(crate) mod lanes;
mod surface;

use glam::{DVec3, Vec3};

use super::primitive::{components, vectors};
use super::{Bounds, PreparedRay, PrimitiveModel, Ray, Shape};
use crate::simd::axes;
pub(super) use inset::inset;
pub(super) use surface::surface;

/// A two-sided triangle. Its vertices run counter-clockwise as seen from the front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// The vertices.
    pub vertices: [Vec3; 3],
}

/// A triangle's vertices in the coordinates of a ray: two sideways offsets and the distance ahead.
type Sheared = [[f32; 3]; 3];

/// Scaled barycentric coordinates of the ray, one per vertex. Each is twice the signed area that
/// the ray spans with the opposite edge.
#[inline(always)]
fn weights([a, b, c]: Sheared) -> [f64; 3] {
    let edge = |from: [f32; 3], to: [f32; 3]| {
        f64::from(from[0]) * f64::from(to[1]) - f64::from(from[1]) * f64::from(to[0])
    };
    [edge(b, c), edge(c, a), edge(a, b)]
}

/// Distance of the triangle along the ray, or NaN if the ray misses it.
#[inline(always)]
pub(super) fn distance(sheared: Sheared) -> f32 {
    let [u, v, w] = weights(sheared);
    let some_negative = u < 0.0 || v < 0.0 || w < 0.0;
    let some_positive = u > 0.0 || v > 0.0 || w > 0.0;
    if some_negative && some_positive {
        return f32::NAN;
    }
    ahead([u, v, w], sheared)
}

/// [`distance`] without a branch, for loops that the compiler vectorizes and for rays whose hits no CPU
/// can predict. Else the version with a branch is faster.
#[inline(always)]
pub(super) fn distance_by_select(sheared: Sheared) -> f32 {
    let [u, v, w] = weights(sheared);
    let some_negative = (u < 0.0) | (v < 0.0) | (w < 0.0);
    let some_positive = (u > 0.0) | (v > 0.0) | (w > 0.0);
    let t = ahead([u, v, w], sheared);
    if some_negative & some_positive { f32::NAN } else { t }
}

/// Distance of the point with these weights.
#[inline(always)]
fn ahead([u, v, w]: [f64; 3], sheared: Sheared) -> f32 {
    let [a, b, c] = sheared.map(|vertex| f64::from(vertex[2]));
    // A triangle seen edge-on has weights of mixed signs, or all weights and their sum are 0, which
    // makes the distance NaN.
    ((u * a + v * b + w * c) / (u + v + w)) as f32
}

impl Triangle {
    /// Shears the vertices so that the ray becomes the z-axis. All triangles share the shear of a
    /// ray, and two triangles with a common edge compute the same edge function for it except for
    /// its sign, so no ray slips between neighbours (Woop, Benthin, Wald 2013, "Watertight
    /// Ray/Triangle Intersection").
    ///
    /// Unlike in the paper, the edge functions are always computed in f64, not only if they are 0
    /// in f32. Products of f32 are exact in f64, and so are the signs. Hence the hit is a true
    /// point of the triangle with the sheared vertices, no matter how far, thin or edge-on it is.
    /// With f32 alone, rays hit triangles far beside them if these were small as seen from the
    /// ray's origin, and hit edge-on ones at distances outside their bounding boxes.
    #[inline]
    fn sheared(&self, prepared: &PreparedRay) -> Sheared {
        let [x, y, z] = prepared.axes;
        let s = prepared.shear;
        axes(|i| {
            let p = self.vertices[i] - prepared.ray.origin;
            [p[x] - s.x * p[z], p[y] - s.y * p[z], s.z * p[z]]
        })
    }

    /// The axis on which all vertices have the same coordinate, if there is one.
    ///
    /// Such triangles have the distance of their plane along this axis, with the roundings of a quad there. So
    /// rays that leave a quad never hit a triangle in its plane, and where they lie on each other, all rays
    /// hit the quad, since it has the smaller number.
    #[inline]
    fn level_axis(&self) -> Option<usize> {
        let [a, b, c] = self.vertices;
        (0..3).find(|&axis| a[axis] == b[axis] && b[axis] == c[axis])
    }

    /// Twice the area times the unit normal. It is in f64 because the cross product of slivers
    /// cancels.
    #[inline]
    fn scaled_normal(&self) -> DVec3 {
        let [a, b, c] = self.vertices.map(|vertex| vertex.as_dvec3());
        (b - a).cross(c - a)
    }

    /// Whether the vertices lie on a line, so that the triangle has no normal. Such a triangle must
    /// not be part of a scene.
    pub fn is_degenerate(&self) -> bool {
        !(self.scaled_normal().length_squared() > 0.0)
    }
}

impl PrimitiveModel for Triangle {
    /// The three vertices.
    type Record = [f32; 9];

    #[inline]
    fn intersect(&self, prepared: &PreparedRay, t_min: f32, t_max: f32) -> Option<f32> {
        let mut t = distance(self.sheared(prepared));
        if !t.is_nan()
            && let Some(axis) = self.level_axis()
        {
            let Ray { origin, direction, .. } = &prepared.ray;
            t = (self.vertices[0][axis] - origin[axis]) / direction[axis];
        }
        (t > t_min && t < t_max).then_some(t)
    }

    fn bounds(&self) -> Bounds {
        Bounds::of(self.vertices)
    }

    fn shape(&self) -> Shape {
        Shape::Triangle
    }

    fn identity(&self) -> [Vec3; 3] {
        self.vertices
    }

    fn record(&self) -> [f32; 9] {
        components(self.vertices)
    }

    fn from_record(record: &[f32; 9]) -> Result<Self, &'static str> {
        Ok(Self { vertices: vectors(record) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;
    use crate::math::warp::uniform_sphere;

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
        assert_eq!(hit(&triangle, &at(0.5, 0.5)), Some(1.0), "edges belong to the triangle");
        assert_eq!(hit(&triangle, &ray(Vec3::new(0.2, 0.2, 3.0), Vec3::NEG_Z)), Some(2.0));
        assert_eq!(hit(&triangle, &ray(Vec3::Z, Vec3::X)), None, "within the plane");
        let (surface, uv) = surface(triangle.vertices, &at(0.25, 0.5), 1.0);
        assert_eq!((surface.point, surface.normal), (Vec3::new(0.25, 0.5, 1.0), Vec3::Z));
        assert_eq!(uv, [0.25, 0.5]);
        let line = Triangle { vertices: [Vec3::ZERO, Vec3::ONE, Vec3::ONE * 3.0] };
        assert!(line.is_degenerate() && !triangle.is_degenerate());
    }

    #[test]
    fn no_ray_slips_between_the_faces_of_a_closed_fan() {
        // The mesh is an octahedron with one vertex pulled far out. Rays from inside aim at its
        // vertices and edges, the only places that could leak.
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
}
