//! Linear regression: fits the colours around each pixel by a linear function of the features, whose value at the pixel
//! is the result. So textures and slopes stay, which a mean would blur.

use super::fireflies::Color;
use super::guide::Guide;
use super::input::{FEATURES, Features};
use super::neighbors::{Neighbors, largest};
use super::planes::Plane;
use crate::math::Real;
use crate::simd::Float;

/// Unknowns: the factors of the features, and the value at the pixel, which is the last one.
const UNKNOWNS: usize = FEATURES + 1;
/// Coefficients of a symmetric matrix.
const MATRIX: usize = UNKNOWNS * (UNKNOWNS + 1) / 2;
/// Keeps factors small where the features hardly vary: a part of the sum of all weights, and of that of one pixel.
const RIDGE: [f32; 2] = [5e-4, 2.5e-3];
/// Differences of features are limited to this.
const MOST: f32 = 0.27;

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

/// Fits `color` with the weights of `guide`. Leaves out the outermost `inset` pixels.
pub(super) fn fitted(
    features: &Features,
    guide: Guide,
    color: &Color,
    neighbors: &Neighbors,
    inset: usize,
) -> Color {
    let size = color[0].size();
    let offsets = neighbors.offsets(size);
    let mut result = color.each_ref().map(|plane| Plane::new(plane.size()));
    for i in size.inside(inset) {
        let here = neighbors.features(features, i);
        let guide = neighbors.guide(guide, i);
        let mut equations = Equations::new();
        for &offset in &offsets {
            let neighbor = i.wrapping_add_signed(offset);
            let differences = here.differences(neighbor);
            let weight = guide.weight(neighbor, largest(&differences));
            let limited = |x: Float| x.min(Float::splat(MOST)).max(Float::splat(-MOST));
            let [a, b, c, d, e, f, g] = differences.map(limited);
            let row = [a, b, c, d, e, f, g, Float::splat(1.0)];
            equations.add(weight, &row, color.each_ref().map(|plane| plane.at(neighbor)));
        }
        for (plane, value) in result.iter_mut().zip(equations.solve()) {
            plane.set(i, value);
        }
    }
    result
}
