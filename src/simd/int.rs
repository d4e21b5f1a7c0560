//! Vectors of u32.

use std::ops::{Add, BitAnd, BitOr, BitXor, Mul, Shl, Shr, Sub};

use super::{Float, LANES, Lanes, Mask, Register, UintRegister};
use crate::math::{Real, Select, Word};

/// A vector with one u32 in each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Int(pub(super) UintRegister);

impl Int {
    pub(crate) const ZERO: Self = Self(UintRegister::ZERO);

    /// Each lane holds its own index.
    pub(crate) const LANE: Self = {
        let (mut lanes, mut lane) = ([0; LANES], 0);
        while lane < LANES {
            lanes[lane] = lane as u32;
            lane += 1;
        }
        Self(UintRegister::new(lanes))
    };

    #[inline(always)]
    pub(crate) const fn new(lanes: Lanes<u32>) -> Self {
        Self(UintRegister::new(lanes))
    }

    /// Loads the first [`LANES`] numbers of `from`.
    ///
    /// # Panics
    /// If `from` is shorter than a vector.
    #[inline(always)]
    pub(crate) fn load(from: &[u32]) -> Self {
        Self::new(*from.first_chunk().expect("a slice of at least LANES numbers"))
    }

    /// Writes all lanes to the beginning of `to`.
    ///
    /// # Panics
    /// If `to` is shorter than a vector.
    #[inline(always)]
    pub(crate) fn store(self, to: &mut [u32]) {
        *to.first_chunk_mut().expect("a slice of at least LANES numbers") = self.to_array();
    }

    /// Returns a vector whose lane i is lane `lanes[i]` of `self`.
    #[inline(always)]
    pub(crate) fn shuffled(self, lanes: Self) -> Self {
        Self(self.0.shuffle(lanes.0))
    }

    /// Returns the larger number in each lane.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }

    #[inline(always)]
    pub(crate) fn to_array(self) -> Lanes<u32> {
        self.0.to_array()
    }

    /// Returns the float nearest to each lane. Lanes must be below 2^31.
    #[inline(always)]
    pub(crate) fn to_float(self) -> Float {
        let signed = self.0.cast_signed();
        #[cfg(target_feature = "avx512f")]
        return Float(Register::from_i32x16(signed));
        #[cfg(not(target_feature = "avx512f"))]
        return Float(Register::from_i32x8(signed));
    }
}

impl Word for Int {
    type Mask = Mask;

    #[inline(always)]
    fn splat(value: u32) -> Self {
        Self(UintRegister::splat(value))
    }

    #[inline(always)]
    fn wrapping_add(self, other: Self) -> Self {
        self + other
    }

    #[inline(always)]
    fn wrapping_sub(self, other: Self) -> Self {
        self - other
    }

    #[inline(always)]
    fn wrapping_mul(self, other: Self) -> Self {
        self * other
    }

    #[inline(always)]
    fn reverse_bits(self) -> Self {
        // `wide` has no such operation. The compiler uses byte shuffles where the CPU has them.
        Self::new(self.to_array().map(u32::reverse_bits))
    }

    #[inline(always)]
    fn eq(self, other: Self) -> Mask {
        Mask(Register::from_bits(self.0.simd_eq(other.0)))
    }

    #[inline(always)]
    fn le(self, other: Self) -> Mask {
        // The comparison that `wide` offers for 8 lanes takes five operations.
        self.eq(Self(self.0.min(other.0)))
    }
}

impl Select<Mask> for Int {
    #[inline(always)]
    fn select(mask: Mask, yes: Self, no: Self) -> Self {
        // With AVX-512, `wide` selects integers byte by byte, so select them as floats.
        Float::select(mask, Float::from_bits(yes), Float::from_bits(no)).to_bits()
    }
}

/// Shift amounts must be below 32.
impl Shl<u32> for Int {
    type Output = Self;

    #[inline(always)]
    fn shl(self, bits: u32) -> Self {
        Self(self.0 << bits)
    }
}

impl Shr<u32> for Int {
    type Output = Self;

    #[inline(always)]
    fn shr(self, bits: u32) -> Self {
        Self(self.0 >> bits)
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl $trait for Int {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
    };
}

// Sums, differences and products are modulo 2^32.
operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(BitAnd, bitand);
operator!(BitOr, bitor);
operator!(BitXor, bitxor);
