//! Cube root, logarithm and exponential in contract arithmetic.
//!
//! As in [`super::trig`], each function states its error bound against f64, and a test checks it.

use super::polynomial;
use super::real::{Mask, Real, Word};

/// Bits of √½: the logarithm reduces its argument to `[√½, √2)`.
const SQRT_HALF: u32 = 0x3F35_04F3;
/// Bits of 1.
const ONE: u32 = 0x3F80_0000;
/// ln 2 as a sum of two parts. The first has enough zero bits to make its product with an exponent
/// exact.
const LN_2: (f32, f32) = (0.693_145_75, 1.428_606_8e-6);

/// Cube root of `x` within a relative error of 2.3e-7. `x` must be a multiple of 2^-24 in `[0, 1]`.
#[inline(always)]
pub(crate) fn cbrt<R: Real>(x: R) -> R {
    // The bits of a float approximate its logarithm, so a third of their value gives a cube root
    // with an error of 3.3%. Each step of Halley's method cubes the error.
    let third = (x.to_bits() >> 16).wrapping_mul(R::Word::splat(0x5556));
    let mut y = R::from_bits(third.wrapping_add(R::Word::splat(0x2A51_0000)));
    for _ in 0..2 {
        let cube = y * y * y;
        y = y * ((cube + x + x) / (cube + cube + x));
    }
    x.gt(R::ZERO).select(y, R::ZERO)
}

/// Natural logarithm of `x` in `[2^-24, 2^100]`, within a relative error of 2.1e-7.
#[inline(always)]
pub(crate) fn ln<R: Real>(x: R) -> R {
    // x = m 2^e with m in [√½, √2).
    let (bits, one) = (x.to_bits(), R::Word::splat(ONE));
    let biased = bits.wrapping_sub(R::Word::splat(SQRT_HALF)).wrapping_add(one) >> 23;
    let m = R::from_bits(bits.wrapping_add(one).wrapping_sub(biased << 23));
    let e = R::from_word(biased) - 127.0;
    let s = (m - R::ONE) / (m + R::ONE);
    let t = s * s;
    // The series of ln((1 + s)/(1 − s)) in s² has the coefficients 2/(2k + 1).
    let small = s * polynomial(t, [2.0, 2.0 / 3.0, 2.0 / 5.0, 2.0 / 7.0, 2.0 / 9.0]);
    e * LN_2.0 + (small + e * LN_2.1)
}

/// e^x for `x` in `[-87, 0]`, within a relative error of 2.6e-7; 0 for `x` below -87.
#[inline(always)]
pub(crate) fn exp<R: Real>(x: R) -> R {
    // x = n ln 2 + r. Adding 1.5·2^23 rounds to an integer and leaves it in the lowest bits.
    const MAGIC: f32 = 12_582_912.0;
    let shifted = x * std::f32::consts::LOG2_E + MAGIC;
    let n = shifted - MAGIC;
    let r = (x - n * LN_2.0) - n * LN_2.1;
    // The coefficients are 1/k!.
    let series = [1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0];
    let small = polynomial(r, series);
    let scale = R::from_bits((shifted.to_bits() << 23).wrapping_add(R::Word::splat(ONE)));
    x.lt(R::splat(-87.0)).select(R::ZERO, small * scale)
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // the reference is libm in f64
mod tests {
    use super::*;

    /// Checks all multiples of 2^-24 in `(0, 1]`, hence every nonzero random number.
    #[test]
    fn roots_and_logarithms_hold_their_bounds() {
        let (mut root, mut logarithm) = (0.0f64, 0.0f64);
        for i in 1..=1u32 << 24 {
            let x = i as f32 * (1.0 / 16_777_216.0);
            let want = f64::from(x).cbrt();
            root = root.max((f64::from(cbrt(x)) - want).abs() / want);
            let want = f64::from(x).ln();
            let error = (f64::from(ln(x)) - want).abs();
            logarithm = logarithm.max(if x == 1.0 { error } else { error / -want });
        }
        assert!(root < 2.3e-7, "{root:e}");
        for step in 1..3200 {
            let x = f32::from_bits(ONE + step * 0x0003_FFF1);
            let want = f64::from(x).ln();
            logarithm = logarithm.max((f64::from(ln(x)) - want).abs() / want);
        }
        assert!(logarithm < 2.1e-7, "{logarithm:e}");
        assert_eq!((cbrt(0.0), ln(1.0)), (0.0, 0.0));
    }

    #[test]
    fn exponentials_hold_their_bound() {
        let mut worst = 0.0f64;
        for i in 0..=8_700_000u32 {
            let x = i as f32 * -1e-5;
            let want = f64::from(x).exp();
            worst = worst.max((f64::from(exp(x)) - want).abs() / want);
        }
        assert!(worst < 2.6e-7, "{worst:e}");
        assert_eq!([0.0, -0.0, -88.0, f32::NEG_INFINITY].map(exp), [1.0, 1.0, 0.0, 0.0]);
    }
}
