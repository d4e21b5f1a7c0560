//! Diffuse surfaces: Lambert's law (report, III.C) or the report's ideal diffuse (III.B).

use glam::Vec3;
use std::f32::consts::PI;

use super::Scatter;
use crate::engine::dimension::{Dimension, Randoms};
use crate::math::dot;
use crate::math::warp::{cosine_hemisphere, uniform_hemisphere};

/// A diffuse surface seen from one side. The ideal diffuse is uniform over the hemisphere.
pub(in crate::engine) struct Diffuse {
    /// On the side that was hit.
    pub(super) normal: Vec3,
    /// ρ, which is also the weight of every sample.
    pub(super) albedo: Vec3,
    /// Whether it is Lambert's law.
    pub(super) cosine: bool,
}

impl Diffuse {
    pub(super) fn sample(&self, randoms: &Randoms) -> Scatter {
        let (u, v) = randoms.two(Dimension::SCATTER);
        let (direction, pdf) = if self.cosine {
            let (direction, cos) = cosine_hemisphere(self.normal, u, v);
            (direction, cos * (1.0 / PI))
        } else {
            (uniform_hemisphere(self.normal, u, v).0, 0.5 / PI)
        };
        Scatter { direction, side: self.normal, weight: self.albedo, pdf }
    }

    pub(super) fn evaluate(&self, direction: Vec3) -> (Vec3, f32) {
        let cos = dot(self.normal, direction);
        let pdf = match cos > 0.0 {
            true if self.cosine => cos * (1.0 / PI),
            true => 0.5 / PI,
            false => 0.0,
        };
        (self.albedo * pdf, pdf)
    }
}
