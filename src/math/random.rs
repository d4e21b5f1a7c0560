//! Counter-based random numbers: hashes of seed, pixel, sample and dimension.
//!
//! Unlike the values of a stream, they do not depend on the order of execution.

use super::real::{Real, Word};

/// Key of all random numbers of one sample of one pixel, or of one such sample per lane.
///
/// It has two words, so that the probability that two different paths share all their numbers is
/// only 2^-64.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PathKey<W = u32> {
    pub(crate) pixel_word: W,
    pub(crate) sample_word: W,
}

/// Key of a pixel, from which the keys of its samples are derived.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PixelKey<W = u32>(pub(crate) W, pub(crate) W);

impl PixelKey {
    /// Key of the pixel at `x` and `y` in the full image, so that crops and tiles agree.
    #[inline]
    pub(crate) fn new(seed: u64, x: u32, y: u32) -> Self {
        let word = mix64(seed ^ mix64(u64::from(y) << 32 | u64::from(x)));
        Self(word as u32, (word >> 32) as u32)
    }
}

impl<W: Word> PixelKey<W> {
    /// Key of sample number `sample` of this pixel.
    #[inline(always)]
    pub(crate) fn sample(self, sample: W) -> PathKey<W> {
        PathKey {
            pixel_word: mix32(self.0.wrapping_add(sample.wrapping_mul(W::splat(GOLDEN)))),
            sample_word: mix32(self.1 ^ sample),
        }
    }
}

impl<W: Word> PathKey<W> {
    /// 32 random bits for dimension `dimension` of this path.
    #[inline(always)]
    pub(crate) fn bits(self, dimension: u32) -> W {
        // This is `mix32`, with the second word of the key mixed in between its two rounds.
        let x = self.pixel_word.wrapping_add(W::splat(dimension.wrapping_mul(GOLDEN)));
        let x = (x ^ (x >> 16)).wrapping_mul(W::splat(MULTIPLIER_1)) ^ self.sample_word;
        let x = (x ^ (x >> 15)).wrapping_mul(W::splat(MULTIPLIER_2));
        x ^ (x >> 15)
    }

    /// The key of the same path beyond pane number `number`, from 1, of a segment.
    #[inline(always)]
    pub(crate) fn beyond(self, number: u32) -> Self {
        let number = W::splat(number.wrapping_mul(GOLDEN));
        Self { pixel_word: mix32(self.pixel_word.wrapping_add(number)), ..self }
    }

    /// Uniform number in `[0, 1)`, a multiple of 2^-24.
    #[inline(always)]
    pub(crate) fn uniform<R: Real<Word = W>>(self, dimension: u32) -> R {
        unit_interval(self.bits(dimension))
    }
}

/// The upper 24 bits as a number in `[0, 1)`.
#[inline(always)]
pub(crate) fn unit_interval<R: Real>(bits: R::Word) -> R {
    R::from_word(bits >> 8) * (1.0 / 16_777_216.0)
}

/// 2^32 divided by the golden ratio. Its consecutive multiples are spread evenly.
pub(super) const GOLDEN: u32 = 0x9E37_79B9;
const MULTIPLIER_1: u32 = 0x21F0_AAAD;
const MULTIPLIER_2: u32 = 0x735A_2D97;

/// Low-bias bijection of 32-bit words. Its shifts and multipliers were found by a search for the
/// least avalanche bias (Wellons 2018, "Prospecting for Hash Functions").
#[inline(always)]
pub(crate) fn mix32<W: Word>(x: W) -> W {
    let x = (x ^ (x >> 16)).wrapping_mul(W::splat(MULTIPLIER_1));
    let x = (x ^ (x >> 15)).wrapping_mul(W::splat(MULTIPLIER_2));
    x ^ (x >> 15)
}

/// Finaliser of SplitMix64 (Steele, Lea, Flood 2014), after one step of its counter.
#[inline]
pub(super) fn mix64(x: u64) -> u64 {
    let mut x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}

/// SplitMix64 as a stream, for values generated in a fixed order: test rays and generated scenes.
#[derive(Clone, Debug)]
pub struct Stream(u64);

impl Stream {
    /// A stream that starts at `seed`.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        let value = mix64(self.0);
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        value
    }

    /// The next number in `[0, 1)`, a multiple of 2^-24.
    pub fn uniform(&mut self) -> f32 {
        (self.bits() >> 40) as f32 * (1.0 / 16_777_216.0)
    }

    /// The next number in `[lo, hi)`.
    pub fn between(&mut self, lo: f32, hi: f32) -> f32 {
        lo + (hi - lo) * self.uniform()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chi-square of `n` points over a 16 × 16 grid: mean 255, standard deviation 22.6.
    fn chi_square(points: impl Iterator<Item = (f32, f32)>) -> f64 {
        let mut cells = [0u32; 256];
        let mut n = 0u32;
        for (u, v) in points {
            cells[(u * 16.0) as usize * 16 + (v * 16.0) as usize] += 1;
            n += 1;
        }
        let expected = f64::from(n) / 256.0;
        cells.iter().map(|&c| (f64::from(c) - expected) * (f64::from(c) - expected)).sum::<f64>()
            / expected
    }

    /// The mean plus six standard deviations. Each of the few hundred tests below exceeds it by
    /// chance with a probability of about 1e-7.
    const LIMIT: f64 = 255.0 + 6.0 * 22.6;

    #[test]
    fn pairs_of_dimensions_are_independent_over_samples() {
        let pixel = PixelKey::new(1, 17, 4);
        for a in 0..24 {
            for b in 0..a {
                let chi = chi_square((0..65_536).map(|s| {
                    let key = pixel.sample(s);
                    (key.uniform(a), key.uniform(b))
                }));
                assert!(chi < LIMIT, "dimensions {a} and {b}: {chi}");
            }
        }
    }

    #[test]
    fn neighbours_in_every_counter_are_independent() {
        let value = |seed, x, y, sample, dimension| {
            PixelKey::new(seed, x, y).sample(sample).uniform(dimension)
        };
        type Point = fn(&dyn Fn(u64, u32, u32, u32, u32) -> f32, u32) -> (f32, f32);
        let neighbours: [(&str, Point); 5] = [
            ("seed", |f, i| (f(u64::from(i), 3, 4, 5, 6), f(u64::from(i) + 1, 3, 4, 5, 6))),
            ("x", |f, i| (f(1, i, 4, 5, 6), f(1, i + 1, 4, 5, 6))),
            ("y", |f, i| (f(1, 3, i, 5, 6), f(1, 3, i + 1, 5, 6))),
            ("sample", |f, i| (f(1, 3, 4, i, 6), f(1, 3, 4, i + 1, 6))),
            ("dimension", |f, i| (f(1, 3, 4, 5, i), f(1, 3, 4, 5, i + 1))),
        ];
        for (name, point) in neighbours {
            let chi = chi_square((0..65_536).map(|i| point(&value, i)));
            assert!(chi < LIMIT, "{name}: {chi}");
        }
    }

    #[test]
    fn stream_is_splitmix64() {
        // First outputs of the reference generator for seed 1234567.
        let mut stream = Stream::new(1_234_567);
        assert_eq!(stream.bits(), 6_457_827_717_110_365_317);
        assert_eq!(stream.bits(), 3_203_168_211_198_807_973);
    }

    #[test]
    fn keys_are_pinned() {
        // A change here changes every image: it needs a line in CHANGELOG.md.
        let key = PixelKey::new(1, 2, 3).sample(4);
        assert_eq!([key.bits(0), key.bits(1)], [1_854_067_448, 182_575_234]);
    }
}
