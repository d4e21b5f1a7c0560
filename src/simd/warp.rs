//! Maps from the unit square to domains that a path tracer samples: [`crate::math::warp`] over
//! lanes, to the bit.

use std::f32::consts::PI;

use super::powers::cbrt;
use super::trig::sin_cos_turns;
use super::{Float, FrameLanes, Vec3x};

/// [`uniform_disk`](crate::math::warp::uniform_disk).
#[inline(always)]
pub(crate) fn uniform_disk(u: Float, v: Float) -> (Float, Float) {
    let radius = u.sqrt();
    let (sin, cos) = sin_cos_turns(v);
    (radius * cos, radius * sin)
}

/// [`uniform_sphere`](crate::math::warp::uniform_sphere).
#[inline(always)]
pub(crate) fn uniform_sphere(u: Float, v: Float) -> Vec3x {
    let one = Float::splat(1.0);
    let z = one - Float::splat(2.0) * u;
    let radius = Float::ZERO.max(one - z * z).sqrt();
    let (sin, cos) = sin_cos_turns(v);
    Vec3x([radius * cos, radius * sin, z])
}

/// [`uniform_ball`](crate::math::warp::uniform_ball).
#[inline(always)]
pub(crate) fn uniform_ball(u: Float, v: Float, w: Float) -> Vec3x {
    uniform_sphere(u, v) * cbrt(w)
}

/// [`cosine_hemisphere`](crate::math::warp::cosine_hemisphere): directions and their cosines.
#[inline(always)]
pub(crate) fn cosine_hemisphere(n: Vec3x, u: Float, v: Float) -> (Vec3x, Float) {
    let (x, y) = uniform_disk(u, v);
    let z = (Float::splat(1.0) - u).sqrt();
    (FrameLanes::new(n).world(Vec3x([x, y, z])), z)
}

/// [`uniform_hemisphere`](crate::math::warp::uniform_hemisphere): directions and their cosines.
#[inline(always)]
pub(crate) fn uniform_hemisphere(n: Vec3x, u: Float, v: Float) -> (Vec3x, Float) {
    let radius = (u * (Float::splat(2.0) - u)).sqrt();
    let (sin, cos) = sin_cos_turns(v);
    let z = Float::splat(1.0) - u;
    (FrameLanes::new(n).world(Vec3x([radius * cos, radius * sin, z])), z)
}

/// [`uniform_cone`](crate::math::warp::uniform_cone).
#[inline(always)]
pub(crate) fn uniform_cone(axis: Vec3x, one_minus_cos: Float, u: Float, v: Float) -> Vec3x {
    let x = u * one_minus_cos;
    let radius = Float::ZERO.max(x * (Float::splat(2.0) - x)).sqrt();
    let (sin, cos) = sin_cos_turns(v);
    FrameLanes::new(axis).world(Vec3x([radius * cos, radius * sin, Float::splat(1.0) - x]))
}

/// [`uniform_cone_pdf`](crate::math::warp::uniform_cone_pdf).
#[inline(always)]
pub(crate) fn uniform_cone_pdf(one_minus_cos: Float) -> Float {
    Float::splat(1.0) / (Float::splat(2.0 * PI) * one_minus_cos)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math;
    use crate::math::random::Stream;
    use crate::simd::{LANES, Lanes, axes};
    use glam::Vec3;

    /// Numbers that random numbers can be, the ends among them.
    fn uniform(random: &mut Stream) -> Lanes {
        std::array::from_fn(|_| match random.bits() % 16 {
            0 => 0.0,
            1 => 1.0 - 0.5 * f32::EPSILON,
            _ => random.uniform(),
        })
    }

    #[track_caller]
    fn same(vector: Vec3x, scalar: impl Fn(usize) -> Vec3) {
        let vector = axes(|axis| vector[axis].to_array());
        for lane in 0..LANES {
            let (found, want) = (vector.map(|axis| axis[lane]), scalar(lane).to_array());
            assert_eq!(found.map(f32::to_bits), want.map(f32::to_bits), "{found:?} {want:?}");
        }
    }

    #[test]
    fn lanes_are_the_scalar_maps() {
        let mut random = Stream::new(9);
        for _ in 0..20_000 {
            let [u, v, a] = [(); 3].map(|()| uniform(&mut random));
            let float = Float::new;
            let normals: [Vec3; LANES] = std::array::from_fn(|i| match i {
                0 => Vec3::Z,
                1 => Vec3::NEG_Z,
                2 => Vec3::new(1.0, 0.0, -0.0),
                _ => math::warp::uniform_sphere(random.uniform(), random.uniform()),
            });
            let n = Vec3x(axes(|axis| float(normals.map(|n| n[axis]))));
            let (x, y) = uniform_disk(float(u), float(v));
            same(Vec3x([x, y, Float::ZERO]), |i| {
                let (x, y) = math::warp::uniform_disk(u[i], v[i]);
                Vec3::new(x, y, 0.0)
            });
            same(uniform_sphere(float(u), float(v)), |i| math::warp::uniform_sphere(u[i], v[i]));
            let ball = uniform_ball(float(u), float(v), float(a));
            same(ball, |i| math::warp::uniform_ball(u[i], v[i], a[i]));
            let (direction, cos) = cosine_hemisphere(n, float(u), float(v));
            let scalar = |i: usize| math::warp::cosine_hemisphere(normals[i], u[i], v[i]);
            same(direction, |i| scalar(i).0);
            same(Vec3x([cos; 3]), |i| Vec3::splat(scalar(i).1));
            let (direction, cos) = uniform_hemisphere(n, float(u), float(v));
            let scalar = |i: usize| math::warp::uniform_hemisphere(normals[i], u[i], v[i]);
            same(direction, |i| scalar(i).0);
            same(Vec3x([cos; 3]), |i| Vec3::splat(scalar(i).1));
            let cone = uniform_cone(n, float(a), float(u), float(v));
            same(cone, |i| math::warp::uniform_cone(normals[i], a[i], u[i], v[i]));
            let pdf = uniform_cone_pdf(float(a));
            same(Vec3x([pdf; 3]), |i| Vec3::splat(math::warp::uniform_cone_pdf(a[i])));
            let (s, t) = n.orthonormal_basis();
            same(s, |i| math::orthonormal_basis(normals[i]).0);
            same(t, |i| math::orthonormal_basis(normals[i]).1);
        }
    }
}
