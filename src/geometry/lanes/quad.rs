//! Quads over lanes.

use glam::Vec3;

use super::{HitLanes, RayLanes};
use crate::geometry::Quad;
use crate::simd::{Float, Mask, Vec3x};

/// Quads by what their test needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuadLanes {
    pub(crate) q: Vec3x,
    pub(crate) normal: Vec3x,
    pub(crate) dual_u: Vec3x,
    pub(crate) dual_v: Vec3x,
}

/// Hits of quads above `t_min` and up to `limit`.
///
/// With `ASK`, `None` where no lane meets a plane there, found by a branch: it pays where lanes are
/// alike, and costs more than it saves where they go all ways.
#[inline(always)]
pub(crate) fn quad<const ASK: bool>(
    ray: &RayLanes,
    quad: &QuadLanes,
    limit: Float,
) -> Option<HitLanes> {
    let from_corner = ray.origin - quad.q;
    let t = -quad.normal.dot(from_corner) / quad.normal.dot(ray.direction);
    let near = t.gt(ray.t_min) & t.le(limit);
    if ASK && !near.any() {
        return None;
    }
    let p = from_corner + ray.direction * t;
    let (a, b) = (p.dot(quad.dual_u), p.dot(quad.dual_v));
    Some(HitLanes { t, hit: near & in_unit(a) & in_unit(b) })
}

/// Where `a` is from 0 to 1.
#[inline(always)]
fn in_unit(a: Float) -> Mask {
    Float::ZERO.le(a) & a.le(Float::splat(1.0))
}

/// A quad of whose numbers many are 0, and which is tested by less work.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SpecialQuad {
    /// Both edges are along axes.
    Aligned(AlignedQuad),
    /// One edge is along an axis, the other across it.
    Upright(UprightQuad),
}

impl SpecialQuad {
    /// `quad`, if it is such a one.
    pub(crate) fn new(quad: &Quad) -> Option<Self> {
        let aligned = AlignedQuad::new(quad).map(Self::Aligned);
        aligned.or_else(|| UprightQuad::new(quad).map(Self::Upright))
    }

    /// Hits as [`quad`] finds them, of rays whose coordinates do not overflow on the way to the
    /// plane: kernels leave others to the reference.
    ///
    /// Sums of two numbers have no order, and products with 0 add nothing, but for the sign of
    /// zero, which no comparison sees, or for infinite factors: those come with `t` or a coordinate
    /// beyond the quad, a miss either way.
    #[inline(always)]
    pub(crate) fn hits<const ASK: bool>(&self, ray: &RayLanes, limit: Float) -> Option<HitLanes> {
        match self {
            Self::Aligned(quad) => quad.hits::<ASK>(ray, limit),
            Self::Upright(quad) => quad.hits::<ASK>(ray, limit),
        }
    }
}

/// A quad with both edges along axes, as walls and tables: its plane is met where one coordinate is
/// its corner's, and each edge asks for one more.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AlignedQuad {
    /// The axis across, and those of the edges.
    axes: [usize; 3],
    /// Corner, in this order of axes.
    q: [f32; 3],
    /// Along each edge.
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
        // Signs of the normal cancel in its distance, other factors might round.
        (quad.normal[axes[0]].abs() == 1.0).then(|| Self {
            axes,
            q: axes.map(|axis| quad.q[axis]),
            duals: [dual_u[axes[1]], dual_v[axes[2]]],
        })
    }

    #[inline(always)]
    fn hits<const ASK: bool>(&self, ray: &RayLanes, limit: Float) -> Option<HitLanes> {
        let from = |i: usize| ray.origin[self.axes[i]] - Float::splat(self.q[i]);
        let t = -from(0) / ray.direction[self.axes[0]];
        let near = t.gt(ray.t_min) & t.le(limit);
        if ASK && !near.any() {
            return None;
        }
        let at = |i: usize| {
            let p = from(i) + ray.direction[self.axes[i]] * t;
            p * Float::splat(self.duals[i - 1])
        };
        Some(HitLanes { t, hit: near & in_unit(at(1)) & in_unit(at(2)) })
    }
}

/// A quad with one edge along an axis and the other across it, as the sides of boxes that are
/// turned about an axis: four of its numbers are 0, and it is tested by half the work.
#[derive(Clone, Copy, Debug)]
pub(crate) struct UprightQuad {
    /// The two axes across the edge, and the one along it.
    axes: [usize; 3],
    /// Corner, in this order of axes.
    q: [f32; 3],
    /// Across the edge.
    normal: [f32; 2],
    dual_u: [f32; 2],
    /// Along the edge.
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
                    axes,
                    q: axes.map(|axis| quad.q[axis]),
                    normal: part(quad.normal),
                    dual_u: part(u),
                    dual_v: v[along],
                });
            }
        }
        None
    }

    #[inline(always)]
    fn hits<const ASK: bool>(&self, ray: &RayLanes, limit: Float) -> Option<HitLanes> {
        let dot =
            |a: &[f32; 2], [x, y]: [Float; 2]| Float::splat(a[0]) * x + Float::splat(a[1]) * y;
        let [x, y, z] = self.axes;
        let from = |i: usize| ray.origin[self.axes[i]] - Float::splat(self.q[i]);
        let [fx, fy] = [from(0), from(1)];
        let (dx, dy) = (ray.direction[x], ray.direction[y]);
        let t = -dot(&self.normal, [fx, fy]) / dot(&self.normal, [dx, dy]);
        let near = t.gt(ray.t_min) & t.le(limit);
        if ASK && !near.any() {
            return None;
        }
        let a = dot(&self.dual_u, [fx + dx * t, fy + dy * t]);
        let b = (from(2) + ray.direction[z] * t) * Float::splat(self.dual_v);
        Some(HitLanes { t, hit: near & in_unit(a) & in_unit(b) })
    }
}
