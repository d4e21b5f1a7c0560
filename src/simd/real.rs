//! [`Real`] for [`Float`], so that formulas can be evaluated over lanes.

use super::{Float, Indices, Int, LANES, Mask, Register, Vec3x};
use crate::math::{Real, Row};

impl Real for Float {
    type Mask = Mask;
    type Word = Int;
    type Vec3 = Vec3x;
    type Index = Indices;

    const ZERO: Self = Self(Register::ZERO);
    const ONE: Self = Self(Register::ONE);
    const INFINITY: Self = Self(Register::new([f32::INFINITY; LANES]));

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self(Register::splat(value))
    }

    #[inline(always)]
    fn from_bits(bits: Int) -> Self {
        Self(Register::from_bits(bits.0))
    }

    #[inline(always)]
    fn to_bits(self) -> Int {
        Int(self.0.to_bits())
    }

    #[inline(always)]
    fn from_word(word: Int) -> Self {
        word.to_float()
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    #[inline(always)]
    fn floor(self) -> Self {
        Self(self.0.floor())
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        let negative_zero = Register::splat(-0.0);
        Self((self.0 & !negative_zero) | (sign.0 & negative_zero))
    }

    #[inline(always)]
    fn least(self, other: Self) -> Self {
        self.min(other)
    }

    #[inline(always)]
    fn most(self, other: Self) -> Self {
        self.max(other)
    }

    #[inline(always)]
    fn lt(self, other: Self) -> Mask {
        Mask(self.0.simd_lt(other.0))
    }

    #[inline(always)]
    fn le(self, other: Self) -> Mask {
        Mask(self.0.simd_le(other.0))
    }

    #[inline(always)]
    fn gt(self, other: Self) -> Mask {
        Mask(self.0.simd_gt(other.0))
    }

    #[inline(always)]
    fn ge(self, other: Self) -> Mask {
        Mask(self.0.simd_ge(other.0))
    }

    #[inline(always)]
    fn eq(self, other: Self) -> Mask {
        Mask(self.0.simd_eq(other.0))
    }

    #[inline(always)]
    fn index(entry: Int, len: usize) -> Indices {
        Indices::new(entry, len)
    }

    #[inline(always)]
    fn index_of_few(entry: Int, len: usize) -> Indices {
        Indices::of_few(entry, len)
    }

    #[inline(always)]
    fn gather<T>(table: &[T], index: Indices, row: impl Fn(&T) -> &Row) -> (Vec3x, Self) {
        index.gather(table, row)
    }

    #[inline(always)]
    fn pick(table: &[u32], index: Indices) -> Int {
        Int::new(index.pick(table))
    }

    #[inline(always)]
    fn each_lane<const I: usize, const O: usize>(
        word: Int,
        from: [Self; I],
        f: impl Fn(u32, [f32; I]) -> [f32; O],
    ) -> [Self; O] {
        let (words, from) = (word.to_array(), from.map(Self::to_array));
        let mut to = [[0.0; LANES]; O];
        for lane in 0..LANES {
            let values = f(words[lane], std::array::from_fn(|i| from[i][lane]));
            for (to, value) in to.iter_mut().zip(values) {
                to[lane] = value;
            }
        }
        to.map(Self::new)
    }

    #[inline(always)]
    fn each_word(word: Int, f: impl Fn(u32) -> u32) -> Int {
        Int::new(word.to_array().map(f))
    }
}
