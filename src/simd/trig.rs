//! Sine, cosine and angles over lanes: [`crate::math::trig`] to the bit.

use super::{Float, Int};
use crate::math::trig::{ATAN, COS, SIN, TAN_PI_8};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

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

/// [`sin_cos`](crate::math::trig::sin_cos): `(sin x, cos x)` for `x` in `[-4π, 4π]`.
#[inline(always)]
pub(crate) fn sin_cos(x: Float) -> (Float, Float) {
    sin_cos_turns(x * Float::splat(1.0 / (2.0 * PI)))
}

/// [`atan2`](crate::math::trig::atan2): the angle of the point (x, y).
#[inline(always)]
pub(crate) fn atan2(y: Float, x: Float) -> Float {
    let number = Float::splat;
    let one = number(1.0);
    let (ax, ay) = (x.abs(), y.abs());
    let upright = ax.lt(ay);
    let (lo, hi) = (upright.select(ax, ay), upright.select(ay, ax));
    let t = hi.gt(Float::ZERO).select(lo / hi, Float::ZERO);
    let steep = t.gt(number(TAN_PI_8));
    let r = steep.select((t - one) / (t + one), t);
    let s = r * r;
    let a = ATAN.map(number);
    let small = r + r * s * (a[0] + s * (a[1] + s * (a[2] + s * (a[3] + s * a[4]))));
    let octant = steep.select(number(FRAC_PI_4) + small, small);
    let quadrant = upright.select(number(FRAC_PI_2) - octant, octant);
    x.lt(Float::ZERO).select(number(PI) - quadrant, quadrant).copysign(y)
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

    #[test]
    fn angles_are_the_scalar_functions() {
        const SPECIAL: [f32; 6] = [0.0, -0.0, 1.0, -1.0, 1e-30, f32::INFINITY];
        let mut random = Stream::new(6);
        let mut number = || match random.bits() % 4 {
            0 => SPECIAL[(random.bits() % 6) as usize],
            _ => random.between(-3.0, 3.0),
        };
        for _ in 0..100_000 {
            let (y, x): (Lanes, Lanes) =
                (std::array::from_fn(|_| number()), std::array::from_fn(|_| number()));
            let angles = atan2(Float::new(y), Float::new(x)).to_array();
            let (sin, cos) = sin_cos(Float::new(x));
            for lane in 0..crate::simd::LANES {
                let want = trig::atan2(y[lane], x[lane]);
                let same = angles[lane].to_bits() == want.to_bits();
                assert!(
                    same || (angles[lane].is_nan() && want.is_nan()),
                    "{} {}",
                    y[lane],
                    x[lane]
                );
                if x[lane].is_finite() {
                    let (s, c) = trig::sin_cos(x[lane]);
                    let found = (sin.to_array()[lane].to_bits(), cos.to_array()[lane].to_bits());
                    assert_eq!(found, (s.to_bits(), c.to_bits()), "{}", x[lane]);
                }
            }
        }
    }
}
