//! Fireflies: pixels far brighter than all their neighbours, which no filter could spread without a visible spot.

use super::planes::Plane;
use crate::math::Real;
use crate::simd::Float;

/// How much brighter than the brightest of its neighbours a pixel may be.
const MOST: f32 = 2.0;

/// A colour in three planes.
pub(super) type Color = [Plane; 3];

fn brightness(color: &Color) -> Plane {
    let [sum] =
        Plane::compute(color[0].size(), |i| [color[0].at(i) + color[1].at(i) + color[2].at(i)]);
    sum
}

/// The largest of a pixel's eight neighbours.
#[inline(always)]
fn brightest_around(plane: &Plane, index: usize) -> Float {
    let ring = [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)];
    ring.iter().fold(Float::splat(0.0), |most, &(dx, dy)| most.max(plane.near(index, dx, dy)))
}

/// Scales down by what `most` allows the pixels that are brighter than all their neighbours.
fn scaled_down(color: &Color, most: impl Fn(&Plane, usize) -> Float) -> Color {
    let own = brightness(color);
    Plane::compute(own.size(), |i| {
        let (limit, bright) = (most(&own, i) * MOST, own.at(i).abs());
        let factor = bright.gt(limit).select(limit / bright, Float::splat(1.0));
        [0, 1, 2].map(|c: usize| color[c].at(i) * factor)
    })
}

/// Limits the pixels of one half of the samples that are brighter than all their neighbours in both halves: two
/// independent halves rarely have a firefly in the same place.
pub(super) fn limited_half(half: &Color, other: &Color) -> Color {
    let other = brightness(other);
    scaled_down(half, |own, i| {
        brightest_around(own, i).max(brightest_around(&other, i)).max(other.at(i))
    })
}

/// Limits the pixels that are brighter than all their neighbours, unless both halves have them.
pub(super) fn limited(color: &Color, halves: Option<&[Color; 2]>) -> Color {
    let halves = halves.map(|halves| halves.each_ref().map(brightness));
    scaled_down(color, |own, i| {
        let most = brightest_around(own, i);
        halves.as_ref().map_or(most, |[even, odd]| most.max(even.at(i).min(odd.at(i))))
    })
}

#[cfg(test)]
mod tests {
    use super::super::planes::{Size, Window};
    use super::*;

    #[test]
    fn single_bright_pixels_are_limited() {
        let size = Size { width: 16, height: 9 };
        let window = Window { image: [16, 9], left: 0, top: 0, size };
        let noise = |pixel: usize| 1.0 + 0.1 * (pixel * 7 % 5) as f32;
        let fireflies = |at: usize| -> Color {
            let value = |pixel| if pixel == at { 1e30 } else { noise(pixel) };
            window.load(&(0..144).map(|pixel| [value(pixel); 3]).collect::<Vec<_>>(), |x| x)
        };
        let (even, odd) = (fireflies(70), fireflies(17));
        let even = limited_half(&even, &odd);
        assert!((1.0..=2.8).contains(&even[0].row(4)[6]));
        assert_eq!(even[1].row(4)[5], noise(69));
        let bright = limited(&odd, None)[2].row(1)[1];
        assert!((1.0..=2.8).contains(&bright), "{bright}");
    }
}
