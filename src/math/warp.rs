//! Maps from the unit square to domains that a path tracer samples
//! (Pharr et al., *Physically Based Rendering*, 4th ed., section A.5).

use std::f32::consts::PI;

use super::powers::cbrt;
use super::real::Real;
use super::real::Vector;
use super::{Frame, max, sin_cos_turns};

/// Uniform point in the unit disk.
#[inline(always)]
pub(crate) fn uniform_disk<R: Real>(u: R, v: R) -> (R, R) {
    let radius = u.sqrt();
    let (sin, cos) = sin_cos_turns(v);
    (radius * cos, radius * sin)
}

/// Uniform unit vector; pdf 1/4π.
#[inline(always)]
pub fn uniform_sphere<R: Real>(u: R, v: R) -> R::Vec3 {
    let z = R::ONE - u * 2.0;
    let radius = max(R::ZERO, R::ONE - z * z).sqrt();
    let (sin, cos) = sin_cos_turns(v);
    R::Vec3::new(radius * cos, radius * sin, z)
}

/// Uniform point in the unit ball. Its direction is that of [`uniform_sphere`], and `w` is the
/// share of the ball's volume that is nearer to the centre than the point.
#[inline(always)]
pub(crate) fn uniform_ball<R: Real>(u: R, v: R, w: R) -> R::Vec3 {
    uniform_sphere(u, v) * cbrt(w)
}

/// Unit vector about `n` with pdf cos θ/π, and cos θ (never 0).
#[inline(always)]
pub(crate) fn cosine_hemisphere<R: Real>(n: R::Vec3, u: R, v: R) -> (R::Vec3, R) {
    let (x, y) = uniform_disk(u, v);
    let z = (R::ONE - u).sqrt();
    (Frame::new(n).world(R::Vec3::new(x, y, z)), z)
}

/// Unit vector about `n` with pdf 1/2π, and cos θ (never 0).
#[inline(always)]
pub(crate) fn uniform_hemisphere<R: Real>(n: R::Vec3, u: R, v: R) -> (R::Vec3, R) {
    let radius = (u * (R::splat(2.0) - u)).sqrt();
    let (sin, cos) = sin_cos_turns(v);
    let z = R::ONE - u;
    (Frame::new(n).world(R::Vec3::new(radius * cos, radius * sin, z)), z)
}

/// Uniform unit vector in the cone about `axis` of half angle θ, with `one_minus_cos` = 1 − cos θ.
/// The pdf is [`uniform_cone_pdf`]. Precise for narrow cones.
#[inline(always)]
pub(crate) fn uniform_cone<R: Real>(axis: R::Vec3, one_minus_cos: R, u: R, v: R) -> R::Vec3 {
    let x = u * one_minus_cos;
    let radius = max(R::ZERO, x * (R::splat(2.0) - x)).sqrt();
    let (sin, cos) = sin_cos_turns(v);
    Frame::new(axis).world(R::Vec3::new(radius * cos, radius * sin, R::ONE - x))
}

/// Density of [`uniform_cone`] per unit solid angle.
#[inline(always)]
pub(crate) fn uniform_cone_pdf<R: Real>(one_minus_cos: R) -> R {
    R::ONE / (one_minus_cos * (2.0 * PI))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::math::{Stream, dot, length};

    const N: usize = 400_000;

    /// Mean of `f` over random points, and its standard error.
    fn mean(mut f: impl FnMut(&mut Stream) -> f32) -> (f64, f64) {
        let mut random = Stream::new(7);
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..N {
            let x = f64::from(f(&mut random));
            sum += x;
            squares += x * x;
        }
        let n = N as f64;
        let mean = sum / n;
        (mean, ((squares / n - mean * mean) / n).sqrt())
    }

    /// Asserts that the mean of `f` is within five standard errors of `want`. A correct sampler
    /// would fail for one of 1.7 million seeds.
    #[track_caller]
    fn assert_mean(want: f64, f: impl FnMut(&mut Stream) -> f32) {
        let (mean, error) = mean(f);
        assert!((mean - want).abs() < 5.0 * error + 1e-6, "{mean} ± {error}, not {want}");
    }

    #[test]
    fn moments_are_those_of_the_densities() {
        let n = crate::math::normalize(Vec3::new(0.3, -0.8, 0.5));
        let uv = |r: &mut Stream| (r.uniform(), r.uniform());
        let cos = |d: Vec3| dot(d, n);
        assert_mean(0.0, |r| {
            let (u, v) = uv(r);
            cos(uniform_sphere(u, v))
        });
        assert_mean(1.0 / 3.0, |r| {
            let (u, v) = uv(r);
            let c = cos(uniform_sphere(u, v));
            c * c
        });
        assert_mean(2.0 / 3.0, |r| {
            let (u, v) = uv(r);
            cos(cosine_hemisphere(n, u, v).0)
        });
        assert_mean(0.5, |r| {
            let (u, v) = uv(r);
            cos(uniform_hemisphere(n, u, v).0)
        });
        assert_mean(0.5, |r| {
            let (u, v) = uv(r);
            let (x, y) = uniform_disk(u, v);
            x * x + y * y
        });
        assert_mean(0.75, |r| {
            let (u, v) = uv(r);
            length(uniform_ball(u, v, r.uniform()))
        });
        assert_mean(0.95, |r| {
            let (u, v) = uv(r);
            cos(uniform_cone(n, 0.1, u, v))
        });
    }

    #[test]
    fn directions_are_unit_and_on_their_side() {
        let mut random = Stream::new(3);
        for _ in 0..100_000 {
            let n = uniform_sphere(random.uniform(), random.uniform());
            let (u, v) = (random.uniform(), random.uniform());
            let (d, cos) = cosine_hemisphere(n, u, v);
            assert!((length(d) - 1.0).abs() < 1e-6 && cos > 0.0);
            assert!((dot(d, n) - cos).abs() < 1e-6);
            let (d, cos) = uniform_hemisphere(n, u, v);
            assert!((length(d) - 1.0).abs() < 1e-6 && cos > 0.0);
            assert!((dot(d, n) - cos).abs() < 1e-6);
        }
    }

    #[test]
    fn cone_density_integrates_to_one() {
        let solid_angle = 2.0 * PI * 0.25;
        assert!((uniform_cone_pdf(0.25) * solid_angle - 1.0).abs() < 1e-6);
    }
}
