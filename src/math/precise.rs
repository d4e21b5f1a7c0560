//! f64 functions for values that are computed once per scene and rounded once to f32.
//!
//! Such values are the camera frame, pixel filters, rotations, transfer curves and tone maps. The
//! functions use only `+ - * / %`, `round` and operations on bits, so every platform agrees.

use std::f64::consts::{LN_2, LOG2_E, PI};

use glam::DVec3;

/// `(sin, cos)` of an angle in degrees, within 4 ulp of f64; exact at multiples of 90°.
///
/// Accepts |degrees| up to 1e9. The reduction to `[-45°, 45°]` is exact.
pub(crate) fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    let turn = degrees % 360.0; // exact, like fmod
    let quadrant = (turn / 90.0).round();
    let x = (turn - 90.0 * quadrant) * (PI / 180.0);
    let s = x * x;
    // Taylor series: |x| < 0.79, so the first omitted term is below 1e-18.
    let mut sin = 1.0;
    let mut cos = 1.0;
    for k in (1..=9).rev() {
        let k = f64::from(k);
        sin = 1.0 - sin * s / ((2.0 * k) * (2.0 * k + 1.0));
        cos = 1.0 - cos * s / ((2.0 * k - 1.0) * (2.0 * k));
    }
    sin *= x;
    match quadrant as i64 & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// The sine and cosine of each angle, in degrees, for [`rotate`].
pub(crate) fn turns(degrees: [f32; 3]) -> [(f64, f64); 3] {
    degrees.map(|degrees| sin_cos_degrees(f64::from(degrees)))
}

/// Rotates `point` about the axes x, y and z in this order, given the sine and cosine of each
/// angle. The rotations are right-handed.
pub(crate) fn rotate(mut point: [f64; 3], turns: [(f64, f64); 3]) -> [f64; 3] {
    for (axis, (sin, cos)) in turns.into_iter().enumerate() {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        (point[i], point[j]) = (cos * point[i] - sin * point[j], sin * point[i] + cos * point[j]);
    }
    point
}

/// 1 − cos of an angle in degrees, without the cancellation for small angles.
pub(crate) fn one_minus_cos(degrees: f64) -> f64 {
    let (sin, _) = sin_cos_degrees(degrees * 0.5);
    2.0 * sin * sin
}

/// `v` with length 1; not finite for the zero vector.
pub(crate) fn unit(v: DVec3) -> DVec3 {
    v / v.dot(v).sqrt()
}

/// Tangent of an angle in degrees, in `(-90, 90)`.
pub(crate) fn tan_degrees(degrees: f64) -> f64 {
    let (sin, cos) = sin_cos_degrees(degrees);
    sin / cos
}

/// `x` to the power 12/5 for `x` in `[0, 2]`. This is the exponent 2.4 of sRGB, computed without
/// `pow`.
pub(crate) fn pow_12_5(x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    // Newton's method for the fifth root, which decreases monotonically from a start above it.
    let mut root = 1.2f64;
    for _ in 0..200 {
        let square = root * root;
        root = (4.0 * root + x / (square * square)) / 5.0;
    }
    x * x * (root * root)
}

/// Cube root of `x` ≥ 0, within 2 ulp of f64.
pub(crate) fn cbrt(x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    // Newton's method decreases monotonically from a start above the root, by a factor of 3/2 per
    // step while it is far away.
    let mut root = if x > 1.0 { x } else { 1.0 };
    loop {
        let next = (2.0 * root + x / (root * root)) / 3.0;
        if !(next < root) {
            return root;
        }
        root = next;
    }
}

/// 2 to the power `x` for `x` up to 1023, within a relative error of 1e-15; 0 for `x` below −1022.
pub(crate) fn exp2(x: f64) -> f64 {
    if x < -1022.0 {
        return 0.0;
    }
    let whole = x.round();
    let r = (x - whole) * LN_2;
    // Taylor series: |r| < 0.35, so the first omitted term is below 2e-19.
    let mut sum = 1.0;
    for k in (1..=14).rev() {
        sum = 1.0 + sum * r / f64::from(k);
    }
    sum * f64::from_bits(((whole as i64 + 1023) as u64) << 52)
}

/// e to the power `x` for `x` up to 700, within a relative error of (5 + |x|)·2e-16.
pub(crate) fn exp(x: f64) -> f64 {
    exp2(x * LOG2_E)
}

/// Logarithm of `x` to base 2, within an absolute error of (1 + |log2 x|)·1e-15. `x` must be a
/// normal number above 0.
pub(crate) fn log2(x: f64) -> f64 {
    const SQRT_HALF: u64 = std::f64::consts::FRAC_1_SQRT_2.to_bits();
    // x = m 2^e with m in [√½, √2).
    let biased = (x.to_bits() + 1f64.to_bits() - SQRT_HALF) >> 52;
    let m = f64::from_bits(x.to_bits() + 1f64.to_bits() - (biased << 52));
    let s = (m - 1.0) / (m + 1.0);
    // The series of ln((1 + s)/(1 − s)): |s| < 0.172, so the first omitted term is below 1e-19.
    let mut sum = 0.0;
    for k in (0..12).rev() {
        sum = sum * (s * s) + 2.0 / (2.0 * f64::from(k) + 1.0);
    }
    biased as f64 - 1023.0 + s * sum * LOG2_E
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // the reference is libm in f64
mod tests {
    use super::*;

    #[test]
    fn degrees_agree_with_libm_and_are_exact_at_right_angles() {
        for i in -72_000..=72_000 {
            let degrees = f64::from(i) * 0.01;
            let (sin, cos) = sin_cos_degrees(degrees);
            assert!((sin - degrees.to_radians().sin()).abs() < 4e-15, "sin {degrees}");
            assert!((cos - degrees.to_radians().cos()).abs() < 4e-15, "cos {degrees}");
        }
        assert_eq!(sin_cos_degrees(90.0), (1.0, 0.0));
        assert_eq!(sin_cos_degrees(-180.0).1, -1.0);
        assert!((tan_degrees(45.0) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn cbrt_agrees_with_libm() {
        for x in [0.0, 1e-300, 1e-6, 0.001, 0.5, 1.0, 8.0, 27.0, 1e6, 16.777216, 1e300] {
            assert!((cbrt(x) - x.cbrt()).abs() <= 1e-15 * x.cbrt(), "{x}");
        }
    }

    #[test]
    fn powers_and_logarithms_agree_with_libm() {
        for i in -100_000..=100_000 {
            let x = f64::from(i) * 0.007;
            let error = (exp2(x) - x.exp2()).abs() / x.exp2();
            assert!(error <= 1e-15, "exp2({x}): {error}");
            let error = (exp(x) - x.exp()).abs() / x.exp();
            assert!(error <= (5.0 + x.abs()) * 2e-16, "exp({x}): {error}");
            let error = (log2(x.exp2()) - x.exp2().log2()).abs();
            assert!(error <= (1.0 + x.abs()) * 1e-15, "log2(2^{x}): {error}");
            let y = 1.0 + f64::from(i) * 9e-6;
            assert!((log2(y) - y.log2()).abs() <= (1.0 + y.log2().abs()) * 1e-15, "log2({y})");
        }
        assert_eq!((exp2(0.0), exp2(-1.0), exp2(10.0), exp2(-2000.0)), (1.0, 0.5, 1024.0, 0.0));
        assert_eq!((log2(1.0), log2(0.25), log2(8.0)), (0.0, -2.0, 3.0));
    }

    #[test]
    fn pow_12_5_agrees_with_libm() {
        for i in 0..=1000 {
            let x = f64::from(i) / 500.0;
            let want = x.powf(2.4);
            assert!((pow_12_5(x) - want).abs() <= 1e-14 * want, "{x}");
        }
    }
}
