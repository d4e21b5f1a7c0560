//! [`Real`] for [`Float`], so that formulas can be evaluated over lanes.

use super::{Float, Indices, Int, LANES, Mask, Register, Vec3x};
use crate::math::{Real, Row};

impl Real for Float {
    type Mask = Mask;
    type Word = Int;
    type Vec3 = Vec3x;
    type Index = Indices;

    const ZERO: Self = Self::ZERO;
    const ONE: Self = Self(Register::ONE);
    const INFINITY: Self = Self::INFINITY;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self::splat(value)
    }

    #[inline(always)]
    fn from_bits(bits: Int) -> Self {
        Self::from_bits(bits)
    }

    #[inline(always)]
    fn to_bits(self) -> Int {
        self.to_bits()
    }

    #[inline(always)]
    fn from_word(word: Int) -> Self {
        word.to_float()
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn floor(self) -> Self {
        self.floor()
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn copysign(self, sign: Self) -> Self {
        self.copysign(sign)
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
        self.lt(other)
    }

    #[inline(always)]
    fn le(self, other: Self) -> Mask {
        self.le(other)
    }

    #[inline(always)]
    fn gt(self, other: Self) -> Mask {
        self.gt(other)
    }

    #[inline(always)]
    fn ge(self, other: Self) -> Mask {
        self.ge(other)
    }

    #[inline(always)]
    fn eq(self, other: Self) -> Mask {
        self.eq(other)
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
