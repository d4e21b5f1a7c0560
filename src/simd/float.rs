//! Vectors of f32.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Int, LANES, Lanes, Mask, Register, UintRegister};
use crate::math::{Real, Select};

/// A vector with one f32 in each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Float(pub(super) Register);

impl Float {
    #[inline(always)]
    pub(crate) fn new(lanes: Lanes) -> Self {
        Self(Register::new(lanes))
    }

    #[inline(always)]
    pub(crate) fn to_array(self) -> Lanes {
        self.0.to_array()
    }

    /// Loads the first [`LANES`] numbers of `from`.
    ///
    /// # Panics
    /// If `from` is shorter than a vector.
    #[inline(always)]
    pub(crate) fn load(from: &[f32]) -> Self {
        Self::new(*from.first_chunk().expect("a slice of at least LANES numbers"))
    }

    /// Writes all lanes to the beginning of `to`.
    ///
    /// # Panics
    /// If `to` is shorter than a vector.
    #[inline(always)]
    pub(crate) fn store(self, to: &mut [f32]) {
        *to.first_chunk_mut().expect("a slice of at least LANES numbers") = self.to_array();
    }

    #[inline(always)]
    pub(crate) fn first(self) -> f32 {
        self.to_array()[0]
    }

    /// Returns a vector whose lane i is lane `lanes[i]` of `self`.
    #[inline(always)]
    pub(crate) fn shuffled(self, lanes: Int) -> Self {
        Self(self.0.shuffle(lanes.0))
    }

    /// Returns a vector with the smallest lane's value in every lane.
    #[inline(always)]
    pub(crate) fn least_lane(self) -> Self {
        self.reduce(Self::min)
    }

    /// Returns a vector with the largest lane's value in every lane.
    #[inline(always)]
    pub(crate) fn largest_lane(self) -> Self {
        self.reduce(Self::max)
    }

    #[inline(always)]
    fn reduce(mut self, f: impl Fn(Self, Self) -> Self) -> Self {
        let mut apart = LANES / 2;
        while apart > 0 {
            let other = UintRegister::new(std::array::from_fn(|i| (i ^ apart) as u32));
            self = f(self, Self(self.0.shuffle(other)));
            apart /= 2;
        }
        self
    }

    /// `if self < other { self } else { other }`.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        // On x86-64, `fast_min` is `minps`, which does exactly this. On other CPUs it may treat NaN
        // differently.
        if cfg!(target_arch = "x86_64") {
            Self(self.0.fast_min(other.0))
        } else {
            self.lt(other).select(self, other)
        }
    }

    /// `if self > other { self } else { other }`.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        if cfg!(target_arch = "x86_64") {
            Self(self.0.fast_max(other.0))
        } else {
            self.gt(other).select(self, other)
        }
    }

    /// `self * a + b` with one rounding or two, whichever is faster on the target CPU.
    #[inline(always)]
    pub(crate) fn free_mul_add(self, a: Self, b: Self) -> Self {
        Self(self.0.mul_add(a.0, b.0))
    }

    /// `self * a - b` with one rounding or two, whichever is faster on the target CPU.
    #[inline(always)]
    pub(crate) fn free_mul_sub(self, a: Self, b: Self) -> Self {
        Self(self.0.mul_sub(a.0, b.0))
    }
}

impl Select<Mask> for Float {
    #[inline(always)]
    fn select(mask: Mask, yes: Self, no: Self) -> Self {
        Self(mask.0.select(yes.0, no.0))
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl $trait for Float {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }

        impl $trait<f32> for Float {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: f32) -> Self {
                Self(self.0.$method(Register::splat(other)))
            }
        }
    };
}

operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

impl Neg for Float {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}
