//! Tests of quads and rays in lanes.

use glam::Vec3;

use super::Quad;
use crate::geometry::RayLanes;
use crate::math::{Real, Word};
use crate::simd::{Float, Int, Mask, Vec3x};

/// The quad data that the general test needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuadLanes {
    pub(crate) q: Vec3x,
    pub(crate) normal: Vec3x,
    pub(crate) dual_u: Vec3x,
    pub(crate) dual_v: Vec3x,
}

/// The two halves of a quad's test. The second is only needed if the distance is in the ray's
/// interval.
///
/// The scalar test computes origin − corner, these tests compute corner − origin. That only flips
/// signs, which is exact.
pub(crate) trait QuadTest {
    /// Distances at which the rays hit the quad's plane.
    fn distance(&self, ray: &RayLanes) -> Float;

    /// Whether the rays are within the quad at distances `t`.
    fn contains(&self, ray: &RayLanes, t: Float) -> Mask;
}

impl QuadTest for QuadLanes {
    #[inline(always)]
    fn distance(&self, ray: &RayLanes) -> Float {
        self.normal.dot(self.q - ray.origin) / self.normal.dot(ray.direction)
    }

    #[inline(always)]
    fn contains(&self, ray: &RayLanes, t: Float) -> Mask {
        let p = ray.direction * t - (self.q - ray.origin);
        in_unit_square(p.dot(self.dual_u), p.dot(self.dual_v))
    }
}

/// The lanes in which both `a` and `b` are in [0, 1].
#[inline(always)]
fn in_unit_square(a: Float, b: Float) -> Mask {
    // Which of the two is faster depends on the instruction set (`profiling/`).
    if cfg!(target_feature = "avx512f") { in_square_as_bits(a, b) } else { in_square(a, b) }
}

#[inline(always)]
fn in_square(a: Float, b: Float) -> Mask {
    let in_unit = |x: Float| Float::ZERO.le(x) & x.le(Float::splat(1.0));
    in_unit(a) & in_unit(b)
}

/// Compares the bits of the floats as unsigned integers: numbers in [0, 1] have the smallest
/// bits. −0 is an exception, so 0 is added, which turns −0 into 0.
#[inline(always)]
fn in_square_as_bits(a: Float, b: Float) -> Mask {
    let bits = |x: Float| (x + Float::ZERO).to_bits();
    bits(a).max(bits(b)).le(Int::splat(1.0f32.to_bits()))
}

/// A quad with many zero components, which allow a cheaper test than that of [`QuadLanes`]. The
/// results are the same for rays whose corner − origin does not overflow. Kernels leave other rays
/// to the reference.
///
/// The results agree because a sum of two numbers does not depend on their order, and because
/// adding a product with 0 changes nothing, with two exceptions. First, it can change the sign of a
/// zero, which no comparison sees. Second, the product is NaN if the other factor is infinite, but
/// then `t` or a coordinate is beyond the quad, and both tests miss.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SpecialQuad {
    /// Both edges are parallel to axes.
    Aligned(AlignedQuad),
    /// The plane is perpendicular to an axis, and at most one edge is parallel to an axis.
    Level(LevelQuad),
    /// One edge is parallel to an axis, and the other is perpendicular to it.
    Upright(UprightQuad),
}

impl SpecialQuad {
    /// Converts `quad` to the cheapest special form, or returns `None` if it has none.
    pub(crate) fn new(quad: &Quad) -> Option<Self> {
        let aligned = || AlignedQuad::new(quad).map(Self::Aligned);
        let level = || LevelQuad::new(quad).map(Self::Level);
        let upright = || UprightQuad::new(quad).map(Self::Upright);
        aligned().or_else(level).or_else(upright)
    }
}

/// A quad's corner, with the axes in an order chosen for the quad.
#[derive(Clone, Copy, Debug)]
struct Corner {
    axes: [usize; 3],
    q: [f32; 3],
}

impl Corner {
    fn new(quad: &Quad, axes: [usize; 3]) -> Self {
        Self { axes, q: axes.map(|axis| quad.q[axis]) }
    }

    /// Component `i` of the rays' directions.
    #[inline(always)]
    fn direction(&self, ray: &RayLanes, i: usize) -> Float {
        ray.direction[self.axes[i]]
    }

    /// Component `i` of the vectors from the rays' origins to the corner.
    #[inline(always)]
    fn ahead(&self, ray: &RayLanes, i: usize) -> Float {
        Float::splat(self.q[i]) - ray.origin[self.axes[i]]
    }

    /// Component `i` of the vectors from the corner to the rays' points at `t`.
    #[inline(always)]
    fn beyond(&self, ray: &RayLanes, t: Float, i: usize) -> Float {
        self.direction(ray, i) * t - self.ahead(ray, i)
    }

    /// Distances at which the rays hit the plane perpendicular to the first axis.
    #[inline(always)]
    fn distance_across(&self, ray: &RayLanes) -> Float {
        self.ahead(ray, 0) / self.direction(ray, 0)
    }
}

/// A quad with both edges parallel to axes, such as a wall or a table top. Its plane is a condition
/// on one coordinate, and each edge adds a condition on another coordinate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AlignedQuad {
    /// The components of the corner: first along the axis perpendicular to the quad, then along the
    /// axes of the two dual edges.
    corner: Corner,
    /// The nonzero component of each dual edge.
    duals: [f32; 2],
}

impl AlignedQuad {
    fn new(quad: &Quad) -> Option<Self> {
        let along = |v: Vec3| {
            let axis = (0..3).find(|&axis| v[axis] != 0.0)?;
            (0..3).all(|other| other == axis || v[other] == 0.0).then_some(axis)
        };
        let [dual_u, dual_v] = quad.duals();
        let axes = [along(quad.normal)?, along(dual_u)?, along(dual_v)?];
        // The sign of the normal cancels in the distance. With a normal of
        // another length, the products could be rounded.
        (quad.normal[axes[0]].abs() == 1.0).then(|| Self {
            corner: Corner::new(quad, axes),
            duals: [dual_u[axes[1]], dual_v[axes[2]]],
        })
    }
}

impl QuadTest for AlignedQuad {
    #[inline(always)]
    fn distance(&self, ray: &RayLanes) -> Float {
        self.corner.distance_across(ray)
    }

    #[inline(always)]
    fn contains(&self, ray: &RayLanes, t: Float) -> Mask {
        let p = |i: usize| self.corner.beyond(ray, t, i);
        let [dual_u, dual_v] = self.duals;
        in_unit_square(p(1) * Float::splat(dual_u), p(2) * Float::splat(dual_v))
    }
}

/// A quad whose plane is perpendicular to an axis, with edges in any direction within it, such as
/// the lid of a box rotated about an axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LevelQuad {
    /// The components of the corner: first along the axis perpendicular to the quad, then along the
    /// two axes in the quad's plane.
    corner: Corner,
    /// The dual edges, on the axes in the plane.
    dual_u: [f32; 2],
    dual_v: [f32; 2],
}

impl LevelQuad {
    fn new(quad: &Quad) -> Option<Self> {
        let across = (0..3).find(|&axis| quad.normal[axis].abs() == 1.0)?;
        let axes = [across, (across + 1) % 3, (across + 2) % 3];
        let in_plane = |v: Vec3| [v[axes[1]], v[axes[2]]];
        let [dual_u, dual_v] = quad.duals();
        let is_level =
            in_plane(quad.normal) == [0.0; 2] && dual_u[across] == 0.0 && dual_v[across] == 0.0;
        is_level.then(|| Self {
            corner: Corner::new(quad, axes),
            dual_u: in_plane(dual_u),
            dual_v: in_plane(dual_v),
        })
    }
}

impl QuadTest for LevelQuad {
    #[inline(always)]
    fn distance(&self, ray: &RayLanes) -> Float {
        self.corner.distance_across(ray)
    }

    #[inline(always)]
    fn contains(&self, ray: &RayLanes, t: Float) -> Mask {
        let p = |i: usize| self.corner.beyond(ray, t, i);
        let p = [p(1), p(2)];
        in_unit_square(dot(self.dual_u, p), dot(self.dual_v, p))
    }
}

/// A quad with one edge parallel to an axis and the other perpendicular to it, such as the side of
/// a box rotated about an axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct UprightQuad {
    /// The components of the corner: first along the two axes perpendicular to the axis-parallel
    /// edge, then along that edge's axis.
    corner: Corner,
    /// The normal and one dual edge, on the two perpendicular axes.
    normal: [f32; 2],
    dual_u: [f32; 2],
    /// The nonzero component of the other dual edge.
    dual_v: f32,
}

impl UprightQuad {
    fn new(quad: &Quad) -> Option<Self> {
        let [u, v] = quad.duals();
        let turns = [(u, v), (v, u)].into_iter().flat_map(|duals| (0..3).map(move |m| (duals, m)));
        for ((u, v), along) in turns {
            let across = [(along + 1) % 3, (along + 2) % 3];
            let is_along = across.iter().all(|&axis| v[axis] == 0.0);
            if is_along && quad.normal[along] == 0.0 && u[along] == 0.0 {
                let axes = [across[0], across[1], along];
                let part = |vector: Vec3| across.map(|axis| vector[axis]);
                return Some(Self {
                    corner: Corner::new(quad, axes),
                    normal: part(quad.normal),
                    dual_u: part(u),
                    dual_v: v[along],
                });
            }
        }
        None
    }
}

impl QuadTest for UprightQuad {
    #[inline(always)]
    fn distance(&self, ray: &RayLanes) -> Float {
        let Self { corner, normal, .. } = self;
        dot(*normal, [corner.ahead(ray, 0), corner.ahead(ray, 1)])
            / dot(*normal, [corner.direction(ray, 0), corner.direction(ray, 1)])
    }

    #[inline(always)]
    fn contains(&self, ray: &RayLanes, t: Float) -> Mask {
        let p = |i: usize| self.corner.beyond(ray, t, i);
        in_unit_square(dot(self.dual_u, [p(0), p(1)]), p(2) * Float::splat(self.dual_v))
    }
}

#[inline(always)]
fn dot(a: [f32; 2], [x, y]: [Float; 2]) -> Float {
    Float::splat(a[0]) * x + Float::splat(a[1]) * y
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::LANES;

    #[test]
    fn both_tests_of_the_unit_square_agree() {
        let (tiny, one) = (f32::from_bits(1), 1.0f32);
        let values = [0.0, tiny, f32::MIN_POSITIVE, 0.5, one.next_down(), one, one.next_up(), 2.0];
        let values: Vec<f32> =
            values.into_iter().chain([f32::INFINITY, f32::NAN]).flat_map(|x| [x, -x]).collect();
        for &a in &values {
            for &b in &values {
                let is_in = (0.0..=1.0).contains(&a) && (0.0..=1.0).contains(&b);
                let all = if is_in { crate::simd::first_bits(LANES) } else { 0 };
                let (va, vb) = (Float::splat(a), Float::splat(b));
                assert_eq!(in_square(va, vb).bits(), all, "{a} {b}");
                assert_eq!(in_square_as_bits(va, vb).bits(), all, "{a} {b}");
            }
        }
    }
}
