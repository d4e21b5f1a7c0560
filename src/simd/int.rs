//! Vectors of u32.

use super::{Lanes, Mask, Register, UintRegister};

/// One u32 a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Int(pub(super) UintRegister);

impl Int {
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
        Self(mask.0.to_bits().select(yes.0, no.0))
    }
}
