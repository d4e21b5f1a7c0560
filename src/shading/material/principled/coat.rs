//! The clear coat.

use super::albedo::{Shares, schlick_weight};
use super::parameters::Parameters;
use crate::math::microfacet::Ggx;
use crate::math::{Frame, Mask, Real, Vector, dot, min, normalize};
use crate::shading::Interaction;

/// Reflectance of the coat at normal incidence: that of an index of refraction of 1.5.
const F0: f32 = 0.04;

/// A layer of GGX microfacets on a share of the surface. Directions are in the frame of the layer below.
pub(super) struct Coat<R: Real> {
    strength: R,
    pub(super) ggx: Ggx<R>,
    /// Whether the coat has another normal than the layer below it.
    apart: R::Mask,
    /// The frame of the coat, where it is `apart`.
    frame: Frame<R::Vec3>,
    /// Direction back along the path, in the frame of the coat.
    pub(super) wo: R::Vec3,
}

impl<R: Real> Coat<R> {
    /// `below` is the frame of the layer below, and `wo` in it the direction back along the path.
    #[inline(always)]
    pub(super) fn new(
        p: &Parameters<R>,
        at: &Interaction<'_, R>,
        below: &Frame<R::Vec3>,
        wo: R::Vec3,
    ) -> Self {
        let ggx = Ggx::new(super::alpha(p.coat_roughness));
        let up = R::Vec3::new(R::ZERO, R::ZERO, R::ONE);
        let mut coat =
            Self { strength: p.coat, ggx, apart: p.coat_apart, frame: Frame::new(up), wo };
        if p.coat_apart.any() {
            let normal = below.local(at.other_mirror_normals(p.coat_normal));
            coat.frame = Frame::new(p.coat_apart.select(normal, up));
            coat.wo = p.coat_apart.select(coat.frame.local(wo), wo);
        }
        coat
    }

    /// Whether any lane has a coat.
    #[inline(always)]
    pub(super) fn exists(&self) -> bool {
        self.strength.gt(R::ZERO).any()
    }

    /// Share of the light that the coat reflects back along the path.
    #[inline(always)]
    pub(super) fn share(&self) -> R {
        if !self.exists() {
            return R::ZERO;
        }
        let Shares { low, high } = Shares::at(self.wo[2], self.ggx.mean_alpha());
        self.strength * (low * F0 + high)
    }

    /// A direction in the frame of the layer below, for `wi` in that of the coat.
    #[inline(always)]
    pub(super) fn in_layer_below(&self, wi: R::Vec3) -> R::Vec3 {
        if !self.apart.any() {
            return wi;
        }
        self.apart.select(self.frame.world(wi), wi)
    }

    /// f·|cos θ| and the density of the reflection into `wi`. `m` is the microfacet that reflects it by the
    /// layer below.
    #[inline(always)]
    pub(super) fn value(&self, mut wi: R::Vec3, mut m: R::Vec3) -> (R, R) {
        if self.apart.any() {
            wi = self.apart.select(self.frame.local(wi), wi);
            m = self.apart.select(normalize(self.wo + wi), m);
        }
        let (f_cos, pdf) = self.ggx.reflect(self.wo, wi, m);
        let high = schlick_weight(min(dot(self.wo, m), R::ONE));
        let reflectance = (R::splat(F0) + high * (1.0 - F0)) * self.strength;
        // Microfacets also send samples below the horizon of the coat, where they carry no light.
        let above = wi[2].gt(R::ZERO);
        let faces = m[2].gt(R::ZERO);
        (above.select(reflectance * f_cos, R::ZERO), faces.select(pdf, R::ZERO))
    }
}
