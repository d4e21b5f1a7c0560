//! What decides bits, and so is the same in every engine.

use glam::Vec3;

use crate::math::max_element;

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

/// Rectangles are sampled by solid angle above this: below it the sum of the corners' angles has lost
/// too many digits.
pub(super) const MIN_SOLID_ANGLE: f32 = 1e-3;
/// And above this sine of the angle under which the farthest corner is seen above the rectangle's
/// plane: below it the map from angles to places has lost too many digits.
pub(super) const MIN_SINE: f32 = 2.5e-3;

/// Least fuzz of metal whose density is known: below it, rounding has the better part of the distance from
/// the mirror direction. No light sample would find so narrow a blur.
pub(super) const LEAST_BLUR: f32 = 1e-4;

/// What of a sample's radiance is added to its pixel: none where it is not finite; no component above
/// `clamp`, to which the whole is scaled down. Tells whether it was.
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
