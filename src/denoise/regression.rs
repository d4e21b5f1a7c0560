//! Linear regression: fits the colours around each pixel by a linear function of the features, whose value at the pixel
//! is the result. So textures and slopes stay, which a mean would blur.

use super::fireflies::Color;
use super::input::Input;
use super::planes::{MARGIN, Plane};
use super::weights::{Guide, HIGH, Strengths, TILE, TileWeights, WIDE, columns};
use crate::math::Real;
use crate::simd::Float;

/// Most features.
const FEATURES: usize = 7;
/// Unknowns: the factors of the features, and the value at the pixel, which is the last one.
const UNKNOWNS: usize = FEATURES + 1;
/// Coefficients of a symmetric matrix.
const MATRIX: usize = UNKNOWNS * (UNKNOWNS + 1) / 2;
/// Keeps factors small where the features hardly vary: a part of the sum of all weights, and of that of one pixel.
const RIDGE: [f32; 2] = [0.06, 0.3];
/// Differences of features are limited to this many times their scale.
const MOST: f32 = 3.0;

/// The place of row `row`, column `column` ≤ `row` of a symmetric matrix.
const fn at(row: usize, column: usize) -> usize {
    row * (row + 1) / 2 + column
}

/// The normal equations of one vector of pixels.
struct Equations {
    matrix: [Float; MATRIX],
    colors: [[Float; UNKNOWNS]; 3],
}

impl Equations {
    fn new() -> Self {
        let zero = Float::splat(0.0);
        Self { matrix: [zero; MATRIX], colors: [[zero; UNKNOWNS]; 3] }
    }

    /// Adds a neighbour whose features differ by `differences`. Its last number is 1, for the value at the pixel.
    #[inline(always)]
    fn add(&mut self, weight: Float, differences: &[Float; UNKNOWNS], color: [Float; 3]) {
        self.add_row::<0>(weight, differences, color);
        self.add_row::<1>(weight, differences, color);
        self.add_row::<2>(weight, differences, color);
        self.add_row::<3>(weight, differences, color);
        self.add_row::<4>(weight, differences, color);
        self.add_row::<5>(weight, differences, color);
        self.add_row::<6>(weight, differences, color);
        self.add_row::<7>(weight, differences, color);
    }

    /// Row by row, so that the compiler knows the length of each loop.
    #[inline(always)]
    fn add_row<const ROW: usize>(
        &mut self,
        weight: Float,
        differences: &[Float; UNKNOWNS],
        color: [Float; 3],
    ) {
        let weighted = weight * differences[ROW];
        for (column, &difference) in differences.iter().enumerate().take(ROW + 1) {
            let sum = &mut self.matrix[at(ROW, column)];
            *sum = *sum + weighted * difference;
        }
        for (sums, color) in self.colors.iter_mut().zip(color) {
            sums[ROW] = sums[ROW] + weighted * color;
        }
    }

    /// Solves the equations by a Cholesky decomposition, and returns the last unknown of each colour.
    #[inline(always)]
    fn solve(&mut self) -> [Float; 3] {
        let weights = self.matrix[at(FEATURES, FEATURES)];
        let ridge = weights * Float::splat(RIDGE[0]) + Float::splat(RIDGE[1]);
        let least = weights * Float::splat(1e-6);
        for j in 0..UNKNOWNS {
            let mut pivot = self.matrix[at(j, j)];
            if j < FEATURES {
                pivot = pivot + ridge;
            }
            for k in 0..j {
                pivot = pivot - self.matrix[at(j, k)] * self.matrix[at(j, k)];
            }
            let inverse = Float::splat(1.0) / pivot.max(least).sqrt();
            for i in j + 1..UNKNOWNS {
                let mut sum = self.matrix[at(i, j)];
                for k in 0..j {
                    sum = sum - self.matrix[at(i, k)] * self.matrix[at(j, k)];
                }
                self.matrix[at(i, j)] = sum * inverse;
            }
            // The inverse of the root is all that is needed of the diagonal.
            self.matrix[at(j, j)] = inverse;
        }
        let matrix = &self.matrix;
        self.colors.each_mut().map(|solved| {
            for i in 0..UNKNOWNS {
                for k in 0..i {
                    solved[i] = solved[i] - matrix[at(i, k)] * solved[k];
                }
                solved[i] = solved[i] * matrix[at(i, i)];
            }
            // The last row of the transposed triangle has one coefficient.
            (solved[FEATURES] * matrix[at(FEATURES, FEATURES)]).max(Float::splat(0.0))
        })
    }
}

/// Fits the input's colour with the weights of `guide`.
pub(super) fn fitted(input: &Input, guide: &Guide, strengths: &Strengths) -> Color {
    let (size, columns) = (input.size, columns(input.size));
    let neighbors: Vec<(isize, isize)> = strengths.neighbors().collect();
    // An image without some features has a constant in their place.
    let [none] = Plane::compute(size, |_| [Float::splat(0.0)]);
    let mut channels = [(&none, &none); FEATURES];
    let known = input.features.iter().flat_map(|f| f.channels.iter().map(|c| (c, &f.scale)));
    channels.iter_mut().zip(known).for_each(|(channel, known)| *channel = known);
    Plane::by_bands(size, HIGH, |y, band| {
        let mut tile = TileWeights::new(input, &columns);
        let mut weights = vec![[0.0; TILE]; neighbors.len()];
        tile.y = y;
        for x in (0..size.width).step_by(WIDE) {
            tile.x = x;
            for (&neighbor, weights) in neighbors.iter().zip(&mut weights) {
                tile.compare_features(neighbor, strengths);
                tile.weigh(neighbor, guide, weights);
            }
            for y in 0..tile.rows() {
                for column in tile.vectors() {
                    let at = y * WIDE + column;
                    let weights = weights.iter().map(|weights| Float::load(&weights[at..]));
                    let color = fit(
                        &input.color,
                        &channels,
                        tile.index(column, y),
                        neighbors.iter().zip(weights),
                    );
                    for (row, color) in band.iter_mut().zip(color) {
                        color.store(&mut row[y * size.stride() + MARGIN + x + column..]);
                    }
                }
            }
        }
    })
}

/// Fits the colours of one vector of pixels.
#[inline(always)]
fn fit<'a>(
    color: &Color,
    channels: &[(&Plane, &Plane); FEATURES],
    index: usize,
    neighbors: impl Iterator<Item = (&'a (isize, isize), Float)>,
) -> [Float; 3] {
    let here = channels.map(|(channel, scale)| (channel.at(index), scale.at(index).sqrt()));
    let mut equations = Equations::new();
    for (&(dx, dy), weight) in neighbors {
        let mut differences = [Float::splat(1.0); UNKNOWNS];
        for (k, (value, scale)) in here.into_iter().enumerate() {
            let scaled = (channels[k].0.near(index, dx, dy) - value) * scale;
            differences[k] = scaled.min(Float::splat(MOST)).max(Float::splat(-MOST));
        }
        let color = [0, 1, 2].map(|c: usize| color[c].near(index, dx, dy));
        equations.add(weight, &differences, color);
    }
    equations.solve()
}
