//! Vectors of u32.

use std::ops::{Add, BitAnd, BitOr, BitXor, Mul, Shl, Shr, Sub};

use super::{Float, LANES, Lanes, Mask, Register, UintRegister};
use crate::math::{Select, Word};

/// One u32 a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Int(pub(super) UintRegister);

impl Int {
    pub(crate) const ZERO: Self = Self(UintRegister::ZERO);

    /// The number of each lane.
    pub(crate) const LANE: Self = {
        let (mut lanes, mut lane) = ([0; LANES], 0);
        while lane < LANES {
            lanes[lane] = lane as u32;
            lane += 1;
        }
        Self(UintRegister::new(lanes))
    };

    /// `value` in every lane.
    #[inline(always)]
    pub(crate) fn splat(value: u32) -> Self {
        Self(UintRegister::splat(value))
    }

    #[inline(always)]
    pub(crate) const fn new(lanes: Lanes<u32>) -> Self {
        Self(UintRegister::new(lanes))
    }

    /// The first lanes of `from`, which must have as many.
    #[inline(always)]
    pub(crate) fn load(from: &[u32]) -> Self {
        Self::new(*from.first_chunk().expect("a whole vector"))
    }

    /// Writes the first lanes of `to`, which must have as many.
    #[inline(always)]
    pub(crate) fn store(self, to: &mut [u32]) {
        *to.first_chunk_mut().expect("a whole vector") = self.to_array();
    }

    /// Lane `lanes[i]` in each lane i.
    #[inline(always)]
    pub(crate) fn shuffled(self, lanes: Self) -> Self {
        Self(self.0.shuffle(lanes.0))
    }

    /// Where the lanes are the same.
    #[inline(always)]
    pub(crate) fn eq(self, other: Self) -> Mask {
        Mask(Register::from_bits(self.0.simd_eq(other.0)))
    }

    /// Where the lanes are no larger than the other's.
    #[inline(always)]
    pub(crate) fn le(self, other: Self) -> Mask {
        // The comparison of 8 lanes that `wide` has is five operations.
        self.eq(Self(self.0.min(other.0)))
    }

    /// The larger of each lane.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }

    #[inline(always)]
    pub(crate) fn to_array(self) -> Lanes<u32> {
        self.0.to_array()
    }

    /// The least lane.
    #[inline(always)]
    pub(crate) fn least_lane(self) -> u32 {
        let (mut least, mut apart) = (self.0, LANES / 2);
        while apart > 0 {
            let other = UintRegister::new(std::array::from_fn(|i| (i ^ apart) as u32));
            least = least.min(least.shuffle(other));
            apart /= 2;
        }
        least.to_array()[0]
    }

    /// The nearest floats of lanes below 2^31.
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
        Self::splat(value)
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
        // Two or three instructions where the CPU has tables of bytes; `wide` has none.
        Self::new(self.to_array().map(u32::reverse_bits))
    }

    #[inline(always)]
    fn eq(self, other: Self) -> Mask {
        self.eq(other)
    }

    #[inline(always)]
    fn le(self, other: Self) -> Mask {
        self.le(other)
    }
}

impl Select<Mask> for Int {
    #[inline(always)]
    fn select(mask: Mask, yes: Self, no: Self) -> Self {
        // Selecting integers goes byte by byte with AVX-512.
        Float::select(mask, Float::from_bits(yes), Float::from_bits(no)).to_bits()
    }
}

/// Shifts are by less than 32.
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
