//! Cube root, logarithm and exponential over lanes: [`crate::math::powers`] to the bit.

use super::{Float, Int};
use crate::math::powers::{CBRT_START, EXP, EXP_LEAST, LN, LN_2, ONE, SQRT_HALF};

/// [`cbrt`](crate::math::powers::cbrt).
#[inline(always)]
pub(crate) fn cbrt(x: Float) -> Float {
    let third = x.to_bits().shifted_down(16) * Int::splat(0x5556);
    let mut y = Float::from_bits(third + Int::splat(CBRT_START));
    for _ in 0..2 {
        let cube = y * y * y;
        y = y * ((cube + x + x) / (cube + cube + x));
    }
    x.gt(Float::ZERO).select(y, Float::ZERO)
}

/// [`ln`](crate::math::powers::ln).
#[inline(always)]
pub(crate) fn ln(x: Float) -> Float {
    let (one, bits) = (Float::splat(1.0), x.to_bits());
    let biased = (bits - Int::splat(SQRT_HALF) + Int::splat(ONE)).shifted_down(23);
    let m = Float::from_bits(bits + Int::splat(ONE) - biased.shifted_up(23));
    let e = biased.to_float() - Float::splat(127.0);
    let s = (m - one) / (m + one);
    let t = s * s;
    let [a, b, c, d, f] = LN.map(Float::splat);
    let small = s * (a + t * (b + t * (c + t * (d + t * f))));
    e * Float::splat(LN_2.0) + (small + e * Float::splat(LN_2.1))
}

/// [`exp`](crate::math::powers::exp).
#[inline(always)]
pub(crate) fn exp(x: Float) -> Float {
    let magic = Float::splat(12_582_912.0);
    let shifted = x * Float::splat(std::f32::consts::LOG2_E) + magic;
    let n = shifted - magic;
    let r = (x - n * Float::splat(LN_2.0)) - n * Float::splat(LN_2.1);
    let [a, b, c, d, e, f, g] = EXP.map(Float::splat);
    let small = a + r * (b + r * (c + r * (d + r * (e + r * (f + r * g)))));
    let scale = Float::from_bits(shifted.to_bits().shifted_up(23) + Int::splat(ONE));
    x.lt(Float::splat(EXP_LEAST)).select(Float::ZERO, small * scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::powers;
    use crate::math::random::Stream;
    use crate::simd::Lanes;

    #[test]
    fn lanes_are_the_scalar_functions() {
        let mut random = Stream::new(11);
        for _ in 0..100_000 {
            let u: Lanes = std::array::from_fn(|_| match random.bits() % 8 {
                0 => [0.0, 1.0, 0.5, 1.0 / 16_777_216.0][(random.bits() % 4) as usize],
                _ => random.uniform(),
            });
            let x: Lanes = std::array::from_fn(|_| match random.bits() % 8 {
                0 => [0.0, -87.0, -87.1, f32::NEG_INFINITY][(random.bits() % 4) as usize],
                _ => random.between(-90.0, 0.0),
            });
            let at_least: Lanes = u.map(|u| crate::math::max(u, 1.0 / 16_777_216.0));
            let (roots, logarithms, exponentials) =
                (cbrt(Float::new(u)), ln(Float::new(at_least)), exp(Float::new(x)));
            for (lane, &u) in u.iter().enumerate() {
                let found = [roots, logarithms, exponentials].map(|v| v.to_array()[lane].to_bits());
                let want = [powers::cbrt(u), powers::ln(at_least[lane]), powers::exp(x[lane])];
                assert_eq!(found, want.map(f32::to_bits), "{u} {}", x[lane]);
            }
        }
    }
}
