//! Tests of triangles and rays in lanes.

use super::{distance, distance_by_select};
use crate::math::UNIT_ROUNDOFF;
use crate::simd::{Bits, Float, LANES, Lanes, Mask, Vec3x, axes};

/// Triangles in the coordinates of their rays, and the lanes that may hit. Each vertex has two
/// coordinates across the ray, followed by its distance along the ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShearedTriangles {
    vertices: [[Float; 3]; 3],
    candidates: Mask,
}

/// Shears triangles and filters the lanes: f32 edge functions whose signs are certain reject nearly
/// all misses. The remaining candidates are decided in f64 (rule 1 of the contract in
/// ARCHITECTURE.md).
///
/// `origin` and `vertices` are in the order of [`crate::geometry::PreparedRay`]'s axes, and `shear`
/// maps the rays' directions to (0, 0, 1) in that order.
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
    // The error of a b − c d comes from the roundings of two products (one if fused) and of their
    // difference. In total it is below 5 unit roundoffs of `most(0) * most(1)`, which no product
    // exceeds. The tiny summand covers underflow.
    let most = |axis: usize| a[axis].abs().max(b[axis].abs()).max(c[axis].abs());
    let margin = Float::splat(5.0 * UNIT_ROUNDOFF);
    let error = (most(0) * most(1)).free_mul_add(margin, Float::splat(1e-36));
    let edge = |from: [Float; 3], to: [Float; 3]| from[0].free_mul_sub(to[1], from[1] * to[0]);
    let (u, v, w) = (edge(b, c), edge(c, a), edge(a, b));
    let (high, low) = (u.max(v).max(w), u.min(v).min(w));
    let mixed = high.gt(error) & low.lt(-error);
    ShearedTriangles { vertices, candidates: !mixed }
}

/// Up to this many candidates are decided one by one. If there are more, all lanes are decided at
/// once. Twice this limit is 1% slower on x86-64-v3.
const MOST_ALONE: u32 = LANES as u32 / 8;

impl ShearedTriangles {
    /// The lanes of `valid` that the filter has not rejected.
    #[inline(always)]
    pub(crate) fn candidates(&self, valid: u32) -> u32 {
        self.candidates.bits() & valid
    }

    /// Distances in the lanes of `candidates`, NaN for misses. The other lanes are unspecified.
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

    /// Calls `visit` with the lane and distance of each candidate. The distance is NaN for a miss.
    /// `SELECT` decides misses without a branch.
    #[inline(always)]
    pub(crate) fn decide<const SELECT: bool>(
        &self,
        candidates: u32,
        mut visit: impl FnMut(usize, f32),
    ) {
        let lanes: [[Lanes; 3]; 3] = axes(|i| axes(|axis| self.vertices[i][axis].to_array()));
        for lane in Bits(candidates) {
            let sheared = axes(|i| axes(|axis| lanes[i][axis][lane]));
            visit(lane, if SELECT { distance_by_select(sheared) } else { distance(sheared) });
        }
    }
}
