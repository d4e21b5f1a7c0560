//! Fresnel reflectance of smooth surfaces.
//!
//! The formulas follow Pharr et al., *Physically Based Rendering*, 4th ed., section 9.3.

use super::max;
use super::real::Vector;
use super::real::{Mask, Real};

/// Schlick's approximation of the reflectance of glass, where `cos` is the cosine of the angle of
/// incidence (Schlick 1994).
#[inline(always)]
pub(crate) fn schlick<R: Real>(cos: R, ior: R) -> R {
    let r = (R::ONE - ior) / (R::ONE + ior);
    let r0 = r * r;
    let x = R::ONE - cos;
    let x2 = x * x;
    r0 + (R::ONE - r0) * (x2 * x2 * x)
}

/// Reflectance of a dielectric for unpolarised light. `eta` is the index of refraction beyond the
/// surface divided by the one before it, and `cos`, in `[0, 1]`, the cosine of the angle of
/// incidence.
#[inline(always)]
pub(crate) fn dielectric<R: Real>(cos: R, eta: R) -> R {
    let sin2 = (R::ONE - cos * cos) / (eta * eta);
    let refracted = max(R::ZERO, R::ONE - sin2).sqrt();
    let parallel = (eta * cos - refracted) / (eta * cos + refracted);
    let across = (cos - eta * refracted) / (cos + eta * refracted);
    // Total internal reflection: both terms are 1, or NaN (0/0) at grazing incidence.
    sin2.gt(R::ONE).select(R::ONE, (parallel * parallel + across * across) * 0.5)
}

/// Reflectance of a conductor seen from air, per channel. Its complex index of refraction is `eta +
/// i k`.
#[inline(always)]
pub(crate) fn conductor<V: Vector>(cos: V::Real, eta: V, k: V) -> V {
    V::new(channel(cos, eta[0], k[0]), channel(cos, eta[1], k[1]), channel(cos, eta[2], k[2]))
}

#[inline(always)]
fn channel<R: Real>(cos: R, eta: R, k: R) -> R {
    let cos2 = cos * cos;
    let sin2 = R::ONE - cos2;
    let (n2, k2) = (eta * eta, k * k);
    let difference = n2 - k2 - sin2;
    let modulus = (difference * difference + n2 * 4.0 * k2).sqrt();
    let real = max(R::ZERO, (modulus + difference) * 0.5).sqrt();
    let cross = real * 2.0 * cos;
    let across = ((modulus + cos2) - cross) / ((modulus + cos2) + cross);
    let (sum, part) = (cos2 * modulus + sin2 * sin2, cross * sin2);
    let parallel = across * ((sum - part) / (sum + part));
    (across + parallel) * 0.5
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    /// Compares with the Fresnel equations in complex f64 arithmetic.
    #[test]
    fn reflectances_match_the_fresnel_equations() {
        type Complex = (f64, f64);
        let add = |a: Complex, b: Complex| (a.0 + b.0, a.1 + b.1);
        let multiply = |a: Complex, b: Complex| (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0);
        let norm = |a: Complex| a.0 * a.0 + a.1 * a.1;
        let root = |a: Complex| {
            let length = norm(a).sqrt();
            (((length + a.0) / 2.0).sqrt(), ((length - a.0) / 2.0).sqrt().copysign(a.1))
        };
        let reflectance = |cos: f64, eta: Complex| {
            let eta2 = multiply(eta, eta);
            // η cos θt = √(η² − sin²θ). The numerator and the denominator of `parallel` are
            // multiplied by η.
            let refracted = root(add(eta2, (cos * cos - 1.0, 0.0)));
            let across = norm(add((cos, 0.0), (-refracted.0, -refracted.1)))
                / norm(add((cos, 0.0), refracted));
            let bent = multiply(eta2, (cos, 0.0));
            let parallel =
                norm(add(bent, (-refracted.0, -refracted.1))) / norm(add(bent, refracted));
            0.5 * (across + parallel)
        };
        for step in 0..=1000u16 {
            let cos = f32::from(step) / 1000.0;
            for eta in [0.4f32, 0.66, 1.01, 1.5, 2.4] {
                let want = reflectance(f64::from(cos), (f64::from(eta), 0.0));
                let got = f64::from(dielectric(cos, eta));
                assert!((got - want).abs() < 2e-5, "{cos} {eta}: {got} {want}");
            }
            for (eta, k) in [(0.2f32, 3.9f32), (1.5, 7.6), (0.05, 4.0), (3.0, 0.0)] {
                let want = reflectance(f64::from(cos), (f64::from(eta), f64::from(k)));
                let got = f64::from(conductor(cos, Vec3::splat(eta), Vec3::splat(k)).y);
                assert!((got - want).abs() < 2e-5, "{cos} {eta} {k}: {got} {want}");
            }
        }
        assert_eq!(dielectric(0.0, 0.5), 1.0);
        assert!((schlick(1.0, 1.5) - 0.04).abs() < 1e-7 && schlick(0.0, 1.5) == 1.0);
    }
}
