//! Triangles over lanes.

use super::{distance, distance_by_select};
use crate::math::UNIT_ROUNDOFF;
use crate::simd::{Bits, Float, LANES, Lanes, Mask, Vec3x, axes};

/// Vertices as their rays see them: sideways, sideways, ahead.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShearedTriangles {
    vertices: [[Float; 3]; 3],
    candidates: Mask,
}

/// Triangles filtered, then decided (contract, rule 1): f32 edge functions whose sign is sure
/// reject nearly all lanes, the rest are decided in f64.
///
/// `origin` and `vertices` are in the order of [`crate::geometry::PreparedRay`]'s axes, and `shear`
/// is what takes the rays' directions to (0, 0, 1) there.
#[inline(always)]
pub(crate) fn shear(
    origin: [Float; 3],
    shear: Vec3x,
    vertices: [[Float; 3]; 3],
) -> ShearedTriangles {
    let vertices = axes(|i| {
        let p = axes(|axis| vertices[i][axis] - origin[axis]);
        [p[0] - shear[0] * p[2], p[1] - shear[1] * p[2], shear[2] * p[2]]
    });
    let [a, b, c] = vertices;
    // a b − c d is off by the roundings of two products (fused: one) and of their difference, in
    // all less than 5 of what no product exceeds; the tiny number is for underflow.
    let most = |axis: usize| a[axis].abs().max(b[axis].abs()).max(c[axis].abs());
    let margin = Float::splat(5.0 * UNIT_ROUNDOFF);
    let error = (most(0) * most(1)).free_mul_add(margin, Float::splat(1e-36));
    let edge = |from: [Float; 3], to: [Float; 3]| {
        let value = from[0].free_mul_sub(to[1], from[1] * to[0]);
        (value.gt(error), value.lt(-error))
    };
    let ((up, un), (vp, vn), (wp, wn)) = (edge(b, c), edge(c, a), edge(a, b));
    let mixed = (up | vp | wp) & (un | vn | wn);
    ShearedTriangles { vertices, candidates: !mixed }
}

/// Up to so many lanes are decided one by one, more all at once. Twice as many: 1% less on v3.
const MOST_ALONE: u32 = LANES as u32 / 8;

impl ShearedTriangles {
    /// The lanes, among those of `valid`, that cannot be ruled out.
    #[inline(always)]
    pub(crate) fn candidates(&self, valid: u32) -> u32 {
        self.candidates.bits() & valid
    }

    /// Distances in the lanes of `candidates`, NaN for misses; in others, anything.
    #[inline(always)]
    pub(crate) fn distances(&self, candidates: u32) -> Float {
        let lanes: [[Lanes; 3]; 3] = axes(|i| axes(|axis| self.vertices[i][axis].to_array()));
        let sheared = |lane: usize| axes(|i| axes(|axis| lanes[i][axis][lane]));
        let mut distances = [0.0; LANES];
        if candidates.count_ones() > MOST_ALONE {
            for (lane, t) in distances.iter_mut().enumerate() {
                *t = distance_by_select(sheared(lane));
            }
        } else {
            for lane in Bits(candidates) {
                distances[lane] = distance(sheared(lane));
            }
        }
        Float::new(distances)
    }

    /// Calls `visit` with each candidate's lane and distance, NaN for a miss.
    #[inline(always)]
    pub(crate) fn decide(&self, candidates: u32, mut visit: impl FnMut(usize, f32)) {
        let lanes: [[Lanes; 3]; 3] = axes(|i| axes(|axis| self.vertices[i][axis].to_array()));
        for lane in Bits(candidates) {
            let sheared = axes(|i| axes(|axis| lanes[i][axis][lane]));
            visit(lane, distance(sheared));
        }
    }
}
