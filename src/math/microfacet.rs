//! Microfacets of rough surfaces: the Trowbridge-Reitz (GGX) distribution with Smith's masking.
//!
//! The formulas are from Walter et al. 2007, "Microfacet Models for Refraction through Rough
//! Surfaces", and Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based
//! BRDFs".
//!
//! Directions are in the frame of the surface, with z along its normal, and point away from it.

use std::f32::consts::PI;

use super::real::Real;
use super::real::Vector;
use super::{max, normalize, sin_cos_turns};

/// GGX distribution of roughness α in `(0, 1]`. With α = 0 every sampled normal is the surface
/// normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ggx<R = f32> {
    /// The roughness α.
    pub alpha: R,
}

impl<R: Real> Ggx<R> {
    /// GGX density D of the microfacet normal `m`. It integrates to 1 over projected solid angle.
    #[inline(always)]
    pub(crate) fn density(self, m: R::Vec3) -> R {
        let a2 = self.alpha * self.alpha;
        // Equal to 1 + (α² − 1) z², without the cancellation.
        let d = (m[0] * m[0] + m[1] * m[1]) + a2 * (m[2] * m[2]);
        a2 / (R::splat(PI) * d * d)
    }

    /// Length of `w` after the stretch that turns the microfacets into those of a sphere. Smith's Λ
    /// is (length/|z| − 1)/2.
    #[inline(always)]
    pub(crate) fn length(self, w: R::Vec3) -> R {
        let a2 = self.alpha * self.alpha;
        (a2 * (w[0] * w[0] + w[1] * w[1]) + w[2] * w[2]).sqrt()
    }

    /// Share of the lower part of the sampled spherical cap that can reflect `wo` upwards (Eto
    /// and Tokuyoshi 2023, "Bounded VNDF Sampling for Smith-GGX Reflections"). With a share of 1,
    /// the whole cap is sampled.
    #[inline(always)]
    pub(crate) fn bound(self, wo: R::Vec3) -> R {
        let a2 = self.alpha * self.alpha;
        let s = R::ONE + (wo[0] * wo[0] + wo[1] * wo[1]).sqrt();
        let s2 = s * s;
        (R::ONE - a2) * s2 / (s2 + a2 * (wo[2] * wo[2]))
    }

    /// Samples a normal visible from `wo` with the density D(m) max(0, wo·m) 2/(`share` z +
    /// length), where z and the length are those of `wo`. The sample is uniform in a cap of the
    /// stretched sphere (Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical
    /// Caps").
    #[inline(always)]
    pub(crate) fn sample(self, wo: R::Vec3, share: R, u: R, v: R) -> R::Vec3 {
        let stretched =
            R::Vec3::new(self.alpha * wo[0], self.alpha * wo[1], wo[2]) / self.length(wo);
        let lowest = share * stretched[2];
        let z = (R::ONE - u) * (R::ONE + lowest) - lowest;
        let radius = max(R::ZERO, R::ONE - z * z).sqrt();
        let (sin, cos) = sin_cos_turns(v);
        let half = stretched + R::Vec3::new(radius * cos, radius * sin, z);
        normalize(R::Vec3::new(self.alpha * half[0], self.alpha * half[1], half[2]))
    }
}
