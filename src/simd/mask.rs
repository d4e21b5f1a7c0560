//! Masks over lanes.

use std::ops::{BitAnd, BitOr, BitXor, Not};

use super::{LANES, Register, UintRegister};
use crate::math;

/// A mask with one truth value in each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mask(pub(super) Register);

impl Mask {
    pub(crate) const NONE: Self = Self(Register::ZERO);

    pub(crate) const ALL: Self = Self(Register::new([f32::from_bits(u32::MAX); LANES]));

    /// Returns the mask of the lanes whose bits are set.
    #[inline(always)]
    pub(crate) fn from_bits(bits: u32) -> Self {
        const BIT: UintRegister = {
            let (mut lanes, mut lane) = ([0; LANES], 0);
            while lane < LANES {
                lanes[lane] = 1 << lane;
                lane += 1;
            }
            UintRegister::new(lanes)
        };
        Self(Register::from_bits((UintRegister::splat(bits) & BIT).simd_eq(BIT)))
    }

    #[inline(always)]
    pub(crate) fn any(self) -> bool {
        self.0.any()
    }

    /// Returns the mask as bits. Bit i is lane i.
    #[inline(always)]
    pub(crate) fn bits(self) -> u32 {
        self.0.to_bitmask()
    }

    /// Returns `yes` in lanes that are true and `no` in the others.
    #[inline(always)]
    pub(crate) fn select<T: math::Select<Self>>(self, yes: T, no: T) -> T {
        T::select(self, yes, no)
    }
}

impl math::Mask for Mask {
    const NONE: Self = Self::NONE;
    const ALL: Self = Self::ALL;

    #[inline(always)]
    fn any(self) -> bool {
        self.any()
    }
}

impl math::Select<Mask> for Mask {
    #[inline(always)]
    fn select(mask: Mask, yes: Self, no: Self) -> Self {
        Self(mask.0.select(yes.0, no.0))
    }
}

impl BitAnd for Mask {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for Mask {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitXor for Mask {
    type Output = Self;

    #[inline(always)]
    fn bitxor(self, other: Self) -> Self {
        Self(self.0 ^ other.0)
    }
}

impl Not for Mask {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

/// Returns a number whose lowest `count` bits are set, or all 32 if `count` is larger.
#[inline(always)]
pub(crate) fn first_bits(count: usize) -> u32 {
    !u32::MAX.unbounded_shl(count as u32)
}

/// Iterator over the positions of the set bits of a mask, from the lowest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bits(pub(crate) u32);

impl Iterator for Bits {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let lane = self.0.trailing_zeros() as usize;
        self.0 &= self.0 - 1;
        // Since the compiler sees that the lane is in range, indexing by it needs no bounds check.
        (lane < LANES).then_some(lane)
    }
}
