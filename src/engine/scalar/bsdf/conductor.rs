//! Metal by its index of refraction, smooth or of GGX microfacets.

use glam::Vec3;

use super::{Arrival, SPECULAR, Scatter};
use crate::engine::dimension::{Dimension, Randoms};
use crate::math::microfacet::Ggx;
use crate::math::{Frame, dot, fresnel, min, normalize};

/// f = F D G/(4 |cos θo cos θi|), with masking and shadowing that know of each other's heights
/// (Heitz 2014, equation 99).
pub(in crate::engine) struct Conductor {
    frame: Frame,
    /// To where the path has come from, in the frame.
    wo: Vec3,
    eta: Vec3,
    k: Vec3,
    pub(super) ggx: Ggx,
    /// Of the normals that are sampled.
    bound: f32,
}

impl Conductor {
    pub(super) fn new(arrival: Arrival, eta: Vec3, k: Vec3, alpha: f32) -> Self {
        let (frame, ggx) = (Frame::new(arrival.normal), Ggx { alpha });
        let wo = frame.local(-arrival.direction);
        Self { frame, wo, eta, k, ggx, bound: ggx.bound(wo) }
    }

    pub(super) fn sample(&self, randoms: &Randoms) -> Option<Scatter> {
        let (u, v) = randoms.two(Dimension::SCATTER);
        let m = self.ggx.sample(self.wo, self.bound, u, v);
        let cos = dot(self.wo, m);
        let wi = normalize(m * (2.0 * cos) - self.wo);
        // False for NaN too.
        (wi.z > 0.0).then(|| Scatter {
            direction: self.frame.world(wi),
            side: self.frame.normal(),
            weight: self.reflectance(cos) * self.weight(wi),
            pdf: if self.ggx.alpha > 0.0 { self.pdf(m) } else { SPECULAR },
        })
    }

    pub(super) fn evaluate(&self, direction: Vec3) -> (Vec3, f32) {
        let wi = self.frame.local(direction);
        if !(wi.z > 0.0 && self.ggx.alpha > 0.0) {
            return (Vec3::ZERO, 0.0);
        }
        let m = normalize(self.wo + wi);
        let pdf = self.pdf(m);
        (self.reflectance(dot(self.wo, m)) * (self.weight(wi) * pdf), pdf)
    }

    fn reflectance(&self, cos: f32) -> Vec3 {
        fresnel::conductor(min(cos, 1.0), self.eta, self.k)
    }

    /// Density of the direction that `m` reflects to.
    fn pdf(&self, m: Vec3) -> f32 {
        let projected = self.bound * self.wo.z + self.ggx.length(self.wo);
        self.ggx.density(m) / (2.0 * projected)
    }

    /// f·cos θi/pdf without F: D is in both.
    fn weight(&self, wi: Vec3) -> f32 {
        let (lo, li) = (self.ggx.length(self.wo), self.ggx.length(wi));
        wi.z * (self.bound * self.wo.z + lo) / (self.wo.z * li + wi.z * lo)
    }
}
