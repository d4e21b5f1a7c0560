//! Uniform samples of the solid angle of a rectangle, over lanes: the scalar engine's
//! `spherical_rectangle.rs`, where source and departures are told, to the bit.

use super::quad::Quads;
use crate::engine::contract::{MIN_SINE, MIN_SOLID_ANGLE};
use crate::simd::trig::{atan2, sin_cos};
use crate::simd::{Float, Mask, Vec3x};

/// Rectangles as seen from points, in their own frames about these.
pub(super) struct SphericalRectangle<'a> {
    quads: &'a Quads,
    from: Vec3x,
    /// Edges; y mirrored where `mirrored`.
    x: (Float, Float),
    y: (Float, Float),
    mirrored: Mask,
    /// Height of the rectangle's plane over the point, signed.
    height: Float,
    /// Angle of the first sample.
    start: Float,
    solid_angle: Float,
    /// Where it is large enough and not too edge-on for f32.
    pub(super) exact: Mask,
}

impl<'a> SphericalRectangle<'a> {
    #[inline(always)]
    pub(super) fn new(quads: &'a Quads, from: Vec3x) -> Self {
        let to_corner = quads.corner - from;
        let along = |axis: usize| to_corner.dot(quads.axes[axis]);
        let (x0, y0, height) = (along(0), along(1), along(2));
        let (x1, y1) = (x0 + quads.size.0, y0 + quads.size.1);
        let mirrored = (y0 + y1).lt(Float::ZERO);
        let (y0, y1) = (mirrored.select(-y1, y0), mirrored.select(-y0, y1));
        let z2 = height * height;
        let distance = |x: Float, y: Float| (x * x + y * y + z2).sqrt();
        let farthest = distance(x0.abs().max(x1.abs()), y1);
        let angle = |x: Float, y: Float| atan2(x * y, height.abs() * distance(x, y));
        let (a2, a3) = (-angle(x0, y1), angle(x0, y0));
        let solid_angle = (angle(x1, y1) + a2) - (angle(x1, y0) - a3);
        let exact = solid_angle.gt(Float::splat(MIN_SOLID_ANGLE))
            & height.abs().gt(Float::splat(MIN_SINE) * farthest);
        let start = -(a2 + a3);
        let (x, y) = ((x0, x1), (y0, y1));
        Self { quads, from, x, y, mirrored, height, start, solid_angle, exact }
    }

    /// Density of [`Self::sample`]'s directions per unit solid angle.
    #[inline(always)]
    pub(super) fn pdf(&self) -> Float {
        Float::splat(1.0) / self.solid_angle
    }

    /// Points of the rectangle.
    #[inline(always)]
    pub(super) fn sample(&self, u: Float, v: Float) -> Vec3x {
        let (one, half) = (Float::splat(1.0), Float::splat(0.5));
        let (y0, y1) = self.y;
        let z2 = self.height * self.height;
        // z components of the normals of the planes through the edges at y0 and y1.
        let (d0, d1) = ((y0 * y0 + z2).sqrt(), (y1 * y1 + z2).sqrt());
        let (b0, b1) = (-y0 / d0, y1 / d1);
        // Their sum; as a quotient where they all but cancel.
        let quotient = z2 * ((y1 - y0) * (y1 + y0)) / (d0 * d1 * (y1 * d0 + y0 * d1));
        let sum = y0.gt(Float::ZERO).select(quotient, b0 + b1);
        // The column whose share of the solid angle to its left is u.
        let angle = self.start + u * self.solid_angle;
        let (sin, _) = sin_cos(angle);
        let (half_sin, _) = sin_cos(half * angle);
        let n = sum - b0 * (Float::splat(2.0) * half_sin * half_sin); // b0 cos + b1
        let radicand = n * n - sin * sin * (z2 / (d0 * d0));
        let side = n.lt(Float::ZERO).select(-sin, sin);
        let x = self.height.abs() * side / radicand.max(Float::ZERO).sqrt();
        let x = x.max(self.x.0).min(self.x.1);
        // The height in that column, uniform in the sine of its elevation.
        let d2 = x * x + z2;
        let elevation = |y: Float| y / (d2 + y * y).sqrt();
        let (h0, h1) = (elevation(y0), elevation(y1));
        let h = h0 + v * (h1 - h0);
        let y = h * d2.sqrt() / ((one - h) * (one + h)).max(Float::splat(1e-12)).sqrt();
        let y = y.max(y0).min(y1);
        let [ax, ay, az] = self.quads.axes;
        self.from + ax * x + ay * self.mirrored.select(-y, y) + az * self.height
    }
}
