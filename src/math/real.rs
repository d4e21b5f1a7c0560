//! Number types that formulas are generic over: one `f32`, or one per lane of a vector.
//!
//! Sampling, scattering, lights and surface points are written once, over [`Real`]. The scalar
//! engine runs them with `f32`, the wavefront engine with vectors. Every operation here is contract
//! arithmetic: each lane of a vector has the same bits as the scalar result.
//!
//! [`Mask::select`] replaces branches and computes both sides. To skip an expensive side, wrap it
//! in `if mask.any()`, which is an ordinary branch for `f32`.

use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Index, Mul, Neg, Not, Shl, Shr, Sub};

use glam::Vec3;

/// An `f32`, or one per lane.
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
    /// A `bool`, or one per lane.
    type Mask: Mask;
    /// A `u32`, or one per lane.
    type Word: Word<Mask = Self::Mask>;
    /// A vector in space, or one per lane.
    type Vec3: Vector<Real = Self>;
    /// A checked index into a table, or one per lane.
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
    /// The number nearest to an integer below 2^31.
    fn from_word(word: Self::Word) -> Self;

    /// The correctly rounded square root.
    fn sqrt(self) -> Self;
    /// The largest integer not above `self`.
    fn floor(self) -> Self;
    /// The magnitude.
    fn abs(self) -> Self;
    /// The magnitude of `self` with the sign of `sign`.
    fn copysign(self, sign: Self) -> Self;
    /// `if self < other { self } else { other }`.
    fn least(self, other: Self) -> Self;
    /// `if self > other { self } else { other }`.
    fn most(self, other: Self) -> Self;

    /// Whether `self < other`. Like all comparisons, this is false for NaN.
    fn lt(self, other: Self) -> Self::Mask;
    /// Whether `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// Whether `self > other`.
    fn gt(self, other: Self) -> Self::Mask;
    /// Whether `self >= other`.
    fn ge(self, other: Self) -> Self::Mask;
    /// Whether `self == other`.
    fn eq(self, other: Self) -> Self::Mask;

    /// Converts `entry` to an index into a table of `len` entries.
    ///
    /// # Panics
    /// If `entry` is not below `len`.
    fn index(entry: Self::Word, len: usize) -> Self::Index;
    /// As [`Real::index`], for tables that often have a single entry, which is then read once for
    /// all lanes.
    fn index_of_few(entry: Self::Word, len: usize) -> Self::Index;
    /// Reads the entry of `table` at `index`. Returns the vector and the number in the `row` of
    /// that entry.
    fn gather<T>(table: &[T], index: Self::Index, row: impl Fn(&T) -> &Row) -> (Self::Vec3, Self);
    /// The word of `table` at `index`.
    fn pick(table: &[u32], index: Self::Index) -> Self::Word;
    /// Applies `f` to each lane, for functions that have no vector form.
    fn each_lane<const I: usize, const O: usize>(
        word: Self::Word,
        from: [Self; I],
        f: impl Fn(u32, [f32; I]) -> [f32; O],
    ) -> [Self; O];
    /// Applies `f` to the word of each lane.
    fn each_word(word: Self::Word, f: impl Fn(u32) -> u32) -> Self::Word;
}

/// A [`glam::Vec3`], or one per lane. The product of two vectors is taken component by component.
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

/// Four words of a table that are read together: the bits of a vector and a number.
pub(crate) type Row = [u32; 4];

/// Packs a vector and a number into a row.
pub(crate) fn row(vector: Vec3, number: f32) -> Row {
    vector.extend(number).to_array().map(f32::to_bits)
}

/// A `bool`, or one per lane.
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

/// Types whose values a [`Mask`] can choose between.
pub trait Select<M> {
    /// `yes` where `mask` is true, else `no`.
    fn select(mask: M, yes: Self, no: Self) -> Self;
}

/// A `u32`, or one per lane. Arithmetic is modulo 2^32; shifts are by less than 32.
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
    /// A `bool`, or one per lane.
    type Mask: Mask;

    /// `value` in every lane.
    fn splat(value: u32) -> Self;
    /// The sum.
    fn wrapping_add(self, other: Self) -> Self;
    /// The difference.
    fn wrapping_sub(self, other: Self) -> Self;
    /// The product.
    fn wrapping_mul(self, other: Self) -> Self;
    /// The bits in reverse order.
    fn reverse_bits(self) -> Self;
    /// Whether `self == other`.
    fn eq(self, other: Self) -> Self::Mask;
    /// Whether `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
}
