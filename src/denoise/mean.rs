//! Weighted means of neighbours.

use super::fireflies::Color;
use super::guide::Guide;
use super::input::Features;
use super::neighbors::{Neighbors, largest};
use super::planes::Plane;
use crate::math::Real;
use crate::simd::Float;

/// Filters each of `colors` with the weights of its guide. Leaves out the outermost `inset` pixels.
pub(super) fn means<const N: usize>(
    features: &Features,
    guides: [Guide; N],
    colors: [&Color; N],
    neighbors: &Neighbors,
    inset: usize,
) -> [Color; N] {
    let size = colors[0][0].size();
    let offsets = neighbors.offsets(size);
    let mut results = colors.map(|color| color.each_ref().map(|plane| Plane::new(plane.size())));
    for i in size.inside(inset) {
        let here = neighbors.features(features, i);
        let guides = guides.map(|guide| neighbors.guide(guide, i));
        let mut sums = [[Float::splat(0.0); 4]; N];
        for &offset in &offsets {
            let neighbor = i.wrapping_add_signed(offset);
            let features = largest(&here.differences(neighbor));
            for ((guide, color), sums) in guides.iter().zip(colors).zip(&mut sums) {
                let weight = guide.weight(neighbor, features);
                for (sum, plane) in sums.iter_mut().zip(color) {
                    *sum = *sum + weight * plane.at(neighbor);
                }
                sums[3] = sums[3] + weight;
            }
        }
        for (result, [red, green, blue, weights]) in results.iter_mut().zip(sums) {
            let factor = Float::splat(1.0) / weights;
            for (plane, sum) in result.iter_mut().zip([red, green, blue]) {
                plane.set(i, sum * factor);
            }
        }
    }
    results
}
