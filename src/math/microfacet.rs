//! Microfacets of rough surfaces: the Trowbridge-Reitz (GGX) distribution with Smith's masking.
//!
//! The formulas are from Walter et al. 2007, "Microfacet Models for Refraction through Rough
//! Surfaces", and Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based
//! BRDFs".
//!
//! Directions are in the frame of the surface, with z along its normal, and point away from it.

use std::f32::consts::PI;

use super::real::{Mask, Real, Vector};
use super::{max, normalize, sin_cos_turns};

/// GGX distribution of roughness α in `(0, 1]`. With α = 0 every sampled normal is the surface
/// normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ggx<R = f32> {
    /// The roughness α along x.
    pub alpha: R,
    /// The roughness along y divided by that along x.
    ratio: R,
}

impl<R: Real> Ggx<R> {
    /// The distribution of the roughness `alpha` in all directions. The compiler removes the factors of 1.
    #[inline(always)]
    pub(crate) fn new(alpha: R) -> Self {
        Self { alpha, ratio: R::ONE }
    }

    /// The distribution of the roughnesses `x` along x and `y` along y.
    #[inline(always)]
    pub(crate) fn anisotropic(x: R, y: R) -> Self {
        Self { alpha: x, ratio: y / x }
    }

    /// `self` in the lanes of `mask`, otherwise `other`.
    #[inline(always)]
    pub(crate) fn select(self, mask: R::Mask, other: Self) -> Self {
        Self {
            alpha: mask.select(self.alpha, other.alpha),
            ratio: mask.select(self.ratio, other.ratio),
        }
    }

    /// The mean of the roughnesses along x and y. At it, microfacets of one roughness lose about as much light, seen
    /// from all sides, and mostly less.
    #[inline(always)]
    pub(crate) fn mean_alpha(self) -> R {
        self.alpha * ((R::ONE + self.ratio) * 0.5)
    }

    /// GGX density D of the microfacet normal `m`. It integrates to 1 over projected solid angle.
    #[inline(always)]
    pub(crate) fn density(self, m: R::Vec3) -> R {
        // The product of the roughnesses.
        let a2 = self.alpha * self.alpha * self.ratio;
        // Where the roughnesses are equal, this is 1 + (α² − 1) z², without the cancellation.
        let d = (m[0] * m[0] * self.ratio + m[1] * m[1] / self.ratio) + a2 * (m[2] * m[2]);
        a2 / (R::splat(PI) * d * d)
    }

    /// Length of `w` after the stretch that turns the microfacets into those of a sphere. Smith's Λ
    /// is (length/|z| − 1)/2.
    #[inline(always)]
    pub(crate) fn length(self, w: R::Vec3) -> R {
        let a2 = self.alpha * self.alpha;
        (a2 * (w[0] * w[0] + w[1] * w[1] * self.ratio * self.ratio) + w[2] * w[2]).sqrt()
    }

    /// Share of the lower part of the sampled spherical cap that can reflect `wo` upwards (Eto
    /// and Tokuyoshi 2023, "Bounded VNDF Sampling for Smith-GGX Reflections"). With a share of 1,
    /// the whole cap is sampled. The roughness must be the same in all directions.
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
        let (x, y) = (self.alpha, self.alpha * self.ratio);
        let stretched = R::Vec3::new(x * wo[0], y * wo[1], wo[2]) / self.length(wo);
        let lowest = share * stretched[2];
        let z = (R::ONE - u) * (R::ONE + lowest) - lowest;
        let radius = max(R::ZERO, R::ONE - z * z).sqrt();
        let (sin, cos) = sin_cos_turns(v);
        let half = stretched + R::Vec3::new(radius * cos, radius * sin, z);
        normalize(R::Vec3::new(x * half[0], y * half[1], half[2]))
    }

    /// f·|cos θ| without the Fresnel factor, and the density by [`sample`](Self::sample) with a share of 1, of
    /// reflection from `wo` into `wi` by microfacets of the normal `m`.
    #[inline(always)]
    pub(crate) fn reflect(self, wo: R::Vec3, wi: R::Vec3, m: R::Vec3) -> (R, R) {
        let (lo, li) = (self.length(wo), self.length(wi));
        let pdf = self.density(m) / ((wo[2] + lo) * 2.0);
        let shadowing = wi[2] * (wo[2] + lo) / (wo[2] * li + wi[2] * lo);
        (shadowing * pdf, pdf)
    }
}
