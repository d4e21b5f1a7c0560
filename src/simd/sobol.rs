//! Owen-scrambled Sobol' points over lanes: [`crate::math::sobol`] to the bit.

use super::random::{PathKeys, mix, unit_interval};
use super::{Float, Int};
use crate::math::random::GOLDEN;
use crate::math::sobol::{PASCAL, SCRAMBLE, SPARE};

impl PathKeys {
    /// [`PixelKey::sobol_sample`](crate::math::random::PixelKey::sobol_sample) of a pixel's words and
    /// a sample a lane.
    #[inline(always)]
    pub(crate) fn sobol((pixel_word, other): (Int, Int), samples: Int) -> Self {
        Self { pixel_word, sample_word: samples.reversed() | other & Int::splat(SPARE) }
    }

    /// [`PathKey::sobol`](crate::math::random::PathKey::sobol): a point a lane, numbers in `[0, 1)`.
    #[inline(always)]
    pub(crate) fn sobol_point(&self, dimension: u32) -> (Float, Float) {
        let index = self.shuffled_index(dimension);
        let y = scrambled(pascal(index), self.seed(dimension, 2)).reversed();
        (unit_interval(self.first_coordinate(index, dimension)), unit_interval(y))
    }

    /// The first coordinate of [`Self::sobol_point`].
    #[inline(always)]
    pub(crate) fn sobol_number(&self, dimension: u32) -> Float {
        unit_interval(self.sobol_bits(dimension))
    }

    /// The same in units of 2^-32.
    #[inline(always)]
    pub(crate) fn sobol_bits(&self, dimension: u32) -> Int {
        self.first_coordinate(self.shuffled_index(dimension), dimension)
    }

    #[inline(always)]
    fn shuffled_index(&self, dimension: u32) -> Int {
        scrambled(self.sample_word, self.seed(dimension, 0)).reversed()
    }

    #[inline(always)]
    fn first_coordinate(&self, index: Int, dimension: u32) -> Int {
        scrambled(index, self.seed(dimension, 1)).reversed()
    }

    #[inline(always)]
    fn seed(&self, dimension: u32, use_of: u32) -> Int {
        mix(self.pixel_word
            + Int::splat(dimension.wrapping_mul(3).wrapping_add(use_of).wrapping_mul(GOLDEN)))
    }
}

#[inline(always)]
fn scrambled(x: Int, seed: Int) -> Int {
    let [a, b, c] = SCRAMBLE.map(Int::splat);
    let x = (x ^ (x * a)) + seed;
    let x = x * (seed.shifted_down(16) | Int::splat(1));
    let x = x ^ (x * b);
    x ^ (x * c)
}

#[inline(always)]
fn pascal(mut x: Int) -> Int {
    for (down, places) in PASCAL {
        x = x ^ x.shifted_down(down) & Int::splat(places);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::{PixelKey, Stream};
    use crate::simd::Lanes;

    #[test]
    fn lanes_are_the_scalar_points() {
        let mut random = Stream::new(5);
        for _ in 0..20_000 {
            let seed = random.bits();
            let x = random.bits() as u32 % 70_000;
            let pixels: Lanes<PixelKey> =
                std::array::from_fn(|lane| PixelKey::new(seed, x + lane as u32 / 3, 9));
            let samples: Lanes<u32> =
                std::array::from_fn(|_| random.bits() as u32 >> (8 + random.bits() % 24));
            let dimension = random.bits() as u32 >> (12 + random.bits() % 20);
            let words = pixels.map(PixelKey::words);
            let words = (Int::new(words.map(|w| w.0)), Int::new(words.map(|w| w.1)));
            let keys = PathKeys::sobol(words, Int::new(samples));
            let (x, y) = keys.sobol_point(dimension);
            let one = keys.sobol_number(dimension).to_array();
            let (x, y) = (x.to_array(), y.to_array());
            for (lane, &sample) in samples.iter().enumerate() {
                let (u, v) = pixels[lane].sobol_sample(sample).sobol(dimension);
                assert_eq!(
                    [x[lane], y[lane], one[lane]].map(f32::to_bits),
                    [u, v, u].map(f32::to_bits)
                );
            }
        }
    }
}
