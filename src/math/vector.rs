//! Vector operations on [`glam::Vec3`], in contract order.

use glam::Vec3;

/// `a·b`, summed in the order x, y, z.
#[inline]
pub fn dot(a: Vec3, b: Vec3) -> f32 {
    a.x * b.x + a.y * b.y + a.z * b.z
}

/// `a × b`.
#[inline]
pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

/// Euclidean length of `a`.
#[inline]
pub fn length(a: Vec3) -> f32 {
    dot(a, a).sqrt()
}

/// `a` scaled to unit length: one true square root, one true division, three products.
/// NaN where the length is 0.
#[inline]
pub fn normalize(a: Vec3) -> Vec3 {
    a * (1.0 / length(a))
}

/// Largest component of `a`.
#[inline]
pub fn max_element(a: Vec3) -> f32 {
    super::max(super::max(a.x, a.y), a.z)
}

/// `n` turned to the side that a ray of direction `d` comes from, and whether `n`
/// pointed there already.
#[inline]
pub fn face_forward(n: Vec3, d: Vec3) -> (Vec3, bool) {
    let front = dot(d, n) < 0.0;
    (if front { n } else { -n }, front)
}

/// Two unit vectors that make a right-handed frame with the unit vector `n`, without
/// branches (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
#[inline]
pub fn orthonormal_basis(n: Vec3) -> (Vec3, Vec3) {
    let sign = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (
        Vec3::new(1.0 + sign * (n.x * n.x * a), sign * b, -(sign * n.x)),
        Vec3::new(b, sign + n.y * n.y * a, -n.y),
    )
}

/// `direction` mirrored at a surface with normal `normal`.
#[inline]
pub fn reflect(direction: Vec3, normal: Vec3) -> Vec3 {
    direction - normal * (2.0 * dot(direction, normal))
}

/// A right-handed orthonormal frame about a normal, which is its z.
#[derive(Clone, Copy, Debug)]
pub struct Frame([Vec3; 3]);

impl Frame {
    /// That of the unit vector `normal`.
    #[inline]
    pub fn new(normal: Vec3) -> Self {
        let (s, t) = orthonormal_basis(normal);
        Self([s, t, normal])
    }

    /// Its z.
    #[inline]
    pub fn normal(&self) -> Vec3 {
        self.0[2]
    }

    /// `v`, given in the frame, in the world.
    #[inline]
    pub fn world(&self, v: Vec3) -> Vec3 {
        let [s, t, n] = self.0;
        s * v.x + t * v.y + n * v.z
    }

    /// `v`, given in the world, in the frame.
    #[inline]
    pub fn local(&self, v: Vec3) -> Vec3 {
        let [s, t, n] = self.0;
        Vec3::new(dot(s, v), dot(t, v), dot(n, v))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;
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
