//! Vectors in space over lanes, with sums in the order that the contract prescribes.

use std::ops::{Add, Div, Index, Mul, Neg, Sub};

use super::{Float, Lanes, Mask};
use crate::math::{Real, Select, Vector};

/// Returns `f` of each axis. Unlike `[0, 1, 2].map(f)`, this is inlined however large the values
/// are.
#[inline(always)]
pub(crate) fn axes<T>(f: impl Fn(usize) -> T) -> [T; 3] {
    [f(0), f(1), f(2)]
}

/// A vector with one `Vec3` in each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vec3x(pub(crate) [Float; 3]);

impl Vec3x {
    pub(crate) const ZERO: Self = Self([Float::ZERO; 3]);

    #[inline(always)]
    pub(crate) fn of_lanes(lanes: &[Lanes; 3]) -> Self {
        Self([Float::new(lanes[0]), Float::new(lanes[1]), Float::new(lanes[2])])
    }

    /// Returns a vector that has lane `lane` of `lanes` in every lane.
    #[inline(always)]
    pub(crate) fn splat_lane(lanes: &[Lanes; 3], lane: usize) -> Self {
        Self(axes(|axis| Float::splat(lanes[axis][lane])))
    }

    /// Returns the dot product, as computed by [`crate::math::dot`].
    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> Float {
        crate::math::dot(self, other)
    }
}

impl Vector for Vec3x {
    type Real = Float;

    #[inline(always)]
    fn new(x: Float, y: Float, z: Float) -> Self {
        Self([x, y, z])
    }
}

impl Select<Mask> for Vec3x {
    #[inline(always)]
    fn select(mask: Mask, yes: Self, no: Self) -> Self {
        Self(axes(|axis| Float::select(mask, yes[axis], no[axis])))
    }
}

impl Index<usize> for Vec3x {
    type Output = Float;

    #[inline(always)]
    fn index(&self, axis: usize) -> &Float {
        &self.0[axis]
    }
}

impl Add for Vec3x {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(axes(|axis| self.0[axis] + other.0[axis]))
    }
}

impl Sub for Vec3x {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(axes(|axis| self.0[axis] - other.0[axis]))
    }
}

impl Mul<Float> for Vec3x {
    type Output = Self;

    #[inline(always)]
    fn mul(self, by: Float) -> Self {
        Self(axes(|axis| self.0[axis] * by))
    }
}

impl Mul for Vec3x {
    type Output = Self;

    #[inline(always)]
    fn mul(self, by: Self) -> Self {
        Self(axes(|axis| self.0[axis] * by.0[axis]))
    }
}

impl Div<Float> for Vec3x {
    type Output = Self;

    #[inline(always)]
    fn div(self, by: Float) -> Self {
        Self(axes(|axis| self.0[axis] / by))
    }
}

impl Neg for Vec3x {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(axes(|axis| -self.0[axis]))
    }
}
