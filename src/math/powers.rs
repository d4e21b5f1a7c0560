//! Powers in contract arithmetic.
//!
//! As in [`super::trig`], each function states its error against f64, and a test holds it.

/// What a third of a float's bits is added to, to begin a cube root.
pub(crate) const CBRT_START: u32 = 0x2A51_0000;

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

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // libm's f64 is the yardstick
mod tests {
    use super::*;

    /// Every random number there is.
    #[test]
    fn roots_hold_their_bound() {
        let mut worst = 0.0f64;
        for i in 1..=1u32 << 24 {
            let x = i as f32 * (1.0 / 16_777_216.0);
            let want = f64::from(x).cbrt();
            worst = worst.max((f64::from(cbrt(x)) - want).abs() / want);
        }
        assert!(worst < 2.3e-7, "{worst:e}");
        assert_eq!(cbrt(0.0), 0.0);
    }
}
