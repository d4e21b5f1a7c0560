//! Cube root, logarithm and exponential in contract arithmetic.
//!
//! As in [`super::trig`], each function states its error against f64, and a test holds it.

/// What a third of a float's bits is added to, to begin a cube root.
pub(crate) const CBRT_START: u32 = 0x2A51_0000;

/// Bits of √½, where the logarithm changes to the next power of two, and of 1.
pub(crate) const SQRT_HALF: u32 = 0x3F35_04F3;
pub(crate) const ONE: u32 = 0x3F80_0000;
/// ln 2 as a sum, whose first part has bits to spare for a product with an exponent.
pub(crate) const LN_2: (f32, f32) = (0.693_145_75, 1.428_606_8e-6);
/// 2/(2k + 1): the series of ln((1 + s)/(1 − s)) in s².
pub(crate) const LN: [f32; 5] = [2.0, 2.0 / 3.0, 2.0 / 5.0, 2.0 / 7.0, 2.0 / 9.0];
/// 1/k!
pub(crate) const EXP: [f32; 7] =
    [1.0, 1.0, 1.0 / 2.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0];
/// Where e^x is no longer told from 0.
pub(crate) const EXP_LEAST: f32 = -87.0;

/// Cube root of `x` in `[0, 1]`, a multiple of 2^-24, within 2.3e-7 relative.
#[inline]
pub fn cbrt(x: f32) -> f32 {
    // The bits of a float are about its logarithm, of which a third is taken: 3.3% off. Each of
    // Halley's steps cubes the error.
    let start = f32::from_bits((x.to_bits() >> 16) * 0x5556 + CBRT_START);
    let step = |y: f32| {
        let cube = y * y * y;
        y * ((cube + x + x) / (cube + cube + x))
    };
    if x > 0.0 { step(step(start)) } else { 0.0 }
}

/// Natural logarithm of `x` in `[2^-24, 1]`, within 2.1e-7 relative.
#[inline]
pub fn ln(x: f32) -> f32 {
    // x = m 2^e with m in [√½, √2).
    let bits = x.to_bits();
    let biased = bits.wrapping_sub(SQRT_HALF).wrapping_add(ONE) >> 23;
    let m = f32::from_bits(bits.wrapping_add(ONE).wrapping_sub(biased << 23));
    let e = biased as f32 - 127.0;
    let s = (m - 1.0) / (m + 1.0);
    let t = s * s;
    let small = s * (LN[0] + t * (LN[1] + t * (LN[2] + t * (LN[3] + t * LN[4]))));
    e * LN_2.0 + (small + e * LN_2.1)
}

/// e^x for `x` in `[-87, 0]`, within 2.6e-7 relative; 0 below.
#[inline]
pub fn exp(x: f32) -> f32 {
    // x = n ln 2 + r; 1.5·2^23 rounds to an integer, which is in its last bits.
    let shifted = x * std::f32::consts::LOG2_E + 12_582_912.0;
    let n = shifted - 12_582_912.0;
    let r = (x - n * LN_2.0) - n * LN_2.1;
    let [a, b, c, d, e, f, g] = EXP;
    let small = a + r * (b + r * (c + r * (d + r * (e + r * (f + r * g)))));
    let scale = f32::from_bits((shifted.to_bits() << 23).wrapping_add(ONE));
    if x < EXP_LEAST { 0.0 } else { small * scale }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // libm's f64 is the yardstick
mod tests {
    use super::*;

    /// Every random number there is.
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
