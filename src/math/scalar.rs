//! Implements the traits of `real` for `f32`, the arithmetic of the scalar engine.

use glam::Vec3;

use super::real::{Mask, Real, Row, Select, Vector, Word};

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
    fn index(entry: u32, len: usize) -> u32 {
        debug_assert!(
            (entry as usize) < len,
            "index {entry} is out of range for a table of {len} entries"
        );
        entry
    }

    #[inline(always)]
    fn index_of_few(entry: u32, len: usize) -> u32 {
        Self::index(entry, len)
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

impl Vector for Vec3 {
    type Real = f32;

    #[inline(always)]
    fn new(x: f32, y: f32, z: f32) -> Self {
        Vec3::new(x, y, z)
    }
}
