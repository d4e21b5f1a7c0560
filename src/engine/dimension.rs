//! Names of the random numbers of a path, so that none is used twice.

use crate::math::random::PathKey;
use crate::simd::Float;
use crate::simd::random::PathKeys;

/// The random numbers of one block: block 0 is the camera's, block k ≥ 1 that of the vertex
/// at the end of the path's k-th segment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Randoms<K = PathKey> {
    key: K,
    first: u32,
}

/// The key of a path, or of a path a lane.
pub(crate) trait Key {
    /// A number, or one a lane.
    type Number;

    /// In `[0, 1)`.
    fn uniform(&self, dimension: u32) -> Self::Number;
}

impl Key for PathKey {
    type Number = f32;

    #[inline]
    fn uniform(&self, dimension: u32) -> f32 {
        Self::uniform(*self, dimension)
    }
}

impl Key for PathKeys {
    type Number = Float;

    #[inline(always)]
    fn uniform(&self, dimension: u32) -> Float {
        Self::uniform(self, dimension)
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
    /// Vertex: distance of a point in the unit ball (3).
    pub(crate) const BALL: Self = Self(6);
    /// Vertex: whether the path goes on.
    pub(crate) const ROULETTE: Self = Self(9);
}

impl<K: Key> Randoms<K> {
    /// The numbers of block `block` of the path `key`.
    #[inline(always)]
    pub(crate) fn new(key: K, block: u32) -> Self {
        Self { key, first: block * BLOCK }
    }

    /// One number in `[0, 1)`.
    #[inline(always)]
    pub(crate) fn one(&self, dimension: Dimension) -> K::Number {
        self.key.uniform(self.first + dimension.0)
    }

    /// Two numbers in `[0, 1)`.
    #[inline(always)]
    pub(crate) fn two(&self, Dimension(d): Dimension) -> (K::Number, K::Number) {
        (self.one(Dimension(d)), self.one(Dimension(d + 1)))
    }

    /// Three numbers in `[0, 1)`.
    #[inline(always)]
    pub(crate) fn three(&self, Dimension(d): Dimension) -> [K::Number; 3] {
        [self.one(Dimension(d)), self.one(Dimension(d + 1)), self.one(Dimension(d + 2))]
    }
}
