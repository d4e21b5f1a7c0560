//! Uniform samples of the solid angle of a triangle, over lanes: the scalar engine's
//! `spherical_triangle.rs`, where source and departures are told, to the bit.

use super::triangle::Triangles;
use crate::engine::contract::{MIN_SINE, MIN_SOLID_ANGLE};
use crate::simd::trig::{atan2, sin_cos};
use crate::simd::{Float, Mask, Vec3x};

/// Triangles as seen from points.
pub(super) struct SphericalTriangle {
    /// Directions to two vertices.
    a: Vec3x,
    b: Vec3x,
    /// Towards the third along the arc from a, perpendicular to a.
    along: Vec3x,
    /// 1 + a·b.
    one_plus_cos: Float,
    /// |det(a, b, along)|.
    det: Float,
    solid_angle: Float,
    /// Where it is large enough and not too edge-on for f32.
    pub(super) exact: Mask,
}

impl SphericalTriangle {
    #[inline(always)]
    pub(super) fn new(triangles: &Triangles, from: Vec3x) -> Self {
        let (one, two) = (Float::splat(1.0), Float::splat(2.0));
        let [p, q, r] = triangles.vertices;
        let (pq, pr) = (q - p, r - p);
        let (to_p, to_q, to_r) = (p - from, q - from, r - from);
        let length = |v: Vec3x| v.dot(v).sqrt();
        let (lp, lq, lr) = (length(to_p), length(to_q), length(to_r));
        let height = to_p.dot(triangles.normal).abs();
        let volume = height * (two * triangles.area);
        let sum = lp * lq * lr + to_p.dot(to_q) * lr + to_p.dot(to_r) * lq + to_q.dot(to_r) * lp;
        let solid_angle = two * atan2(volume, sum);
        let exact = solid_angle.gt(Float::splat(MIN_SOLID_ANGLE))
            & height.gt(Float::splat(MIN_SINE) * lp.max(lq.max(lr)));
        let (a, b) = (to_p * (one / lp), to_q * (one / lq));
        let along = (pr - a * a.dot(pr)).normalize();
        let (det, middle) = (along.cross(a).dot(pq).abs() / lq, a + b);
        let one_plus_cos = Float::splat(0.5) * middle.dot(middle);
        Self { a, b, along, one_plus_cos, det, solid_angle, exact }
    }

    /// Density of [`Self::sample`]'s directions per unit solid angle.
    #[inline(always)]
    pub(super) fn pdf(&self) -> Float {
        Float::splat(1.0) / self.solid_angle
    }

    /// Directions to the triangles.
    #[inline(always)]
    pub(super) fn sample(&self, u: Float, v: Float) -> Vec3x {
        let Self { a, b, along, one_plus_cos, det, solid_angle, .. } = *self;
        let (one, two, half) = (Float::splat(1.0), Float::splat(2.0), Float::splat(0.5));
        let (sin, cos) = sin_cos(half * (u * solid_angle));
        let (y, x) = (one_plus_cos * sin, det * cos - b.dot(along) * sin);
        let (x2, y2) = (x * x, y * y);
        let c = (a * (x2 - y2) + along * (two * x * y)) * (one / (x2 + y2));
        let bc = c - b;
        let one_minus_cos = v * (half * bc.dot(bc));
        let sin = Float::ZERO.max(one_minus_cos * (two - one_minus_cos)).sqrt();
        let towards = (bc - b * b.dot(bc)).normalize();
        (b * (one - one_minus_cos) + towards * sin).normalize()
    }
}
