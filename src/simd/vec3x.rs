//! Vectors of glam's Vec3, in contract order.

use std::ops::{Add, Div, Index, Mul, Neg, Sub};

use glam::Vec3;

use super::{Float, Lanes, Mask};

/// `f` of each axis. Unlike `[0, 1, 2].map(f)` it is inlined however large the values.
#[inline(always)]
pub(crate) fn axes<T>(f: impl Fn(usize) -> T) -> [T; 3] {
    [f(0), f(1), f(2)]
}

/// One Vec3 a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vec3x(pub(crate) [Float; 3]);

impl Vec3x {
    pub(crate) const ZERO: Self = Self([Float::ZERO; 3]);

    #[inline(always)]
    pub(crate) fn new(lanes: &[Lanes; 3]) -> Self {
        Self([Float::new(lanes[0]), Float::new(lanes[1]), Float::new(lanes[2])])
    }

    /// `lanes[..][lane]` in every lane.
    #[inline(always)]
    pub(crate) fn splat_lane(lanes: &[Lanes; 3], lane: usize) -> Self {
        Self(axes(|axis| Float::splat(lanes[axis][lane])))
    }

    /// [`crate::math::dot`].
    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> Float {
        let ([ax, ay, az], [bx, by, bz]) = (self.0, other.0);
        ax * bx + ay * by + az * bz
    }
}

/// What shading asks for.
impl Vec3x {
    /// [`crate::math::cross`].
    #[inline(always)]
    pub(crate) fn cross(self, other: Self) -> Self {
        let ([ax, ay, az], [bx, by, bz]) = (self.0, other.0);
        Self([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
    }

    /// `v` in every lane.
    #[inline(always)]
    pub(crate) fn splat(v: Vec3) -> Self {
        Self(axes(|axis| Float::splat(v[axis])))
    }

    /// `yes` where `mask` is true, else `no`.
    #[inline(always)]
    pub(crate) fn select(mask: Mask, yes: Self, no: Self) -> Self {
        Self(axes(|axis| mask.select(yes[axis], no[axis])))
    }

    /// [`crate::math::normalize`].
    #[inline(always)]
    pub(crate) fn normalize(self) -> Self {
        self * (Float::splat(1.0) / self.dot(self).sqrt())
    }

    /// [`crate::math::max_element`].
    #[inline(always)]
    pub(crate) fn max_element(self) -> Float {
        self[0].max(self[1]).max(self[2])
    }

    /// [`crate::math::reflect`].
    #[inline(always)]
    pub(crate) fn reflect(self, normal: Self) -> Self {
        self - normal * (Float::splat(2.0) * self.dot(normal))
    }

    /// [`crate::math::face_forward`].
    #[inline(always)]
    pub(crate) fn face_forward(self, direction: Self) -> (Self, Mask) {
        let front = direction.dot(self).lt(Float::ZERO);
        (Self::select(front, self, -self), front)
    }

    /// [`crate::math::orthonormal_basis`].
    #[inline(always)]
    pub(crate) fn orthonormal_basis(self) -> (Self, Self) {
        let Self([x, y, z]) = self;
        let one = Float::splat(1.0);
        let sign = z.ge(Float::ZERO).select(one, -one);
        let a = -one / (sign + z);
        let b = x * y * a;
        (Self([one + sign * (x * x * a), sign * b, -(sign * x)]), Self([b, sign + y * y * a, -y]))
    }
}

/// [`crate::math::Frame`] a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FrameLanes([Vec3x; 3]);

impl FrameLanes {
    #[inline(always)]
    pub(crate) fn new(normal: Vec3x) -> Self {
        let (s, t) = normal.orthonormal_basis();
        Self([s, t, normal])
    }

    #[inline(always)]
    pub(crate) fn normal(&self) -> Vec3x {
        self.0[2]
    }

    #[inline(always)]
    pub(crate) fn world(&self, v: Vec3x) -> Vec3x {
        let [s, t, n] = self.0;
        s * v[0] + t * v[1] + n * v[2]
    }

    #[inline(always)]
    pub(crate) fn local(&self, v: Vec3x) -> Vec3x {
        let [s, t, n] = self.0;
        Vec3x([s.dot(v), t.dot(v), n.dot(v)])
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
