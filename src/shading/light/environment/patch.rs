//! Patches of an environment map: the parts of the image between the centres of four texels.
//!
//! The grid of patches has a line through the centres of each row and each column of texels, and along the
//! edges of the image. So the patches at the edges are half as large.

use crate::math::{Real, Vector, clamp, max, min};
use crate::shading::LUMINANCE;

/// Patches of this mean luminance or less are as black: they are not drawn.
pub(super) const BLACK: f32 = 1e-36;

/// The position of line `number` of the grid along an axis of `size` texels, and the texels whose mean is the
/// value there.
pub(super) fn line(number: u32, size: u32) -> (f64, [i32; 2]) {
    let (last, number) = (size as i32, number as i32);
    match number {
        0 => (0.0, [-1, 0]),
        _ if number > last => (f64::from(size), [last - 1, last]),
        _ => (f64::from(number) - 0.5, [number - 1; 2]),
    }
}

/// The extent of a patch along an axis, in texels.
#[derive(Clone, Copy)]
pub(super) struct Span<R> {
    /// The centre of the first texel.
    first: R,
    /// The ends of the patch.
    low: R,
    high: R,
}

impl<R: Real> Span<R> {
    /// The span of the patch with the number `number` along an axis of `size` texels.
    #[inline(always)]
    pub(super) fn new(number: R, size: u32) -> Self {
        let first = number - R::splat(0.5);
        let high = min(number + 0.5, R::splat(size as f32));
        Self { first, low: max(first, R::ZERO), high }
    }

    /// The weight of the second texel at the position `x`, which rounding may have moved out of the patch.
    #[inline(always)]
    fn weight(&self, x: R) -> R {
        clamp(x - self.first, R::ZERO, R::ONE)
    }

    #[inline(always)]
    pub(super) fn len(&self) -> R {
        self.high - self.low
    }
}

/// A patch, or one per lane.
pub(super) struct Patch<R: Real> {
    /// The radiance of the texels: upper left, upper right, lower left and lower right.
    texels: [R::Vec3; 4],
    spans: [Span<R>; 2],
    /// The luminance at the corners, in the same order, divided by the mean of the four.
    corners: [R; 4],
    /// The reciprocal of its size, as a share of a whole patch.
    per_size: R,
}

/// The bilinear function with the values `of` at the corners of the unit square.
#[inline(always)]
fn bilinear<R: Real>(of: [R; 4], (x, y): (R, R)) -> R {
    let upper = of[0] + (of[1] - of[0]) * x;
    let lower = of[2] + (of[3] - of[2]) * x;
    upper + (lower - upper) * y
}

/// The position in [0, 1] that the uniform number `u` draws with a density that is linear between `a` at 0 and
/// `b` at 1, which are at most 4.
#[inline(always)]
fn linear<R: Real>(u: R, a: R, b: R) -> R {
    let root = (a * a + u * (b * b - a * a)).sqrt();
    min(u * (a + b) / max(a + root, R::splat(1e-12)), R::ONE)
}

impl<R: Real> Patch<R> {
    /// Creates the patch with these spans between texels, whose channels are `taps`. `tall` is its height as a
    /// share of a whole patch.
    #[inline(always)]
    pub(super) fn new(taps: &[R; 12], spans: [Span<R>; 2], tall: R) -> Self {
        let tap = |i: usize| R::Vec3::new(taps[3 * i], taps[3 * i + 1], taps[3 * i + 2]);
        let texels = [tap(0), tap(1), tap(2), tap(3)];
        let luminance = |i: usize| {
            let [r, g, b] = LUMINANCE;
            texels[i][0] * r as f32 + texels[i][1] * g as f32 + texels[i][2] * b as f32
        };
        let luminances = [luminance(0), luminance(1), luminance(2), luminance(3)];
        let [across, down] = spans;
        let (left, right) = (across.weight(across.low), across.weight(across.high));
        let (upper, lower) = (down.weight(down.low), down.weight(down.high));
        let (a, b) = (bilinear(luminances, (left, upper)), bilinear(luminances, (right, upper)));
        let (c, d) = (bilinear(luminances, (left, lower)), bilinear(luminances, (right, lower)));
        let each = R::ONE / max((a + b + c + d) * 0.25, R::splat(BLACK));
        let corners = [a * each, b * each, c * each, d * each];
        Self { texels, spans, corners, per_size: R::ONE / (across.len() * tall) }
    }

    /// The radiance at a position in the patch, in texels from the upper left corner of the map.
    #[inline(always)]
    pub(super) fn radiance(&self, x: R, y: R) -> R::Vec3 {
        let [across, down] = self.spans;
        let (x, y) = (across.weight(x), down.weight(y));
        let row = |i: usize| self.texels[i] * (R::ONE - x) + self.texels[i + 1] * x;
        row(0) * (R::ONE - y) + row(2) * y
    }

    /// The place in the patch, from (0, 0) to (1, 1), of a position in texels.
    #[inline(always)]
    pub(super) fn place(&self, x: R, y: R) -> (R, R) {
        let [across, down] = self.spans;
        ((x - across.low) / across.len(), (y - down.low) / down.len())
    }

    /// The position in texels of a place in the patch.
    #[inline(always)]
    pub(super) fn at(&self, across: R, down: R) -> (R, R) {
        let [x, y] = self.spans;
        (x.low + x.len() * across, y.low + y.len() * down)
    }

    /// The nearest position of the patch, from top to bottom, in texels.
    #[inline(always)]
    pub(super) fn clamp_down(&self, y: R) -> R {
        let [_, down] = self.spans;
        clamp(y, down.low, down.high)
    }

    /// The density with which [`Patch::sample`] draws a place, in relation to a uniform density in a patch of whole
    /// size.
    #[inline(always)]
    pub(super) fn density(&self, across: R, down: R) -> R {
        max(bilinear(self.corners, (across, down)), R::ZERO) * self.per_size
    }

    /// The place that two uniform numbers draw.
    #[inline(always)]
    pub(super) fn sample(&self, (u, v): (R, R)) -> (R, R) {
        let [a, b, c, d] = self.corners;
        let down = linear(v, a + b, c + d);
        (linear(u, a + (c - a) * down, b + (d - b) * down), down)
    }
}
