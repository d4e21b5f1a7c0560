//! The microfacets of rough surfaces: the distribution of Trowbridge and Reitz, called GGX, with
//! Smith's masking (Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces";
//! Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs").
//!
//! Directions are in the frame of the surface, z along its normal, and point away from it.

use glam::Vec3;
use std::f32::consts::PI;

use super::trig::sin_cos_turns;
use super::{max, normalize};

/// Microfacets of roughness α, in (0, 1]. With 0 what samples gives the normal itself.
#[derive(Clone, Copy, Debug)]
pub struct Ggx {
    /// α.
    pub alpha: f32,
}

impl Ggx {
    /// Density of the normal `m` over projected area, D.
    #[inline]
    pub fn density(self, m: Vec3) -> f32 {
        let a2 = self.alpha * self.alpha;
        // 1 + (α² − 1) z² without its cancellation.
        let d = (m.x * m.x + m.y * m.y) + a2 * (m.z * m.z);
        a2 / (PI * d * d)
    }

    /// Length of `w` where the microfacets are stretched to those of a sphere. Smith's Λ is
    /// (length/|z| − 1)/2.
    #[inline]
    pub fn length(self, w: Vec3) -> f32 {
        let a2 = self.alpha * self.alpha;
        (a2 * (w.x * w.x + w.y * w.y) + w.z * w.z).sqrt()
    }

    /// Share of the hemisphere's lower cap, as seen from `wo`, that can reflect upwards (Eto and
    /// Tokuyoshi 2023, "Bounded VNDF Sampling for Smith-GGX Reflections"). The whole is 1.
    #[inline]
    pub fn bound(self, wo: Vec3) -> f32 {
        let a2 = self.alpha * self.alpha;
        let s = 1.0 + (wo.x * wo.x + wo.y * wo.y).sqrt();
        let s2 = s * s;
        (1.0 - a2) * s2 / (s2 + a2 * (wo.z * wo.z))
    }

    /// A normal that is visible from `wo`, of density D(m) max(0, wo·m) 2/(`share` z + length): in
    /// the stretched sphere uniform in a cap (Dupuy and Benyoub 2023, "Sampling Visible GGX Normals
    /// with Spherical Caps").
    #[inline]
    pub fn sample(self, wo: Vec3, share: f32, u: f32, v: f32) -> Vec3 {
        let stretched = Vec3::new(self.alpha * wo.x, self.alpha * wo.y, wo.z) / self.length(wo);
        let lowest = share * stretched.z;
        let z = (1.0 - u) * (1.0 + lowest) - lowest;
        let radius = max(0.0, 1.0 - z * z).sqrt();
        let (sin, cos) = sin_cos_turns(v);
        let half = stretched + Vec3::new(radius * cos, radius * sin, z);
        normalize(Vec3::new(self.alpha * half.x, self.alpha * half.y, half.z))
    }
}
