//! Powers over lanes: [`crate::math::powers`] to the bit.

use super::{Float, Int};
use crate::math::powers::CBRT_START;

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
            let roots = cbrt(Float::new(u)).to_array();
            for (root, u) in roots.into_iter().zip(u) {
                assert_eq!(root.to_bits(), powers::cbrt(u).to_bits(), "{u}");
            }
        }
    }
}
