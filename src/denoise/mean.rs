//! Weighted means of neighbours.

use super::fireflies::Color;
use super::input::Input;
use super::planes::{MARGIN, Plane};
use super::weights::{Guide, HIGH, Strengths, TILE, TileWeights, WIDE, columns};
use crate::simd::Float;

/// Filters each of `colors` with the weights of its guide, into three of the `PLANES` planes.
pub(super) fn means<const PLANES: usize>(
    input: &Input,
    pairs: &[(&Guide, &Color)],
    strengths: &Strengths,
) -> [Plane; PLANES] {
    let (size, columns) = (input.size, columns(input.size));
    let stride = size.stride();
    Plane::by_bands(size, HIGH, |y, band: &mut [&mut [f32]; PLANES]| {
        let mut tile = TileWeights::new(input, &columns);
        let mut weights = [0.0; TILE];
        let mut sums = vec![[[0.0; TILE]; 4]; pairs.len()];
        tile.y = y;
        for x in (0..size.width).step_by(WIDE) {
            tile.x = x;
            sums.as_flattened_mut().iter_mut().for_each(|sums| sums.fill(0.0));
            for (dx, dy) in strengths.neighbors() {
                tile.compare_features((dx, dy), strengths);
                for ((guide, color), sums) in pairs.iter().zip(&mut sums) {
                    tile.weigh((dx, dy), guide, &mut weights);
                    for y in 0..tile.rows() {
                        for x in tile.vectors() {
                            let (at, index) = (y * WIDE + x, tile.index(x, y));
                            let weight = Float::load(&weights[at..]);
                            let mut add = |sum: usize, value: Float| {
                                let sum = &mut sums[sum][at..];
                                (Float::load(sum) + value).store(sum);
                            };
                            add(3, weight);
                            for (c, plane) in color.iter().enumerate() {
                                add(c, weight * plane.near(index, dx, dy));
                            }
                        }
                    }
                }
            }
            for (plane, row) in band.iter_mut().enumerate() {
                let [sums, weights] = [plane % 3, 3].map(|sum| &sums[plane / 3][sum]);
                for y in 0..tile.rows() {
                    for column in tile.vectors() {
                        let sum = |sums: &[f32]| Float::load(&sums[y * WIDE + column..]);
                        let to = y * stride + MARGIN + x + column;
                        (sum(sums) / sum(weights)).store(&mut row[to..]);
                    }
                }
            }
        }
    })
}
