//! Names of the random numbers of a path, so that none is used twice.

use super::settings::Sampler;
use crate::math::random::{PathKey, PixelKey};
use crate::simd::random::PathKeys;
use crate::simd::{Float, Int};

/// The random numbers of one block: block 0 is the camera's, block k ≥ 1 that of the vertex
/// at the end of the path's k-th segment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Randoms<K = PathKey> {
    sampler: Sampler,
    key: K,
    first: u32,
}

/// The key of a path, or of a path a lane: numbers in `[0, 1)` by a sampler and a dimension.
pub(crate) trait Key {
    /// A number, or one a lane.
    type Number;
    /// 32 bits, or as many a lane.
    type Bits;

    /// 32 bits.
    fn bits(&self, sampler: Sampler, dimension: u32) -> Self::Bits;

    /// One number.
    fn one(&self, sampler: Sampler, dimension: u32) -> Self::Number;

    /// Two numbers that belong together, for `dimension` and the next.
    fn two(&self, sampler: Sampler, dimension: u32) -> (Self::Number, Self::Number);
}

impl Key for PathKey {
    type Number = f32;
    type Bits = u32;

    #[inline]
    fn bits(&self, sampler: Sampler, dimension: u32) -> u32 {
        match sampler {
            Sampler::Independent => Self::bits(*self, dimension),
            Sampler::Sobol => self.sobol_bits(dimension).0,
        }
    }

    #[inline]
    fn one(&self, sampler: Sampler, dimension: u32) -> f32 {
        match sampler {
            Sampler::Independent => self.uniform(dimension),
            Sampler::Sobol => self.sobol(dimension).0,
        }
    }

    #[inline]
    fn two(&self, sampler: Sampler, dimension: u32) -> (f32, f32) {
        match sampler {
            Sampler::Independent => (self.uniform(dimension), self.uniform(dimension + 1)),
            Sampler::Sobol => self.sobol(dimension),
        }
    }
}

impl Key for PathKeys {
    type Number = Float;
    type Bits = Int;

    #[inline(always)]
    fn bits(&self, sampler: Sampler, dimension: u32) -> Int {
        match sampler {
            Sampler::Independent => Self::bits(self, dimension),
            Sampler::Sobol => self.sobol_bits(dimension),
        }
    }

    #[inline(always)]
    fn one(&self, sampler: Sampler, dimension: u32) -> Float {
        match sampler {
            Sampler::Independent => self.uniform(dimension),
            Sampler::Sobol => self.sobol_number(dimension),
        }
    }

    #[inline(always)]
    fn two(&self, sampler: Sampler, dimension: u32) -> (Float, Float) {
        match sampler {
            Sampler::Independent => (self.uniform(dimension), self.uniform(dimension + 1)),
            Sampler::Sobol => self.sobol_point(dimension),
        }
    }
}

impl Sampler {
    /// The key of sample `sample` of a pixel.
    #[inline]
    pub(super) fn path(self, pixel: PixelKey, sample: u32) -> PathKey {
        match self {
            Self::Independent => pixel.sample(sample),
            Self::Sobol => pixel.sobol_sample(sample),
        }
    }

    /// The keys of samples of pixels, whose words are `pixel`.
    #[inline(always)]
    pub(super) fn paths(self, pixel: (Int, Int), samples: Int) -> PathKeys {
        match self {
            Self::Independent => PathKeys::new(pixel, samples),
            Self::Sobol => PathKeys::sobol(pixel, samples),
        }
    }
}

/// Dimensions of a block.
const BLOCK: u32 = 16;

/// What a random number decides; the camera's and a vertex's share the places of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Dimension(u32);

impl Dimension {
    /// Camera: position in the pixel (2).
    pub(crate) const PIXEL: Self = Self(0);
    /// Camera: position on the lens (2).
    pub(crate) const LENS: Self = Self(2);
    /// Camera: moment of the shutter.
    pub(crate) const TIME: Self = Self(4);

    /// Vertex: which light.
    pub(crate) const LIGHT_CHOICE: Self = Self(0);
    /// Vertex: direction to the light (2).
    pub(crate) const LIGHT: Self = Self(1);
    /// Vertex: scattered direction (2).
    pub(crate) const SCATTER: Self = Self(3);
    /// Vertex: reflection or refraction.
    pub(crate) const LOBE: Self = Self(5);
    /// Vertex: distance of a point in the unit ball.
    pub(crate) const BALL: Self = Self(6);
    /// Vertex: whether the path goes on.
    pub(crate) const ROULETTE: Self = Self(7);

    /// Vertex: how far the path gets in medium number `index`.
    pub(crate) const fn medium(index: u32) -> Self {
        // Beyond all blocks of a path for all but the first.
        Self(8 + (index << 21))
    }
}

impl<K: Key> Randoms<K> {
    /// The numbers that `sampler` has for block `block` of the path `key`.
    #[inline(always)]
    pub(crate) fn new(sampler: Sampler, key: K, block: u32) -> Self {
        Self { sampler, key, first: block * BLOCK }
    }

    /// 32 random bits.
    #[inline(always)]
    pub(crate) fn bits(&self, Dimension(dimension): Dimension) -> K::Bits {
        self.key.bits(self.sampler, self.first + dimension)
    }

    /// One number in `[0, 1)`.
    #[inline(always)]
    pub(crate) fn one(&self, Dimension(dimension): Dimension) -> K::Number {
        self.key.one(self.sampler, self.first + dimension)
    }

    /// Two numbers in `[0, 1)`.
    #[inline(always)]
    pub(crate) fn two(&self, Dimension(dimension): Dimension) -> (K::Number, K::Number) {
        self.key.two(self.sampler, self.first + dimension)
    }
}
