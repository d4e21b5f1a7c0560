//! Guides: what is compared to find pixels that show the same light.

use super::fireflies::Color;
use super::planes::Plane;
use crate::math::Real;
use crate::simd::Float;

/// How much slopes count beside the mean colour.
const SLOPE: f32 = 0.07;
/// How much it counts that a pixel is brighter than the mean around it.
const PEAK: f32 = 0.2;
/// Numbers that describe the surroundings of a pixel.
pub(super) const NUMBERS: usize = 6;

/// The light around each pixel. Single pixels are too noisy to be compared, and means alone would not tell the two sides
/// of an edge apart.
#[derive(Clone, Copy)]
pub(super) struct Guide<'a> {
    /// The mean colour of 3 × 3 pixels, the slopes of their brightness, and by how much the pixel exceeds the mean.
    pub(super) planes: &'a [Plane; NUMBERS],
    /// The variance of these numbers together.
    pub(super) noise: &'a Plane,
}

/// The numbers that describe the surroundings of each pixel.
pub(super) fn numbers(color: &Color) -> [Plane; NUMBERS] {
    Plane::compute(color[0].size(), |i| {
        let zero = Float::splat(0.0);
        let (mut means, mut across, mut down, mut peak) = ([zero; 3], zero, zero, zero);
        for (plane, mean) in color.iter().zip(&mut means) {
            let near = |dx, dy| plane.near(i, dx, dy);
            let [left, mid, right] = [-1, 0, 1].map(|x| near(x, -1) + near(x, 0) + near(x, 1));
            let [above, below] = [-1, 1].map(|y| near(-1, y) + near(0, y) + near(1, y));
            *mean = (left + mid + right) * Float::splat(1.0 / 9.0);
            peak = peak + (plane.at(i) - *mean);
            across = across + (right - left);
            down = down + (below - above);
        }
        let [red, green, blue] = means;
        let (across, down) = (across * Float::splat(SLOPE), down * Float::splat(SLOPE));
        [red, green, blue, across, down, peak * Float::splat(PEAK)]
    })
}
