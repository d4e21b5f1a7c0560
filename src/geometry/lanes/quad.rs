//! Quads over lanes.

use glam::Vec3;

use super::{HitLanes, RayLanes};
use crate::geometry::Quad;
use crate::simd::{Float, Int, Mask, Vec3x};

/// Quads by what their test needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuadLanes {
    pub(crate) q: Vec3x,
    pub(crate) normal: Vec3x,
    pub(crate) dual_u: Vec3x,
    pub(crate) dual_v: Vec3x,
}

/// Hits of quads above `t_min`.
///
/// With `ASK`, `None` where no lane meets a plane there and up to `limit`, found by a branch: it
/// pays where lanes are alike, and costs more than it saves where they go all ways. Hits do not
/// look at `limit`: it would make each quad wait for the one before.
#[inline(always)]
pub(crate) fn quad<const ASK: bool>(
    ray: &RayLanes,
    quad: &QuadLanes,
    limit: Float,
) -> Option<HitLanes> {
    // The scalar test has the corner and the ray change places; signs do not round.
    let to_corner = quad.q - ray.origin;
    let t = quad.normal.dot(to_corner) / quad.normal.dot(ray.direction);
    let above = above::<ASK>(ray, t, limit)?;
    let p = ray.direction * t - to_corner;
    let inside = in_unit_square(p.dot(quad.dual_u), p.dot(quad.dual_v));
    Some(HitLanes { t, hit: above & inside })
}

/// Where `t` is above `t_min`; with `ASK`, `None` where nowhere there and up to `limit`.
#[inline(always)]
fn above<const ASK: bool>(ray: &RayLanes, t: Float, limit: Float) -> Option<Mask> {
    let above = t.gt(ray.t_min);
    if ASK && !(above & t.le(limit)).any() { None } else { Some(above) }
}

/// Where `a` and `b` are from 0 to 1.
#[inline(always)]
fn in_unit_square(a: Float, b: Float) -> Mask {
    if cfg!(target_feature = "avx512f") {
        // As integers the bits of such floats are the least, but for −0, which this makes 0. Four
        // comparisons of floats cost more here, and less elsewhere (`profiling/`).
        let bits = |x: Float| (x + Float::ZERO).to_bits();
        bits(a).max(bits(b)).le(Int::splat(1.0f32.to_bits()))
    } else {
        let in_unit = |x: Float| Float::ZERO.le(x) & x.le(Float::splat(1.0));
        in_unit(a) & in_unit(b)
    }
}

/// A quad of whose numbers many are 0, and which is tested by less work: its `hits` are those that
/// [`quad`] finds, of rays whose coordinates do not overflow on the way to the plane. Kernels leave
/// others to the reference.
///
/// Sums of two numbers have no order, and products with 0 add nothing, but for the sign of zero,
/// which no comparison sees, or for infinite factors: those come with `t` or a coordinate beyond
/// the quad, a miss either way.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SpecialQuad {
    /// Both edges are along axes.
    Aligned(AlignedQuad),
    /// The plane is across an axis, the edges are along none.
    Level(LevelQuad),
    /// One edge is along an axis, the other across it.
    Upright(UprightQuad),
}

impl SpecialQuad {
    /// `quad`, if it is such a one.
    pub(crate) fn new(quad: &Quad) -> Option<Self> {
        let aligned = || AlignedQuad::new(quad).map(Self::Aligned);
        let level = || LevelQuad::new(quad).map(Self::Level);
        let upright = || UprightQuad::new(quad).map(Self::Upright);
        aligned().or_else(level).or_else(upright)
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
    pub(crate) fn hits<const ASK: bool>(&self, ray: &RayLanes, limit: Float) -> Option<HitLanes> {
        let Self { axes, q, duals } = *self;
        let to_corner = |i: usize| Float::splat(q[i]) - ray.origin[axes[i]];
        let t = to_corner(0) / ray.direction[axes[0]];
        let above = above::<ASK>(ray, t, limit)?;
        let p = |i: usize| ray.direction[axes[i]] * t - to_corner(i);
        let along = |i: usize| p(i) * Float::splat(duals[i - 1]);
        Some(HitLanes { t, hit: above & in_unit_square(along(1), along(2)) })
    }
}

/// A quad whose plane lies across an axis, and its edges as they will, as the lids of boxes that
/// are turned about an axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LevelQuad {
    /// The axis across, and those in the plane.
    axes: [usize; 3],
    /// Corner, in this order of axes.
    q: [f32; 3],
    /// In the plane.
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
            axes,
            q: axes.map(|axis| quad.q[axis]),
            dual_u: in_plane(dual_u),
            dual_v: in_plane(dual_v),
        })
    }

    #[inline(always)]
    pub(crate) fn hits<const ASK: bool>(&self, ray: &RayLanes, limit: Float) -> Option<HitLanes> {
        let Self { axes, q, dual_u, dual_v } = *self;
        let to_corner = |i: usize| Float::splat(q[i]) - ray.origin[axes[i]];
        let t = to_corner(0) / ray.direction[axes[0]];
        let above = above::<ASK>(ray, t, limit)?;
        let p = |i: usize| ray.direction[axes[i]] * t - to_corner(i);
        let p = [p(1), p(2)];
        Some(HitLanes { t, hit: above & in_unit_square(dot(dual_u, p), dot(dual_v, p)) })
    }
}

/// A quad with one edge along an axis and the other across it, as the sides of boxes that are
/// turned about an axis.
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
    pub(crate) fn hits<const ASK: bool>(&self, ray: &RayLanes, limit: Float) -> Option<HitLanes> {
        let Self { axes, q, normal, dual_u, dual_v } = *self;
        let to_corner = |i: usize| Float::splat(q[i]) - ray.origin[axes[i]];
        let direction = |i: usize| ray.direction[axes[i]];
        let t =
            dot(normal, [to_corner(0), to_corner(1)]) / dot(normal, [direction(0), direction(1)]);
        let above = above::<ASK>(ray, t, limit)?;
        let p = |i: usize| direction(i) * t - to_corner(i);
        let (a, b) = (dot(dual_u, [p(0), p(1)]), p(2) * Float::splat(dual_v));
        Some(HitLanes { t, hit: above & in_unit_square(a, b) })
    }
}

#[inline(always)]
fn dot(a: [f32; 2], [x, y]: [Float; 2]) -> Float {
    Float::splat(a[0]) * x + Float::splat(a[1]) * y
}
