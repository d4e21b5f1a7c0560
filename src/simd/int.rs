//! Vectors of u32.

use std::ops::{BitAnd, BitOr};

use super::{Float, LANES, Lanes, Mask, Register, UintRegister};

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
    pub(crate) fn new(lanes: Lanes<u32>) -> Self {
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

    /// Where the lanes are the same.
    #[inline(always)]
    pub(crate) fn eq(self, other: Self) -> Mask {
        Mask(Register::from_bits(self.0.simd_eq(other.0)))
    }

    #[inline(always)]
    pub(crate) fn to_array(self) -> Lanes<u32> {
        self.0.to_array()
    }

    /// `yes` where `mask`, else `no`.
    #[inline(always)]
    pub(crate) fn select(mask: Mask, yes: Self, no: Self) -> Self {
        // Selecting integers goes byte by byte with AVX-512.
        let float = |int: Self| Float(Register::from_bits(int.0));
        mask.select(float(yes), float(no)).to_bits()
    }
}

impl Int {
    /// The least lane.
    #[inline(always)]
    pub(crate) fn least(self) -> u32 {
        let (mut least, mut apart) = (self.0, LANES / 2);
        while apart > 0 {
            let other = UintRegister::new(std::array::from_fn(|i| (i ^ apart) as u32));
            least = least.min(least.shuffle(other));
            apart /= 2;
        }
        least.to_array()[0]
    }
}

impl BitAnd for Int {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for Int {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}
