//! Functions of vectors in space, with their operations in contract order.

use glam::Vec3;

use super::real::{Mask, Real, Vector};

/// `a·b`, summed in the order x, y, z.
#[inline(always)]
pub fn dot<V: Vector>(a: V, b: V) -> V::Real {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a × b`.
#[inline(always)]
pub fn cross<V: Vector>(a: V, b: V) -> V {
    V::new(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
}

/// Euclidean length of `a`.
#[inline(always)]
pub fn length<V: Vector>(a: V) -> V::Real {
    dot(a, a).sqrt()
}

/// `a` scaled to unit length by one correctly rounded square root, one correctly rounded division
/// and three products. NaN if the length is 0.
#[inline(always)]
pub fn normalize<V: Vector>(a: V) -> V {
    a * (V::Real::ONE / length(a))
}

/// Largest component of `a`.
#[inline(always)]
pub(crate) fn max_element<V: Vector>(a: V) -> V::Real {
    a[0].most(a[1]).most(a[2])
}

/// `n`, flipped if necessary to the side that a ray of direction `d` comes from, and whether `n`
/// already pointed to that side.
#[inline(always)]
pub(crate) fn face_forward<V: Vector>(n: V, d: V) -> (V, <V::Real as Real>::Mask) {
    let front = dot(d, n).lt(V::Real::ZERO);
    (front.select(n, -n), front)
}

/// Two unit vectors that form a right-handed frame with the unit vector `n`, without branches (Duff
/// et al. 2017, "Building an Orthonormal Basis, Revisited").
#[inline(always)]
pub(crate) fn orthonormal_basis<V: Vector>(n: V) -> (V, V) {
    let one = V::Real::ONE;
    let sign = n[2].ge(V::Real::ZERO).select(one, -one);
    let a = -one / (sign + n[2]);
    let b = n[0] * n[1] * a;
    (
        V::new(one + sign * (n[0] * n[0] * a), sign * b, -(sign * n[0])),
        V::new(b, sign + n[1] * n[1] * a, -n[1]),
    )
}

/// `direction` mirrored at a surface with normal `normal`.
#[inline(always)]
pub(crate) fn reflect<V: Vector>(direction: V, normal: V) -> V {
    direction - normal * (dot(direction, normal) * 2.0)
}

/// A right-handed orthonormal frame with a normal as its z axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame<V = Vec3>([V; 3]);

impl<V: Vector> Frame<V> {
    /// The frame about the unit vector `normal`.
    #[inline(always)]
    pub(crate) fn new(normal: V) -> Self {
        let (s, t) = orthonormal_basis(normal);
        Self([s, t, normal])
    }

    /// The frame about the unit vector `normal` whose x axis is the unit vector `x`, perpendicular to it.
    #[inline(always)]
    pub(crate) fn with_x(x: V, normal: V) -> Self {
        Self([x, cross(normal, x), normal])
    }

    /// `self` in the lanes of `mask`, otherwise `other`.
    #[inline(always)]
    pub(crate) fn select(self, mask: <V::Real as Real>::Mask, other: Self) -> Self {
        let [s, t, n] = self.0;
        Self([mask.select(s, other.0[0]), mask.select(t, other.0[1]), mask.select(n, other.0[2])])
    }

    /// Transforms `v` from the frame to the world.
    #[inline(always)]
    pub(crate) fn world(&self, v: V) -> V {
        let [s, t, n] = self.0;
        s * v[0] + t * v[1] + n * v[2]
    }

    /// Transforms `v` from the world to the frame.
    #[inline(always)]
    pub(crate) fn local(&self, v: V) -> V {
        let [s, t, n] = self.0;
        V::new(dot(s, v), dot(t, v), dot(n, v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;
    use crate::math::warp::uniform_sphere;

    #[test]
    fn basis_is_orthonormal_everywhere() {
        let mut random = Stream::new(1);
        for i in 0..100_000 {
            let n = match i {
                0 => Vec3::Z,
                1 => Vec3::NEG_Z,
                _ => uniform_sphere(random.uniform(), random.uniform()),
            };
            let (s, t) = orthonormal_basis(n);
            for (value, want) in [
                (dot(s, s), 1.0),
                (dot(t, t), 1.0),
                (dot(s, t), 0.0),
                (dot(s, n), 0.0),
                (dot(cross(s, t), n), 1.0),
            ] {
                assert!((value - want).abs() < 2e-6, "{n}: {value} is not {want}");
            }
        }
    }

    #[test]
    fn face_forward_turns_to_the_viewer() {
        assert_eq!(face_forward(Vec3::Z, Vec3::NEG_Z), (Vec3::Z, true));
        assert_eq!(face_forward(Vec3::Z, Vec3::Z), (Vec3::NEG_Z, false));
    }
}
