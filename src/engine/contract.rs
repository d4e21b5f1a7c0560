//! What decides bits, and so is the same in every engine.

use glam::Vec3;

use crate::math::{Real, max_element};

/// The version of the arithmetic: another one where any image has other bits than before.
pub const BITS: u32 = 1;

/// First segment that a path reaches only by Russian roulette.
pub(super) const ROULETTE_FROM: u32 = 5;
/// Largest chance of surviving it.
pub(super) const ROULETTE_MAX: f32 = 0.95;

/// The part of the way to a light that has to be free, as in pbrt (Pharr et al. 2023, 6.8.6).
///
/// In the last 10⁻⁴ lie the light itself, with what rounding does to its distance in this or another
/// program (but for grazing rays and silhouettes), and surfaces that are flush with it.
pub(super) const SHADOW_REACH: f32 = 1.0 - 1e-4;

/// Weight of a sample that was drawn with density `of` where `other` could have drawn it too
/// (Veach 1997, section 9.2.4, exponent 2), written so that no square overflows.
#[inline(always)]
pub(super) fn power_heuristic<R: Real>(of: R, other: R) -> R {
    let ratio = other / of;
    R::ONE / (R::ONE + ratio * ratio)
}

/// The radiance that a sample adds to its pixel, and whether it was clamped: scaled down so that its
/// largest component is `clamp`. `None` if it is not finite.
#[inline]
pub(super) fn counted(radiance: Vec3, clamp: f32) -> Option<(Vec3, bool)> {
    if !radiance.is_finite() {
        return None;
    }
    let most = max_element(radiance);
    Some(if most > clamp { (radiance * (clamp / most), true) } else { (radiance, false) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_clamped_as_a_whole() {
        let v = Vec3::new;
        assert_eq!(counted(v(1.0, 8.0, 4.0), 2.0), Some((v(0.25, 2.0, 1.0), true)));
        assert_eq!(counted(v(1.0, 2.0, 0.0), 2.0), Some((v(1.0, 2.0, 0.0), false)));
        assert_eq!(counted(v(1.0, 2e30, 0.0), f32::INFINITY), Some((v(1.0, 2e30, 0.0), false)));
        assert_eq!(counted(v(1.0, f32::NAN, 0.0), 2.0), None);
        assert_eq!(counted(v(f32::INFINITY, 1.0, 0.0), f32::INFINITY), None);
    }
}
