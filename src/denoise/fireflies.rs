//! Fireflies: pixels far brighter than all their neighbours, which no filter could spread without a visible spot.

use super::planes::{Plane, Size};
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

/// Scales down pixels that are brighter than all their neighbours in `color` and, if it is given, the same part of
/// `other`: two independent halves rarely have a firefly in the same place.
pub(super) fn limited(color: &Color, other: Option<&Color>, size: Size) -> Color {
    let own = brightness(color);
    let other = other.map(brightness);
    Plane::compute(size, |i| {
        let mut most = brightest_around(&own, i);
        if let Some(other) = &other {
            most = most.max(brightest_around(other, i)).max(other.at(i));
        }
        let (limit, bright) = (most * MOST, own.at(i).abs());
        let factor = bright.gt(limit).select(limit / bright, Float::splat(1.0));
        [0, 1, 2].map(|c: usize| color[c].at(i) * factor)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_bright_pixels_are_limited() {
        let size = Size { width: 9, height: 9 };
        let noise = |pixel: usize| 1.0 + 0.1 * (pixel * 7 % 5) as f32;
        let fireflies =
            |at: usize| move |pixel: usize| if pixel == at { [1e30; 3] } else { [noise(pixel); 3] };
        let (even, odd) = (Plane::of_rows(size, fireflies(40)), Plane::of_rows(size, fireflies(0)));
        let limited_even = limited(&even, Some(&odd), size);
        assert!((1.0..=2.8).contains(&limited_even[0].pixel(4, 4)));
        assert_eq!(limited_even[1].pixel(3, 4), noise(39));
        let corner = limited(&odd, None, size)[2].pixel(0, 0);
        assert!((1.0..=2.8).contains(&corner), "{corner}");
    }
}
