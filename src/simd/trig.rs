//! Sine and cosine over lanes: [`crate::math::trig`] to the bit.

use super::{Float, Int};
use crate::math::trig::{COS, SIN};

/// [`sin_cos_turns`](crate::math::trig::sin_cos_turns): `(sin 2πu, cos 2πu)` for `u` in `[-2, 2]`.
#[inline(always)]
pub(crate) fn sin_cos_turns(u: Float) -> (Float, Float) {
    let number = Float::splat;
    // 1.5 · 2²³: the sum is rounded to an integer, which is in its last bits.
    let magic = number(12_582_912.0);
    let shifted = number(4.0) * u + magic;
    let quadrant = shifted - magic;
    let r = u - number(0.25) * quadrant;
    let s = r * r;
    let (a, b) = (SIN.map(number), COS.map(number));
    let sin = r * (a[0] + s * (a[1] + s * (a[2] + s * (a[3] + s * a[4]))));
    let cos = number(1.0) + s * (b[0] + s * (b[1] + s * (b[2] + s * b[3])));
    // Quadrants 1 and 3 swap them; sines are negative in 2 and 3, cosines in 1 and 2.
    let bits = shifted.to_bits();
    let swapped = (bits & Int::splat(1)).eq(Int::splat(1));
    let (odd, upper) = (bits.shifted_up(31), bits.shifted_down(1).shifted_up(31));
    let with_sign = |value: Float, sign: Int| Float::from_bits(value.to_bits() ^ sign);
    (with_sign(swapped.select(cos, sin), upper), with_sign(swapped.select(sin, cos), upper ^ odd))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::Stream;
    use crate::math::trig;
    use crate::simd::Lanes;

    #[test]
    fn lanes_are_the_scalar_functions() {
        let mut random = Stream::new(4);
        for _ in 0..100_000 {
            // Anywhere, and about the borders of quadrants.
            let u: Lanes = std::array::from_fn(|_| match random.bits() % 4 {
                0 => ((random.bits() % 33) as f32 - 16.0) / 8.0,
                1 => ((random.bits() % 33) as f32 - 16.0) / 8.0 + random.between(-1e-6, 1e-6),
                _ => random.between(-2.0, 2.0),
            });
            let (sin, cos) = sin_cos_turns(Float::new(u));
            for (lane, &u) in u.iter().enumerate() {
                let (s, c) = trig::sin_cos_turns(u);
                let found = (sin.to_array()[lane].to_bits(), cos.to_array()[lane].to_bits());
                assert_eq!(found, (s.to_bits(), c.to_bits()), "{u}");
            }
        }
    }
}
