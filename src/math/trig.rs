//! Sine, cosine and their inverses as short polynomials in contract arithmetic.
//!
//! libm's results differ by platform and `wide`'s by instruction set; these functions agree
//! everywhere. The coefficients are Chebyshev fits, computed with 40 digits and rounded to f32.
//! Each function states its error bound against f64, and a test checks it.

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::real::{Mask, Real, Word};
use super::{min, polynomial};

/// Coefficients of sin 2πr for r, r³, … r^9, valid for |r| ≤ 1/8.
const SIN: [f32; 5] = [6.283_185_5, -41.341_7, 81.605_2, -76.697_87, 41.472_83];
/// Coefficients of cos 2πr for r², r^4, … r^8, valid for |r| ≤ 1/8.
const COS: [f32; 4] = [-19.739_208, 64.939_316, -85.442_85, 59.220_17];

/// Coefficients of atan r for r³, r^5, … r^11, valid for |r| ≤ tan π/8.
const ATAN: [f32; 5] = [-0.333_333_3, 0.199_995_4, -0.142_639_56, 0.107_437_31, -0.064_519_28];
const TAN_PI_8: f32 = 0.414_213_57;

/// Coefficients of asin r for r³, r^5, … r^13, valid for |r| ≤ 1/2.
const ASIN: [f32; 6] =
    [0.166_666_66, 0.075_000_94, 0.044_599_403, 0.031_100_662, 0.017_149_238, 0.033_690_847];

/// `(sin 2πu, cos 2πu)` for `u` in `[-2, 2]`, within 1.1e-7.
///
/// The argument is in turns because its reduction is then exact.
#[inline(always)]
pub(crate) fn sin_cos_turns<R: Real>(u: R) -> (R, R) {
    // Adding 1.5 · 2²³ rounds to an integer, ties to even, and leaves it in the lowest bits.
    const MAGIC: f32 = 12_582_912.0;
    let shifted = u * 4.0 + MAGIC;
    let quadrant = shifted - MAGIC;
    let r = u - quadrant * 0.25; // exact, in [-1/8, 1/8]
    let s = r * r;
    let sin = r * polynomial(s, SIN);
    let cos = s * polynomial(s, COS) + 1.0;
    // Quadrants 1 and 3 swap sine and cosine. Sines are negative in quadrants 2 and 3, cosines in 1
    // and 2.
    let (bits, one) = (shifted.to_bits(), R::Word::splat(1));
    let swapped = (bits & one).eq(one);
    let (odd, upper) = (bits << 31, (bits >> 1) << 31);
    let with_sign = |value: R, sign: R::Word| R::from_bits(value.to_bits() ^ sign);
    (with_sign(swapped.select(cos, sin), upper), with_sign(swapped.select(sin, cos), upper ^ odd))
}

/// `(sin x, cos x)` for `x` in radians, `[-4π, 4π]`, within 1.1e-7 + |x|·1.2e-7.
#[inline(always)]
pub(crate) fn sin_cos<R: Real>(x: R) -> (R, R) {
    sin_cos_turns(x * (1.0 / (2.0 * PI)))
}

/// `asin x` for `x` in `[-1, 1]`, within a relative error of 3.6e-7. Other arguments are clamped.
#[inline(always)]
pub(crate) fn asin<R: Real>(x: R) -> R {
    let a = min(x.abs(), R::ONE);
    // Beyond 1/2: asin a = π/2 − 2 asin √((1 − a)/2).
    let steep = a.gt(R::splat(0.5));
    let s = steep.select((R::ONE - a) * 0.5, a * a);
    let r = steep.select(s.sqrt(), a);
    let small = r + r * s * polynomial(s, ASIN);
    steep.select(R::splat(FRAC_PI_2) - small * 2.0, small).copysign(x)
}

/// `acos x` for `x` in `[-1, 1]`, within 4e-7. Other arguments are clamped.
#[inline(always)]
pub(crate) fn acos<R: Real>(x: R) -> R {
    R::splat(FRAC_PI_2) - asin(x)
}

/// Angle of the point (x, y) in `[-π, π]`, within 4e-7; 0 for the origin.
#[inline(always)]
pub(crate) fn atan2<R: Real>(y: R, x: R) -> R {
    let (ax, ay) = (x.abs(), y.abs());
    let upright = ax.lt(ay);
    let (lo, hi) = (upright.select(ax, ay), upright.select(ay, ax));
    let t = hi.gt(R::ZERO).select(lo / hi, R::ZERO);
    // Beyond tan π/8: atan t = π/4 + atan (t − 1)/(t + 1).
    let steep = t.gt(R::splat(TAN_PI_8));
    let r = steep.select((t - R::ONE) / (t + R::ONE), t);
    let s = r * r;
    let small = r + r * s * polynomial(s, ATAN);
    let octant = steep.select(small + FRAC_PI_4, small);
    let quadrant = upright.select(R::splat(FRAC_PI_2) - octant, octant);
    x.lt(R::ZERO).select(R::splat(PI) - quadrant, quadrant).copysign(y)
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // the reference is libm in f64
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn sin_cos_turns_holds_its_bound_on_every_random_number() {
        let mut worst = 0.0f64;
        for i in 0..1u32 << 24 {
            let u = i as f32 * (1.0 / 16_777_216.0);
            let (sin, cos) = sin_cos_turns(u);
            let (want_sin, want_cos) = (TAU * f64::from(u)).sin_cos();
            worst = worst.max((f64::from(sin) - want_sin).abs());
            worst = worst.max((f64::from(cos) - want_cos).abs());
        }
        assert!(worst < 1.1e-7, "worst error {worst:e}");
    }

    #[test]
    fn sin_cos_holds_its_bound() {
        for i in -400_000..=400_000 {
            let x = i as f32 * (4.0 * PI / 400_000.0);
            let bound = 1.1e-7 + 1.2e-7 * f64::from(x.abs());
            let (sin, cos) = sin_cos(x);
            assert!((f64::from(sin) - f64::from(x).sin()).abs() < bound, "sin {x}");
            assert!((f64::from(cos) - f64::from(x).cos()).abs() < bound, "cos {x}");
        }
    }

    #[test]
    fn inverse_functions_hold_their_bounds() {
        for i in -1_000_000..=1_000_000 {
            let x = i as f32 * 1e-6;
            let want = f64::from(x).asin();
            assert!((f64::from(asin(x)) - want).abs() <= 3.6e-7 * want.abs(), "asin {x}");
            assert!((f64::from(acos(x)) - f64::from(x).acos()).abs() < 4e-7, "acos {x}");
            let (sin, cos) = (TAU * f64::from(i) / 2e6).sin_cos();
            for radius in [1e-20, 1.0, 1e20] {
                let (y, x) = ((radius * sin) as f32, (radius * cos) as f32);
                let error = f64::from(atan2(y, x)) - f64::from(y).atan2(f64::from(x));
                assert!(error.abs() < 4e-7, "atan2 {y} {x}: {error:e}");
            }
        }
        assert_eq!(asin(1.5), FRAC_PI_2);
        assert_eq!(acos(-7.0), PI);
        assert_eq!(atan2(0.0, 0.0), 0.0);
    }
}
