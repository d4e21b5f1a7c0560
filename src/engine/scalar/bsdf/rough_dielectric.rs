//! Frosted glass: GGX microfacets that reflect and refract (Walter et al. 2007).

use glam::Vec3;

use super::{Arrival, Scatter};
use crate::engine::dimension::{Dimension, Randoms};
use crate::math::microfacet::Ggx;
use crate::math::{Frame, dot, fresnel, max, min, normalize};

/// Each visible microfacet is a smooth piece of glass. Radiance is not scaled by the square of the
/// index of refraction, as in [`super::dielectric`]. Of the masking towards and shadowing from the
/// other side neither knows of the other's heights.
pub(in crate::engine) struct RoughDielectric {
    frame: Frame,
    /// To where the path has come from, in the frame.
    wo: Vec3,
    /// Index of refraction beyond the surface over that before it.
    eta: f32,
    ggx: Ggx,
}

impl RoughDielectric {
    pub(super) fn new(arrival: Arrival, ior: f32, alpha: f32) -> Self {
        let frame = Frame::new(arrival.normal);
        let wo = frame.local(-arrival.direction);
        let eta = if arrival.front { ior } else { 1.0 / ior };
        Self { frame, wo, eta, ggx: Ggx { alpha } }
    }

    pub(super) fn sample(&self, randoms: &Randoms) -> Option<Scatter> {
        let (u, v) = randoms.two(Dimension::SCATTER);
        let m = self.ggx.sample(self.wo, 1.0, u, v);
        let cos = min(dot(self.wo, m), 1.0);
        let reflected = randoms.one(Dimension::LOBE) < fresnel::dielectric(cos, self.eta);
        let wi = if reflected {
            m * (2.0 * cos) - self.wo
        } else {
            let sin2 = (1.0 - cos * cos) / (self.eta * self.eta);
            m * (cos / self.eta - max(0.0, 1.0 - sin2).sqrt()) - self.wo / self.eta
        };
        let wi = normalize(wi);
        let (weight, pdf) = self.weight_and_pdf(wi, m)?;
        let normal = self.frame.normal();
        // Where the microfacet turns the path to the other side it is lost.
        ((wi.z > 0.0) == reflected).then(|| Scatter {
            direction: self.frame.world(wi),
            side: if reflected { normal } else { -normal },
            weight: Vec3::splat(weight),
            pdf,
        })
    }

    pub(super) fn evaluate(&self, direction: Vec3) -> (Vec3, f32) {
        let wi = self.frame.local(direction);
        let half = if wi.z > 0.0 { self.wo + wi } else { self.wo + wi * self.eta };
        let half = if half.z < 0.0 { -half } else { half };
        let (weight, pdf) = self.weight_and_pdf(wi, normalize(half)).unwrap_or((0.0, 0.0));
        (Vec3::splat(weight * pdf), pdf)
    }

    /// f·|cos θi|/pdf and pdf of the direction `wi` by way of the microfacets with normal `m`; `None`
    /// where these cannot bring light that way.
    fn weight_and_pdf(&self, wi: Vec3, m: Vec3) -> Option<(f32, f32)> {
        let (before, after) = (min(dot(self.wo, m), 1.0), dot(wi, m));
        let (lo, li) = (self.ggx.length(self.wo), self.ggx.length(wi));
        let reflectance = fresnel::dielectric(before, self.eta);
        // Density of m, visible from wo: 2 D max(0, wo·m)/(z + length).
        let normals = 2.0 * self.ggx.density(m) * before / (self.wo.z + lo);
        let (weight, pdf, possible) = if wi.z > 0.0 {
            let weight = wi.z * (self.wo.z + lo) / (self.wo.z * li + wi.z * lo);
            (weight, reflectance * normals / (4.0 * before), after > 0.0)
        } else {
            // Shadowing alone: 2 |z|/(|z| + length).
            let weight = 2.0 * wi.z / (wi.z - li);
            let sum = before + self.eta * after;
            let jacobian = self.eta * self.eta * after.abs() / (sum * sum);
            (weight, (1.0 - reflectance) * normals * jacobian, after < 0.0)
        };
        (possible && before > 0.0 && pdf > 0.0).then_some((weight, pdf))
    }
}
