//! Numbers that formulas are written over: one `f32`, or one a lane.
//!
//! Sampling, scattering, lights and surface points are written once, over [`Real`]. The scalar engine
//! runs them with `f32`, the wavefront engine with vectors. Every operation here is contract
//! arithmetic: each lane of a vector has the bits that the scalar gives.
//!
//! A choice is [`Mask::select`], of which both sides are computed. Where one side costs much, an
//! `if mask.any()` around it skips it: for `f32` that is an ordinary branch.

use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Index, Mul, Neg, Not, Shl, Shr, Sub};

use glam::Vec3;

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
    /// A checked index of a table, or one a lane.
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

    /// The index of an entry of a table with `len` entries.
    ///
    /// # Panics
    /// If it is not below `len`.
    fn index(entry: Self::Word, len: usize) -> Self::Index;
    /// As [`Real::index`], for tables that often have one entry: then it is read once for all lanes.
    fn index_of_few(entry: Self::Word, len: usize) -> Self::Index;
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

/// A [`glam::Vec3`], or one a lane. Products of two vectors are component by component.
pub trait Vector:
    Copy
    + Debug
    + Select<<Self::Real as Real>::Mask>
    + Index<usize, Output = Self::Real>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Mul<Self::Real, Output = Self>
    + Div<Self::Real, Output = Self>
{
    /// The type of its components.
    type Real: Real<Vec3 = Self>;

    /// The vector with these components.
    fn new(x: Self::Real, y: Self::Real, z: Self::Real) -> Self;

    /// `v` in every lane.
    #[inline(always)]
    fn splat(v: Vec3) -> Self {
        Self::new(Self::Real::splat(v.x), Self::Real::splat(v.y), Self::Real::splat(v.z))
    }

    /// `value` in every component.
    #[inline(always)]
    fn gray(value: Self::Real) -> Self {
        Self::new(value, value, value)
    }

    /// 0 in every component.
    #[inline(always)]
    fn zero() -> Self {
        Self::gray(Self::Real::ZERO)
    }

    /// The magnitude of each component.
    #[inline(always)]
    fn abs(self) -> Self {
        Self::new(self[0].abs(), self[1].abs(), self[2].abs())
    }
}

/// Four words of a table that are read together: a vector and a number.
pub(crate) type Row = [u32; 4];

/// The row of a vector and a number.
pub(crate) fn row(vector: Vec3, number: f32) -> Row {
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
