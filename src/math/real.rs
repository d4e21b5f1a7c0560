//! Numbers that formulas are written over: one `f32`, or one a lane.
//!
//! Sampling, scattering, lights and surface points are written once, over [`Real`]. The scalar engine
//! runs them with `f32`, the wavefront engine with vectors. Every operation here is contract
//! arithmetic: each lane of a vector has the bits that the scalar gives.
//!
//! A choice is [`Mask::select`], of which both sides are computed. Where one side costs much, an
//! `if mask.any()` around it skips it: for `f32` that is an ordinary branch.

use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Shl, Shr, Sub};

use glam::Vec3;

use super::vector::Vector;

/// An `f32`, or one a lane.
pub trait Real:
    Copy
    + 'static
    + Debug
    + Select<Self::Mask>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f32, Output = Self>
    + Sub<f32, Output = Self>
    + Mul<f32, Output = Self>
{
    /// A truth value, or one a lane.
    type Mask: Mask;
    /// 32 bits, or as many a lane.
    type Word: Word<Mask = Self::Mask>;
    /// A vector in space, or one a lane.
    type Vec3: Vector<Real = Self>;
    /// A checked place in a table, or one a lane.
    type Index: Copy;

    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// ∞.
    const INFINITY: Self;

    /// `value` in every lane.
    fn splat(value: f32) -> Self;
    /// The number with these bits.
    fn from_bits(bits: Self::Word) -> Self;
    /// The bits of the number.
    fn to_bits(self) -> Self::Word;
    /// The nearest number to an integer below 2^31.
    fn from_word(word: Self::Word) -> Self;

    /// The square root, rounded once.
    fn sqrt(self) -> Self;
    /// The largest integer that is not above.
    fn floor(self) -> Self;
    /// The magnitude.
    fn abs(self) -> Self;
    /// The magnitude of `self` with the sign of `sign`.
    fn copysign(self, sign: Self) -> Self;
    /// `if self < other { self } else { other }`.
    fn least(self, other: Self) -> Self;
    /// `if self > other { self } else { other }`.
    fn most(self, other: Self) -> Self;

    /// Less than; like all comparisons false for NaN.
    fn lt(self, other: Self) -> Self::Mask;
    /// At most.
    fn le(self, other: Self) -> Self::Mask;
    /// Greater than.
    fn gt(self, other: Self) -> Self::Mask;
    /// At least.
    fn ge(self, other: Self) -> Self::Mask;
    /// Equal.
    fn eq(self, other: Self) -> Self::Mask;

    /// A place in a table of `len` entries.
    ///
    /// # Panics
    /// If it is not below `len`.
    fn index(place: Self::Word, len: usize) -> Self::Index;
    /// As [`Real::index`], for tables that often have one entry: then it is read once for all lanes.
    fn index_of_few(place: Self::Word, len: usize) -> Self::Index;
    /// The row that `row` finds in the entry of `table` at `index`: a vector and a number.
    fn gather<T>(table: &[T], index: Self::Index, row: impl Fn(&T) -> &Row) -> (Self::Vec3, Self);
    /// The words of `table` at `index`.
    fn pick(table: &[u32], index: Self::Index) -> Self::Word;
    /// `f` of each lane: for what has no vector form.
    fn each_lane<const I: usize, const O: usize>(
        word: Self::Word,
        from: [Self; I],
        f: impl Fn(u32, [f32; I]) -> [f32; O],
    ) -> [Self; O];
    /// `f` of each lane's word.
    fn each_word(word: Self::Word, f: impl Fn(u32) -> u32) -> Self::Word;
}

/// Four words of a table that are read together: a vector and a number.
pub type Row = [u32; 4];

/// The row of a vector and a number.
pub fn row(vector: Vec3, number: f32) -> Row {
    vector.extend(number).to_array().map(f32::to_bits)
}

/// A `bool`, or one a lane.
pub trait Mask:
    Copy
    + Debug
    + Select<Self>
    + Not<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
{
    /// False in every lane.
    const NONE: Self;
    /// True in every lane.
    const ALL: Self;

    /// Whether any lane is true.
    fn any(self) -> bool;

    /// `yes` where the mask is true, else `no`.
    #[inline(always)]
    fn select<T: Select<Self>>(self, yes: T, no: T) -> T {
        T::select(self, yes, no)
    }
}

/// What a mask chooses between.
pub trait Select<M> {
    /// `yes` where `mask` is true, else `no`.
    fn select(mask: M, yes: Self, no: Self) -> Self;
}

/// A `u32`, or one a lane. Arithmetic is modulo 2^32; shifts are by less than 32.
pub trait Word:
    Copy
    + Debug
    + Select<Self::Mask>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
    + Shl<u32, Output = Self>
    + Shr<u32, Output = Self>
{
    /// A truth value, or one a lane.
    type Mask: Mask;

    /// `value` in every lane.
    fn splat(value: u32) -> Self;
    /// The sum.
    fn wrapping_add(self, other: Self) -> Self;
    /// The difference.
    fn wrapping_sub(self, other: Self) -> Self;
    /// The product.
    fn wrapping_mul(self, other: Self) -> Self;
    /// The bits in the opposite order.
    fn reverse_bits(self) -> Self;
    /// Equal.
    fn eq(self, other: Self) -> Self::Mask;
    /// At most.
    fn le(self, other: Self) -> Self::Mask;
}

impl Real for f32 {
    type Mask = bool;
    type Word = u32;
    type Vec3 = Vec3;
    type Index = u32;

    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const INFINITY: Self = f32::INFINITY;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        f32::from_bits(bits)
    }

    #[inline(always)]
    fn to_bits(self) -> u32 {
        f32::to_bits(self)
    }

    #[inline(always)]
    fn from_word(word: u32) -> Self {
        word as f32
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f32::sqrt(self)
    }

    #[inline(always)]
    fn floor(self) -> Self {
        f32::floor(self)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f32::abs(self)
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        f32::copysign(self, sign)
    }

    #[inline(always)]
    fn least(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn most(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }

    #[inline(always)]
    fn gt(self, other: Self) -> bool {
        self > other
    }

    #[inline(always)]
    fn ge(self, other: Self) -> bool {
        self >= other
    }

    #[inline(always)]
    fn eq(self, other: Self) -> bool {
        self == other
    }

    #[inline(always)]
    fn index(place: u32, len: usize) -> u32 {
        debug_assert!((place as usize) < len, "{place} is not below {len}");
        place
    }

    #[inline(always)]
    fn index_of_few(place: u32, len: usize) -> u32 {
        Self::index(place, len)
    }

    #[inline(always)]
    fn gather<T>(table: &[T], index: u32, row: impl Fn(&T) -> &Row) -> (Vec3, f32) {
        let [x, y, z, number] = row(&table[index as usize]).map(f32::from_bits);
        (Vec3::new(x, y, z), number)
    }

    #[inline(always)]
    fn pick(table: &[u32], index: u32) -> u32 {
        table[index as usize]
    }

    #[inline(always)]
    fn each_lane<const I: usize, const O: usize>(
        word: u32,
        from: [f32; I],
        f: impl Fn(u32, [f32; I]) -> [f32; O],
    ) -> [f32; O] {
        f(word, from)
    }

    #[inline(always)]
    fn each_word(word: u32, f: impl Fn(u32) -> u32) -> u32 {
        f(word)
    }
}

impl Mask for bool {
    const NONE: Self = false;
    const ALL: Self = true;

    #[inline(always)]
    fn any(self) -> bool {
        self
    }
}

macro_rules! select_by_branch {
    ($($type:ty),*) => { $(
        impl Select<bool> for $type {
            #[inline(always)]
            fn select(mask: bool, yes: Self, no: Self) -> Self {
                if mask { yes } else { no }
            }
        }
    )* };
}

select_by_branch!(f32, u32, bool, Vec3);

impl Word for u32 {
    type Mask = bool;

    #[inline(always)]
    fn splat(value: u32) -> Self {
        value
    }

    #[inline(always)]
    fn wrapping_add(self, other: Self) -> Self {
        u32::wrapping_add(self, other)
    }

    #[inline(always)]
    fn wrapping_sub(self, other: Self) -> Self {
        u32::wrapping_sub(self, other)
    }

    #[inline(always)]
    fn wrapping_mul(self, other: Self) -> Self {
        u32::wrapping_mul(self, other)
    }

    #[inline(always)]
    fn reverse_bits(self) -> Self {
        u32::reverse_bits(self)
    }

    #[inline(always)]
    fn eq(self, other: Self) -> bool {
        self == other
    }

    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }
}
