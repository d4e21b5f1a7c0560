//! The counter-based hash of [`crate::math::random`] over lanes, to the bit.

use super::{Float, Int};
use crate::math::random::{GOLDEN, MULTIPLIER_1, MULTIPLIER_2};

/// One [`PathKey`](crate::math::random::PathKey) a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathKeys {
    pub(crate) pixel_word: Int,
    pub(crate) sample_word: Int,
}

impl PathKeys {
    /// [`PixelKey::sample`](crate::math::random::PixelKey::sample) of a pixel's words and a
    /// sample a lane.
    #[inline(always)]
    pub(crate) fn new((first, second): (Int, Int), samples: Int) -> Self {
        Self {
            pixel_word: mix(first + samples * Int::splat(GOLDEN)),
            sample_word: mix(second ^ samples),
        }
    }

    /// 32 random bits a lane for one dimension of their paths.
    #[inline(always)]
    pub(crate) fn bits(&self, dimension: u32) -> Int {
        let x = self.pixel_word + Int::splat(dimension.wrapping_mul(GOLDEN));
        let x = ((x ^ x.shifted_down(16)) * Int::splat(MULTIPLIER_1)) ^ self.sample_word;
        let x = (x ^ x.shifted_down(15)) * Int::splat(MULTIPLIER_2);
        x ^ x.shifted_down(15)
    }

    /// Uniform numbers in `[0, 1)`, multiples of 2^-24.
    #[inline(always)]
    pub(crate) fn uniform(&self, dimension: u32) -> Float {
        unit_interval(self.bits(dimension))
    }
}

/// [`unit_interval`](crate::math::random::unit_interval): the upper 24 bits, in `[0, 1)`.
#[inline(always)]
pub(super) fn unit_interval(bits: Int) -> Float {
    // 24 bits are numbers of f32 and, with a sign, of i32.
    bits.shifted_down(8).to_float() * Float::splat(1.0 / 16_777_216.0)
}

#[inline(always)]
pub(super) fn mix(x: Int) -> Int {
    let x = (x ^ x.shifted_down(16)) * Int::splat(MULTIPLIER_1);
    let x = (x ^ x.shifted_down(15)) * Int::splat(MULTIPLIER_2);
    x ^ x.shifted_down(15)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::{PixelKey, Stream};
    use crate::simd::Lanes;

    #[test]
    fn lanes_are_the_scalar_hash() {
        let mut random = Stream::new(3);
        for _ in 0..20_000 {
            let seed = random.bits();
            let (x, y) = (random.bits() as u32 % 70_000, random.bits() as u32 % 70_000);
            let pixels: Lanes<PixelKey> =
                std::array::from_fn(|lane| PixelKey::new(seed, x + lane as u32 / 3, y));
            let samples: Lanes<u32> = std::array::from_fn(|_| random.bits() as u32);
            let dimension = random.bits() as u32 >> (random.bits() % 32);
            let words = pixels.map(PixelKey::words);
            let words = (Int::new(words.map(|w| w.0)), Int::new(words.map(|w| w.1)));
            let keys = PathKeys::new(words, Int::new(samples));
            let (bits, uniform) = (keys.bits(dimension), keys.uniform(dimension));
            for (lane, &sample) in samples.iter().enumerate() {
                let key = pixels[lane].sample(sample);
                assert_eq!(bits.to_array()[lane], key.bits(dimension));
                assert_eq!(uniform.to_array()[lane].to_bits(), key.uniform(dimension).to_bits());
            }
        }
    }
}
