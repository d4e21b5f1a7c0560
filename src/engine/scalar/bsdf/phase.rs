//! Media that scatter light to all sides alike.

use glam::Vec3;
use std::f32::consts::PI;

use super::Scatter;
use crate::engine::dimension::{Dimension, Randoms};
use crate::math::warp::uniform_sphere;

/// The isotropic phase function. There is no surface, and so no cosine.
pub(in crate::engine) struct Phase {
    pub(super) albedo: Vec3,
}

impl Phase {
    const PDF: f32 = 0.25 / PI;

    pub(super) fn sample(&self, randoms: &Randoms) -> Scatter {
        let (u, v) = randoms.two(Dimension::SCATTER);
        let direction = uniform_sphere(u, v);
        Scatter { direction, side: Vec3::ZERO, weight: self.albedo, pdf: Self::PDF }
    }

    pub(super) fn evaluate(&self) -> (Vec3, f32) {
        (self.albedo * Self::PDF, Self::PDF)
    }
}
