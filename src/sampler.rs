//! The random numbers of a path, named by their purpose.

use serde::{Deserialize, Serialize};

use crate::math::{PathKey, PixelKey, Real, Word};

/// Source of the random numbers of paths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sampler {
    /// A hash: every number is independent of every other.
    Independent,
    /// Owen-scrambled Sobol' points: the samples of a pixel fill each pair of dimensions evenly.
    #[default]
    Sobol,
}

names! { pub Sampler: Independent = "independent", Sobol = "sobol" }

impl Sampler {
    /// The key of sample `sample` of a pixel.
    #[inline(always)]
    pub(crate) fn path<W: Word>(self, pixel: PixelKey<W>, sample: W) -> PathKey<W> {
        match self {
            Self::Independent => pixel.sample(sample),
            Self::Sobol => pixel.sobol_sample(sample),
        }
    }
}

/// The random numbers of one block of a path, or of one path per lane. Block 0 belongs to the
/// camera, and block k ≥ 1 to the vertex at the end of the path's k-th segment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Randoms<R: Real = f32> {
    sampler: Sampler,
    key: PathKey<R::Word>,
    first: u32,
}

/// Number of dimensions of a block.
const BLOCK: u32 = 16;

/// The purpose of a random number, given by its position in a block. The camera and vertices use
/// the same positions, but in different blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Dimension(u32);

impl Dimension {
    /// Camera: position in the pixel (2 numbers).
    pub(crate) const PIXEL: Self = Self(0);
    /// Camera: position on the lens (2 numbers).
    pub(crate) const LENS: Self = Self(2);
    /// Camera: time within the shutter interval.
    pub(crate) const TIME: Self = Self(4);

    /// Vertex: choice of a light.
    pub(crate) const LIGHT_CHOICE: Self = Self(0);
    /// Vertex: direction to the light (2 numbers).
    pub(crate) const LIGHT: Self = Self(1);
    /// Vertex: scattered direction (2 numbers).
    pub(crate) const SCATTER: Self = Self(3);
    /// Vertex: choice of reflection or refraction.
    pub(crate) const LOBE: Self = Self(5);
    /// Vertex: distance of a point in the unit ball from the centre of the ball.
    pub(crate) const BALL: Self = Self(6);
    /// Vertex: Russian roulette, which decides whether the path continues.
    pub(crate) const ROULETTE: Self = Self(7);

    /// Pane: whether the path passes.
    pub(crate) const PANE: Self = Self(9);

    /// Vertex: distance that the path travels in medium number `index`.
    pub(crate) const fn medium(index: u32) -> Self {
        // The dimensions of all media except the first are beyond all blocks of a path.
        Self(8 + (index << 21))
    }
}

impl<R: Real> Randoms<R> {
    /// The random numbers of block `block` of the path `key`.
    #[inline(always)]
    pub(crate) fn new(sampler: Sampler, key: PathKey<R::Word>, block: u32) -> Self {
        Self { sampler, key, first: block * BLOCK }
    }

    /// 32 random bits.
    #[inline(always)]
    pub(crate) fn bits(&self, Dimension(dimension): Dimension) -> R::Word {
        let dimension = self.first + dimension;
        match self.sampler {
            Sampler::Independent => self.key.bits(dimension),
            Sampler::Sobol => self.key.sobol_bits(dimension).0,
        }
    }

    /// One number in `[0, 1)`.
    #[inline(always)]
    pub(crate) fn one(&self, Dimension(dimension): Dimension) -> R {
        let dimension = self.first + dimension;
        match self.sampler {
            Sampler::Independent => self.key.uniform(dimension),
            Sampler::Sobol => self.key.sobol(dimension).0,
        }
    }

    /// Two numbers in `[0, 1)` for one two-dimensional decision.
    #[inline(always)]
    pub(crate) fn two(&self, Dimension(dimension): Dimension) -> (R, R) {
        let dimension = self.first + dimension;
        match self.sampler {
            Sampler::Independent => (self.key.uniform(dimension), self.key.uniform(dimension + 1)),
            Sampler::Sobol => self.key.sobol(dimension),
        }
    }
}
