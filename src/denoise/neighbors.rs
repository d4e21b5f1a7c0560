//! Weights of neighbours: how likely it is that two pixels show the same light on the same surface.

use super::guide::{Guide, NUMBERS};
use super::input::{FEATURES, Features};
use super::planes::{Plane, Size};
use crate::math::Real;
use crate::simd::Float;

/// Which neighbours count, and how much they may differ.
#[derive(Clone, Copy)]
pub(super) struct Neighbors {
    /// Distances in x and in y.
    pub(super) steps: &'static [isize],
    /// The square of the largest distance.
    pub(super) within: isize,
    /// Differences of features count in relation to this many times their scale.
    pub(super) feature: f32,
    /// Differences of guides count in relation to this many standard deviations.
    pub(super) deviations: f32,
}

/// Distances count in relation to 8 times what they may be, where weights end.
const END: f32 = 8.0;

impl Neighbors {
    /// How far the indices of neighbours are from that of a pixel.
    pub(super) fn offsets(&self, size: Size) -> Vec<isize> {
        let places = self.steps.iter().flat_map(|&y| self.steps.iter().map(move |&x| (x, y)));
        let near = places.filter(|(x, y)| x * x + y * y <= self.within);
        near.map(|(x, y)| y * size.stride() as isize + x).collect()
    }

    /// The largest distance in x and in y.
    pub(super) const fn reach(&self) -> usize {
        self.steps[self.steps.len() - 1].unsigned_abs()
    }

    /// The factors by which differences of features count.
    #[inline(always)]
    pub(super) fn features<'a>(&self, features: &'a Features, i: usize) -> FeaturesHere<'a> {
        let factor = Float::splat(1.0 / (self.feature * END.sqrt()));
        FeaturesHere {
            channels: slices(&features.channels),
            here: features.channels.each_ref().map(|channel| channel.at(i)),
            factors: features.roots.each_ref().map(|root| root.at(i) * factor),
        }
    }

    /// The guide's numbers at `i`.
    #[inline(always)]
    pub(super) fn guide<'a>(&self, guide: Guide<'a>, i: usize) -> GuideHere<'a> {
        let noise = guide.noise.at(i);
        let square = Float::splat(2.0 * END * self.deviations * self.deviations);
        GuideHere {
            planes: slices(guide.planes),
            here: guide.planes.each_ref().map(|plane| plane.at(i)),
            noise: noise + noise,
            scale: Float::splat(1.0) / (noise * square + Float::splat(1e-7)),
        }
    }
}

/// The features of one vector of pixels.
pub(super) struct FeaturesHere<'a> {
    channels: [&'a [f32]; FEATURES],
    here: [Float; FEATURES],
    factors: [Float; 3],
}

impl FeaturesHere<'_> {
    /// The differences of a neighbour. Weights end where those of one feature have the length 1.
    #[inline(always)]
    pub(super) fn differences(&self, neighbor: usize) -> [Float; FEATURES] {
        let mut differences = self.here;
        for (c, difference) in differences.iter_mut().enumerate() {
            *difference =
                (Float::load(&self.channels[c][neighbor..]) - *difference) * self.factors[c / 3];
        }
        differences
    }
}

/// The guide's numbers of one vector of pixels.
pub(super) struct GuideHere<'a> {
    planes: [&'a [f32]; NUMBERS],
    here: [Float; NUMBERS],
    /// What noise alone makes of squared differences.
    noise: Float,
    scale: Float,
}

impl GuideHere<'_> {
    /// The squared difference of a neighbour. Weights end at 1.
    #[inline(always)]
    fn distance(&self, neighbor: usize) -> Float {
        let squares = [0, 1, 2, 3, 4, 5].map(|k: usize| {
            let difference = Float::load(&self.planes[k][neighbor..]) - self.here[k];
            difference * difference
        });
        let [a, b, c, d, e, f] = squares;
        ((a + b) + (c + d) + (e + f) - self.noise) * self.scale
    }

    /// The weight of a neighbour whose features have this squared difference.
    #[inline(always)]
    pub(super) fn weight(&self, neighbor: usize, features: Float) -> Float {
        let distance = self.distance(neighbor).max(features);
        // Close to the exponential function.
        let root = (Float::splat(1.0) - distance).max(Float::splat(0.0));
        let square = root * root;
        let fourth = square * square;
        fourth * fourth
    }
}

/// The numbers of all planes.
#[inline(always)]
pub(super) fn slices<const N: usize>(planes: &[Plane; N]) -> [&[f32]; N] {
    let count = planes[0].size().count();
    planes.each_ref().map(|plane| plane.numbers(count))
}

/// The largest squared difference of albedo, normal and depth.
#[inline(always)]
pub(super) fn largest(differences: &[Float; FEATURES]) -> Float {
    let [a, b, c, d, e, f, g] = differences.map(|difference| difference * difference);
    (a + b + c).max(d + e + f).max(g)
}
