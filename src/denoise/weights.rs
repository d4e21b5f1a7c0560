//! Weights of neighbours: how likely it is that two pixels show the same light on the same surface.

use super::fireflies::Color;
use super::input::{Feature, Input};
use super::planes::{Plane, Size};
use crate::math::Real;
use crate::simd::{Float, LANES};

/// Width and height of a tile, whose weights for a neighbour are computed together.
pub(super) const WIDE: usize = 32;
pub(super) const HIGH: usize = 16;
/// Pixels of a tile.
pub(super) const TILE: usize = WIDE * HIGH;
/// Width of the distances of a tile: each weight needs those of its neighbours.
const ACROSS: usize = WIDE + LANES;

/// How much pixels may differ.
#[derive(Clone, Copy)]
pub(super) struct Strengths {
    /// The distances of neighbours in x and in y.
    pub(super) steps: &'static [isize],
    /// Differences of features count in relation to this many times their scale.
    pub(super) feature: f32,
}

impl Strengths {
    /// The places of all neighbours, and of the pixel itself.
    pub(super) fn neighbors(&self) -> impl Iterator<Item = (isize, isize)> + use<> {
        let steps: &'static [isize] = self.steps;
        steps.iter().flat_map(move |&dy| steps.iter().map(move |&dx| (dx, dy)))
    }
}

/// Colours that decide weights.
pub(super) struct Guide {
    color: Color,
    /// The variance of the three channels together.
    variance: Plane,
    /// One by the square of what counts as a difference.
    scale: Plane,
}

impl Guide {
    /// Differences count in relation to `deviations` standard deviations of both pixels.
    pub(super) fn new(color: Color, variance: Plane, deviations: f32) -> Self {
        let factor = Float::splat(2.0 * deviations * deviations);
        let [scale] = Plane::compute(variance.size(), |i| {
            [Float::splat(1.0) / (variance.at(i) * factor + Float::splat(1e-7))]
        });
        Self { color, variance, scale }
    }
}

/// Computes the weights of one tile.
pub(super) struct TileWeights<'a> {
    features: &'a [Feature],
    size: Size,
    /// 1 in the columns of the image, 0 in the margin.
    columns: &'a [f32],
    /// The first pixel.
    pub(super) x: usize,
    pub(super) y: usize,
    of_features: Box<[f32; TILE]>,
    of_colors: Box<[f32; ACROSS * (HIGH + 2)]>,
}

/// 1 where a plane has pixels of the image, for [`TileWeights`].
pub(super) fn columns(size: Size) -> Vec<f32> {
    let first = size.index(0, 0) % size.stride();
    (0..size.stride()).map(|x| f32::from((first..first + size.width).contains(&x))).collect()
}

impl<'a> TileWeights<'a> {
    pub(super) fn new(input: &'a Input, columns: &'a [f32]) -> Self {
        let (of_features, of_colors) =
            (Box::new([0.0; TILE]), Box::new([0.0; ACROSS * (HIGH + 2)]));
        let Input { features, size, .. } = input;
        Self { features, size: *size, columns, x: 0, y: 0, of_features, of_colors }
    }

    /// The number of rows of the tile inside the image.
    pub(super) fn rows(&self) -> usize {
        HIGH.min(self.size.height - self.y)
    }

    /// The first pixels of the tile's vectors in a row.
    pub(super) fn vectors(&self) -> impl Iterator<Item = usize> + use<> {
        (0..WIDE.min(self.size.width - self.x)).step_by(LANES)
    }

    /// Where pixel (x, y) of the tile is in a plane.
    pub(super) fn index(&self, x: usize, y: usize) -> usize {
        self.size.index(self.x + x, self.y + y)
    }

    /// Compares the features of each pixel with those of its neighbour at (`dx`, `dy`).
    pub(super) fn compare_features(&mut self, (dx, dy): (isize, isize), strengths: &Strengths) {
        let factor = Float::splat(1.0 / (strengths.feature * strengths.feature));
        for y in 0..self.rows() {
            for x in self.vectors() {
                let index = self.index(x, y);
                let mut most = Float::splat(0.0);
                for feature in self.features {
                    most = most.max(feature.difference(index, dx, dy));
                }
                (most * factor).store(&mut self.of_features[y * WIDE + x..]);
            }
        }
    }

    /// Whether the neighbours at distance `dy` of row `y` lie in the image.
    fn row_exists(&self, y: usize, dy: isize) -> bool {
        (self.y + y).checked_add_signed(dy).is_some_and(|row| row < self.size.height)
    }

    /// The weights of the neighbours at (`dx`, `dy`) by the colours of `guide`. Their features must have been
    /// compared before.
    ///
    /// The distance of two colours is the mean over a patch of 3 × 3 pixels, less the distance that noise alone makes.
    pub(super) fn weigh(
        &mut self,
        (dx, dy): (isize, isize),
        guide: &Guide,
        weights: &mut [f32; TILE],
    ) {
        let Guide { color: [r, g, b], variance, scale } = guide;
        for y in 0..self.rows() + 2 {
            for x in (0..ACROSS).step_by(LANES).take(self.vectors().count() + 1) {
                let index = self.index(x, y) - 1 - self.size.stride();
                let square = |plane: &Plane| {
                    let difference = plane.at(index) - plane.near(index, dx, dy);
                    difference * difference
                };
                let here = variance.at(index);
                let noise = here + here.min(variance.near(index, dx, dy));
                let distance = square(r) + square(g) + square(b) - noise;
                let scale = scale.at(index).min(scale.near(index, dx, dy));
                (distance * scale).store(&mut self.of_colors[y * ACROSS + x..]);
            }
        }
        for y in 0..self.rows() {
            let exists = self.row_exists(y, dy);
            for x in self.vectors() {
                let patch = |row: usize| {
                    let first = (y + row) * ACROSS + x;
                    let [left, mid, right] =
                        [0, 1, 2].map(|k| Float::load(&self.of_colors[first + k..]));
                    left + mid + right
                };
                let distance = (patch(0) + patch(1) + patch(2)) * Float::splat(1.0 / 9.0);
                let features = Float::load(&self.of_features[y * WIDE + x..]);
                let distance = distance.max(features).max(Float::splat(0.0));
                // Close to the exponential function, and 0 from 8 on.
                let root =
                    (Float::splat(1.0) - distance * Float::splat(0.125)).max(Float::splat(0.0));
                let square = root * root;
                let fourth = square * square;
                let column = (self.index(x, y) % self.size.stride()).wrapping_add_signed(dx);
                let inside = Float::load(&self.columns[column..]);
                let weight = fourth * fourth * inside;
                let weight = if exists { weight } else { Float::splat(0.0) };
                weight.store(&mut weights[y * WIDE + x..]);
            }
        }
    }
}
