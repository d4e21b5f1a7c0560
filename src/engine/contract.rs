//! Constants and formulas that determine the image bit by bit, shared by all engines.

use glam::Vec3;

use crate::math::{Mask, Real, Vector, max_element};
use crate::scene::Sampling;
use crate::shading::material::SPECULAR;

/// Version of the arithmetic. It changes whenever a new release alters the bits of any image.
pub const BITS: u32 = 6;

/// Fraction of the distance to a light that must be unoccluded, as in pbrt (Pharr et al. 2023,
/// 6.8.6).
///
/// The last 10⁻⁴ is left out so that neither the light itself nor a surface flush with it occludes
/// the light, whatever the rounding errors of the distance in this or another program. Grazing rays
/// and silhouettes are exceptions.
pub(super) const SHADOW_REACH: f32 = 1.0 - 1e-4;

/// Power heuristic: the weight of a sample that was drawn with density `of`, and that another
/// strategy draws with density `other` (Veach 1997, section 9.2.4, exponent 2). Squaring the ratio
/// instead of the densities avoids overflow.
#[inline(always)]
pub(super) fn power_heuristic<R: Real>(of: R, other: R) -> R {
    let ratio = other / of;
    R::ONE / (R::ONE + ratio * ratio)
}

/// The weight of emitted light that a path has found by scattering in a direction of density `pdf`.
/// Light samples find the same light with the density `light_pdf`, and contribute the rest.
#[inline(always)]
pub(super) fn emission_weight<R: Real>(
    sampling: Sampling,
    pdf: R,
    light_pdf: impl FnOnce() -> R,
) -> R {
    let shared = match sampling {
        Sampling::Bsdf => return R::ONE,
        Sampling::Light => R::ZERO,
        Sampling::Mis => power_heuristic(pdf, light_pdf()),
    };
    pdf.eq(R::splat(SPECULAR)).select(R::ONE, shared)
}

/// Returns the radiance that a sample adds to its pixel, and whether it was clamped, that is,
/// scaled down so that the magnitude of its largest component is `clamp`. Returns `None` if the radiance is not
/// finite.
#[inline]
pub(super) fn counted(radiance: Vec3, clamp: f32) -> Option<(Vec3, bool)> {
    scale(radiance, clamp).map(|scale| match scale {
        1.0 => (radiance, false),
        scale => (radiance * scale, true),
    })
}

/// The factor of a sample in [`counted`].
#[inline]
pub(super) fn scale(radiance: Vec3, clamp: f32) -> Option<f32> {
    if !radiance.is_finite() {
        return None;
    }
    // Samples are negative where the pixel filter is.
    let most = max_element(Vector::abs(radiance));
    Some(if most > clamp { clamp / most } else { 1.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_clamped_as_a_whole() {
        let v = Vec3::new;
        assert_eq!(counted(v(1.0, 8.0, 4.0), 2.0), Some((v(0.25, 2.0, 1.0), true)));
        assert_eq!(counted(v(-1.0, -8.0, -4.0), 2.0), Some((v(-0.25, -2.0, -1.0), true)));
        assert_eq!(counted(v(1.0, 2.0, 0.0), 2.0), Some((v(1.0, 2.0, 0.0), false)));
        assert_eq!(counted(v(1.0, 2e30, 0.0), f32::INFINITY), Some((v(1.0, 2e30, 0.0), false)));
        assert_eq!(counted(v(1.0, f32::NAN, 0.0), 2.0), None);
        assert_eq!(counted(v(f32::INFINITY, 1.0, 0.0), f32::INFINITY), None);
    }
}
