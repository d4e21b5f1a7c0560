//! Owen-scrambled Sobol' points by integer hashing, with random access to every point.
//!
//! Each dimension, or pair of dimensions, of a path has its own sequence (*padding*): the first two
//! dimensions of Sobol's sequence, with its points shuffled and both coordinates scrambled as
//! binary trees (Burley 2020, "Practical Hash-based Owen Scrambling"). Shuffling maps the first 2^k
//! points to one aligned run of the sequence. Any prefix is therefore as well distributed as its
//! length allows, and samples can be added later.
//!
//! Differences from the paper:
//! 1. The bits of the sample number are reversed once per path, in its key, instead of once per
//!    sequence.
//! 2. The eight bits that are zero in every reversed sample number are set from the pixel's key, so
//!    that each pixel starts at its own position of the sequence.
//! 3. The second coordinate's matrix has the entries (j choose i) modulo 2 (Pascal's triangle). It
//!    is applied in five steps (Ahmed 2024, "An Implementation Algorithm of 2D Sobol Sequence Fast,
//!    Elegant, and Compact"), one for each of the five bits of the indices i and j: (j choose i) is
//!    odd if and only if j has all bits of i (Lucas 1878).
//! 4. The tree hash is the later one by Vegdahl (2021, "Building a Better LK Hash").

use super::random::{GOLDEN, unit_interval};
use super::real::{Real, Word};
use super::{PathKey, PixelKey, mix32};

/// Bits that are zero in every reversed sample number, because sample numbers are below 2^24.
const SPARE: u32 = 0xFF;

impl<W: Word> PixelKey<W> {
    /// Key of sample number `sample`, below 2^24, for Sobol' points.
    #[inline(always)]
    pub(crate) fn sobol_sample(self, sample: W) -> PathKey<W> {
        let Self(pixel_word, other) = self;
        PathKey { pixel_word, sample_word: sample.reverse_bits() | other & W::splat(SPARE) }
    }
}

impl<W: Word> PathKey<W> {
    /// This path's point for `dimension` and the next one. Both coordinates are multiples of 2^-24
    /// in `[0, 1)`. For a single dimension, use the first alone.
    #[inline(always)]
    pub(crate) fn sobol<R: Real<Word = W>>(self, dimension: u32) -> (R, R) {
        let (x, y) = self.sobol_bits(dimension);
        (unit_interval(x), unit_interval(y))
    }

    /// The point of [`sobol`](Self::sobol), in units of 2^-32.
    #[inline(always)]
    pub(crate) fn sobol_bits(self, dimension: u32) -> (W, W) {
        let index = scrambled(self.sample_word, self.seed(dimension, 0)).reverse_bits();
        (
            scrambled(index, self.seed(dimension, 1)).reverse_bits(),
            scrambled(pascal(index), self.seed(dimension, 2)).reverse_bits(),
        )
    }

    #[inline(always)]
    fn seed(self, dimension: u32, use_of: u32) -> W {
        let offset = dimension.wrapping_mul(3).wrapping_add(use_of).wrapping_mul(GOLDEN);
        mix32(self.pixel_word.wrapping_add(W::splat(offset)))
    }
}

/// Owen scrambling of a tree whose first branch is the lowest bit. A hash of all lower bits decides
/// whether a bit is flipped.
#[inline(always)]
fn scrambled<W: Word>(x: W, seed: W) -> W {
    let x = x ^ x.wrapping_mul(W::splat(0x3D20_ADEA));
    let x = x.wrapping_add(seed);
    let x = x.wrapping_mul((seed >> 16) | W::splat(1));
    let x = x ^ x.wrapping_mul(W::splat(0x0552_6C56));
    x ^ x.wrapping_mul(W::splat(0x53A2_2864))
}

/// Steps of [`pascal`]: the shift, and a mask of the bits that change.
const PASCAL: [(u32, u32); 5] =
    [(16, 0x0000_FFFF), (8, 0x00FF_00FF), (4, 0x0F0F_0F0F), (2, 0x3333_3333), (1, 0x5555_5555)];

/// Bit i of the result is the sum over j of (j choose i) times bit j of `x`, modulo 2.
#[inline(always)]
fn pascal<W: Word>(mut x: W) -> W {
    for (down, places) in PASCAL {
        x = x ^ (x >> down) & W::splat(places);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::mix64;

    /// Number of points in each cell of a grid of 2^`bits` cells, 2^`across` of them along x.
    fn cells(points: &[(u32, u32)], bits: u32, across: u32) -> Vec<u32> {
        let mut cells = vec![0; 1 << bits];
        for &(x, y) in points {
            let row = y.unbounded_shr(32 - (bits - across));
            cells[(row << across | x.unbounded_shr(32 - across)) as usize] += 1;
        }
        cells
    }

    fn points(seed: u64, dimension: u32, samples: std::ops::Range<u32>) -> Vec<(u32, u32)> {
        let pixel = PixelKey::new(seed, 3, 4);
        samples.map(|sample| pixel.sobol_sample(sample).sobol_bits(dimension)).collect()
    }

    /// Each aligned run of 2^k samples has one point in every cell of every grid of 2^k cells.
    #[test]
    fn aligned_runs_are_nets() {
        for (seed, dimension) in [(1, 0), (1, 2), (2, 35), (3, 16_000)] {
            for bits in 0..=12 {
                for run in [0, 1, 2, 5] {
                    let points = points(seed, dimension, run << bits..(run + 1) << bits);
                    for across in 0..=bits {
                        let cells = cells(&points, bits, across);
                        assert!(
                            cells.iter().all(|&n| n == 1),
                            "{seed} {dimension} {bits} {across}"
                        );
                    }
                }
            }
        }
    }

    /// By definition, digit i of y is the sum of (j choose i) times digit j of x.
    #[test]
    fn pascal_is_the_triangle() {
        for bit in 0..32u64 {
            let mut choose = 1u64;
            let mut want = 0;
            for i in 0..=bit {
                want |= ((choose & 1) as u32) << i;
                choose = choose * (bit - i) / (i + 1);
            }
            assert_eq!(pascal(1 << bit), want, "column {bit}");
        }
    }

    /// Flipping a bit of the input flips the same bit of the output, and no lower bit. It flips
    /// each higher bit in about half of the trees.
    #[test]
    fn scrambling_is_by_trees() {
        let mut flips = [[0u32; 32]; 32];
        const TREES: u32 = 4096;
        for tree in 0..TREES {
            let (seed, x) = (mix32(tree), mix32(!tree));
            for (bit, flips) in flips.iter_mut().enumerate() {
                let changed = scrambled(x, seed) ^ scrambled(x ^ 1 << bit, seed);
                assert_eq!(changed & ((2u32 << bit).wrapping_sub(1)), 1 << bit);
                for (above, flips) in flips.iter_mut().enumerate() {
                    *flips += changed >> above & 1;
                }
            }
        }
        // Such a simple hash does not flip all bits with the same probability. A test below
        // compares the sequences that are used with those of ideal trees.
        for (bit, flips) in flips.iter().enumerate() {
            for (above, &flips) in flips.iter().enumerate().skip(bit + 1) {
                let share = f64::from(flips) / f64::from(TREES);
                assert!((share - 0.5).abs() < 0.2, "bit {bit} flips {above} in {share}");
            }
        }
    }

    /// Over many seeds, the points of one sample are uniform over the square.
    #[test]
    fn any_one_sample_is_uniform() {
        for sample in [0, 1, 6, 255, (1 << 24) - 1] {
            let one = |seed| points(seed, 7, sample..sample + 1)[0];
            let points: Vec<_> = (0..65_536).map(one).collect();
            let chi: f64 = cells(&points, 8, 4)
                .iter()
                .map(|&n| (f64::from(n) - 256.0) * (f64::from(n) - 256.0) / 256.0)
                .sum();
            // Six standard deviations of 255 degrees of freedom.
            assert!((chi - 255.0).abs() < 6.0 * 22.6, "{sample}: {chi}");
        }
    }

    /// Like [`scrambled`], but with a 64-bit hash for each branch.
    fn scrambled_well(x: u32, seed: u32) -> u32 {
        (0..32).fold(0, |y, bit| {
            let below = u64::from(x & ((1 << bit) - 1)) << 6 | bit;
            let flip = mix64(below ^ mix64(u64::from(seed))) as u32 & 1;
            y | (x >> bit & 1 ^ flip) << bit
        })
    }

    /// Chi-square of 64 points over a grid of 8 × 8 cells. One sequence gives their x, the other
    /// their y.
    fn common(a: impl Fn(u32) -> u32, b: impl Fn(u32) -> u32) -> f64 {
        let both: Vec<_> = (0..64).map(|sample| (a(sample), b(sample))).collect();
        let square = |n: u32| (f64::from(n) - 1.0) * (f64::from(n) - 1.0);
        cells(&both, 6, 3).into_iter().map(square).sum()
    }

    /// Two sequences correlate no more than the sequences of two ideal trees.
    #[test]
    fn sequences_are_independent_of_each_other() {
        const PIXELS: u32 = 2000;
        let mean_and_variance = |values: Vec<f64>| {
            let mean = values.iter().sum::<f64>() / f64::from(PIXELS);
            let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
            (mean, squares / f64::from(PIXELS))
        };
        let ideal = |pixel: u32| {
            let sequence = |which: u32| {
                move |sample: u32| {
                    let seed = 4 * pixel + 2 * which;
                    let index = scrambled_well(sample.reverse_bits(), seed).reverse_bits();
                    scrambled_well(index, seed + 1).reverse_bits()
                }
            };
            common(sequence(0), sequence(1))
        };
        let want = mean_and_variance((0..PIXELS).map(ideal).collect());
        // Dimensions of surfaces and of media, in the same segment and in different ones.
        for (a, b) in
            [(0, 2), (2, 4), (1, 17), (3, 19), (16, 32), (35, 36), (8, 9 << 21), (3, 8 + (1 << 21))]
        {
            for axes in 0..4 {
                let found = |pixel: u32| {
                    let coordinate = |dimension: u32, axis: u32| {
                        move |sample| {
                            let key = PixelKey::new(9, pixel, 0).sobol_sample(sample);
                            let (x, y) = key.sobol_bits(dimension);
                            if axis == 0 { x } else { y }
                        }
                    };
                    common(coordinate(a, axes & 1), coordinate(b, axes >> 1))
                };
                let found = mean_and_variance((0..PIXELS).map(found).collect());
                let error = ((found.1 + want.1) / f64::from(PIXELS)).sqrt();
                let off = (found.0 - want.0).abs();
                assert!(off < 5.0 * error, "{a} {b} {axes}: {found:?} {want:?}");
            }
        }
    }

    #[test]
    fn pixels_start_at_different_positions() {
        assert_eq!(SPARE & (crate::limits::MAX_SPP - 1).reverse_bits(), 0);
        // At 256 possible positions, 256 pixels are expected to occupy 162 different ones, give or
        // take 7.
        assert_eq!(SPARE.count_ones(), 8);
        let place = |x| PixelKey::new(1, x, 0).sobol_sample(5).sample_word & SPARE;
        let places: std::collections::HashSet<u32> = (0..256).map(place).collect();
        assert!((120..204).contains(&places.len()), "{}", places.len());
    }

    #[test]
    fn points_are_pinned() {
        // A change here changes every image: it needs a line in CHANGELOG.md.
        let point = PixelKey::new(1, 2, 3).sobol_sample(4).sobol_bits(2);
        assert_eq!(point, (4_138_508_740, 3_086_435_775));
    }
}
