//! Contract arithmetic: the only functions that may compute values that an image depends on.
//!
//! Everything here consists of IEEE-754 `+ - * / sqrt`, comparisons, selects and integer operations
//! in one fixed order, so that each function returns the same bits on every instruction set and
//! thread count. See ARCHITECTURE.md, "The contract".

pub(crate) mod affine;
pub(crate) mod fresnel;
pub(crate) mod microfacet;
pub(crate) mod powers;
pub(crate) mod precise;
pub(crate) mod random;
pub(crate) mod real;
mod scalar;
pub(crate) mod sobol;
pub(crate) mod trig;
pub(crate) mod vector;
pub(crate) mod warp;

pub use random::Stream;
pub(crate) use random::{PathKey, PixelKey, mix32};
pub(crate) use real::{Mask, Real, Row, Select, Vector, Word, row};
pub(crate) use trig::{acos, atan2, sin_cos, sin_cos_turns};
pub(crate) use vector::{Frame, face_forward, max_element, reflect};
pub use vector::{cross, dot, length, normalize};

/// `if a < b { a } else { b }`, as `minps` computes it: a NaN in either argument gives `b`.
#[inline(always)]
pub fn min<R: Real>(a: R, b: R) -> R {
    a.least(b)
}

/// `if a > b { a } else { b }`, as `maxps` computes it: a NaN in either argument gives `b`.
#[inline(always)]
pub(crate) fn max<R: Real>(a: R, b: R) -> R {
    a.most(b)
}

/// `x` limited to `[lo, hi]`; NaN gives `lo`.
#[inline(always)]
pub(crate) fn clamp<R: Real>(x: R, lo: R, hi: R) -> R {
    min(max(x, lo), hi)
}

/// The integer part of `x`, which is in [0, 2^23).
#[inline(always)]
pub(crate) fn whole<R: Real>(x: R) -> R::Word {
    // In [2^23, 2^24), the lowest bits of a number are those of an integer.
    const FIRST: f32 = 8_388_608.0;
    (x.floor() + FIRST).to_bits() & R::Word::splat(0x7F_FFFF)
}

/// `a[0] + x (a[1] + x (a[2] + …))`.
#[inline(always)]
fn polynomial<R: Real, const N: usize>(x: R, a: [f32; N]) -> R {
    let mut sum = R::splat(a[N - 1]);
    for coefficient in a.iter().rev().skip(1) {
        sum = x * sum + *coefficient;
    }
    sum
}

/// Unit roundoff of f32, 2^-24: the relative error of one rounded operation.
pub(crate) const UNIT_ROUNDOFF: f32 = f32::EPSILON / 2.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_parts_are_exact() {
        for x in [0.0f32, 0.99, 1.0, 77.5, 4096.999, 8_388_606.5, 8_388_607.0] {
            assert_eq!(whole(x), x as u32);
        }
    }

    #[test]
    fn min_and_max_take_the_second_argument_on_nan() {
        assert_eq!(min(f32::NAN, 1.0), 1.0);
        assert!(min(1.0, f32::NAN).is_nan());
        assert_eq!(max(f32::NAN, 1.0), 1.0);
        assert!(max(1.0, f32::NAN).is_nan());
        assert_eq!(clamp(f32::NAN, 2.0, 3.0), 2.0);
        assert_eq!(clamp(9.0, 2.0, 3.0), 3.0);
    }
}
