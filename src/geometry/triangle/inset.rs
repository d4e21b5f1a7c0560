//! Keeps the origins of new rays in front of the faces that rise from a triangle's edges.

use crate::math::{Mask, Real, cross, dot, length, max, min};
use crate::simd::axes;

/// Points stay this many offsets away from the edges.
///
/// Let a face rise from an edge at the angle θ. A point at the height h above the triangle is in front of the
/// face if it is farther than h cot θ from the edge. The rounding errors of the point and of the face's test
/// add up to about an offset, which brings it (1 + cos θ)/sin θ offsets closer: less than 4 for angles above
/// 28°.
const INSET: f32 = 4.0;
/// No point is moved farther than this many insets. Near a vertex, points must move farther than the inset, and
/// at angles below 14° they would have to move farther than this.
const FARTHEST: f32 = 8.0;

/// Moves points that are too close to an edge away from it, along the triangle. Without this, rounding could
/// place the origin of a ray past the face beyond the edge, and the ray would leave a closed mesh.
///
/// `edges` lead from the first vertex to the others, `shares` are the barycentric coordinates for these, and
/// `offset` is the distance from the triangle at which rays begin.
#[inline(always)]
pub(in crate::geometry) fn inset<R: Real>(
    edges: [R::Vec3; 2],
    shares: [R; 2],
    offset: R,
) -> [R; 2] {
    let ([u, v], [second, third]) = (edges, shares);
    let across = cross(u, v);
    let inverse = R::ONE / dot(across, across).sqrt();
    let distance = offset * INSET;
    let least = min(min(second, third), R::ONE - second - third);
    // An upper bound on the share of a point at this distance from an edge, as no edge is longer than the
    // sum of the other two.
    let most = (length(u) + length(v)) * inverse * distance;
    let near = least.lt(most) & inverse.lt(R::INFINITY);
    if !near.any() {
        return shares;
    }
    let moved = away_from_edges(edges, shares, inverse, distance);
    [near.select(moved[0], second), near.select(moved[1], third)]
}

/// The shares of points that are at least at `distance` from each edge, if the triangle has such points.
/// `inverse` is the reciprocal of twice its area.
#[inline(never)]
fn away_from_edges<R: Real>(
    [u, v]: [R::Vec3; 2],
    [second, third]: [R; 2],
    inverse: R,
    distance: R,
) -> [R; 2] {
    let shares = [R::ONE - second - third, second, third];
    let sum = |of: [R; 3]| of[0] + of[1] + of[2];
    // Opposite to each vertex: the length of the edge, and the share of the point there that is closest to the
    // vertex, for the edge's second end. The edges are BC, AC and AB.
    let lengths = [length(v - u), length(v), length(u)];
    let along = dot(u, v);
    let ends = [(dot(u, u) - along, 0), (along, 1), (along, 2)]
        .map(|(product, edge)| product / (lengths[edge] * lengths[edge]));
    // The shares of a point at the distance from an edge. In a triangle without room, all are those of the
    // centre of its incircle.
    let least = lengths.map(|length| length * inverse * distance);
    let room = min(R::ONE, R::ONE / sum(least));
    let least = least.map(|share| share * room);
    // Move perpendicularly away from each edge, then away from the vertices.
    let up: [R; 3] = axes(|i| max(least[i] - shares[i], R::ZERO));
    let down = [
        up[1] * (R::ONE - ends[1]) + up[2] * (R::ONE - ends[2]),
        up[0] * (R::ONE - ends[0]) + up[2] * ends[2],
        up[0] * ends[0] + up[1] * ends[1],
    ];
    let moved: [R; 3] = axes(|i| max(shares[i] + up[i] - down[i], least[i]));
    let spare = max(sum(moved) - sum(least), R::splat(f32::MIN_POSITIVE));
    let factor = (R::ONE - sum(least)) / spare;
    let step: [R; 2] = [1, 2].map(|i| least[i] + (moved[i] - least[i]) * factor - shares[i]);
    let reach = length(u * step[0] + v * step[1]);
    let part = min(R::ONE, distance * FARTHEST / reach);
    [second + step[0] * part, third + step[1] * part]
}
