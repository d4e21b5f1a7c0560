//! Metal: the mirror direction, blurred (report, III.D).

use glam::Vec3;
use std::f32::consts::PI;

use super::{Arrival, SPECULAR, Scatter};
use crate::engine::contract::LEAST_BLUR;
use crate::engine::dimension::{Dimension, Randoms};
use crate::math::warp::uniform_ball;
use crate::math::{cross, dot, max, normalize, reflect};

/// The mirror direction moved by `fuzz` times a point of the unit ball; what then points below the
/// surface is absorbed.
pub(in crate::engine) struct Metal {
    normal: Vec3,
    mirror: Vec3,
    albedo: Vec3,
    fuzz: f32,
}

impl Metal {
    pub(super) fn new(arrival: Arrival, albedo: Vec3, fuzz: f32) -> Self {
        let Arrival { direction, normal, .. } = arrival;
        Self { normal, mirror: reflect(direction, normal), albedo, fuzz }
    }

    pub(super) fn is_specular(&self) -> bool {
        self.fuzz < LEAST_BLUR
    }

    pub(super) fn sample(&self, randoms: &Randoms) -> Option<Scatter> {
        let (u, v) = randoms.two(Dimension::SCATTER);
        let blur = uniform_ball(u, v, randoms.one(Dimension::BALL));
        let direction = normalize(self.mirror + blur * self.fuzz);
        let pdf = if self.is_specular() { SPECULAR } else { self.pdf(direction) };
        // False for NaN too, where the blur undoes the mirror direction exactly.
        let above = dot(direction, self.normal) > 0.0;
        above.then_some(Scatter { direction, side: self.normal, weight: self.albedo, pdf })
    }

    pub(super) fn evaluate(&self, direction: Vec3) -> (Vec3, f32) {
        let above = dot(direction, self.normal) > 0.0;
        let pdf = if above && !self.is_specular() { self.pdf(direction) } else { 0.0 };
        (self.albedo * pdf, pdf)
    }

    /// The volume of the ball in the direction: it is crossed from b − s to b + s, where b is the
    /// cosine from the mirror direction, and ∫r² dr over that is 2s(3b² + s²)/3.
    fn pdf(&self, direction: Vec3) -> f32 {
        let b = dot(self.mirror, direction);
        let across = cross(self.mirror, direction);
        let s2 = max(0.0, self.fuzz * self.fuzz - dot(across, across));
        let cube = self.fuzz * self.fuzz * self.fuzz;
        let pdf = s2.sqrt() * (3.0 * (b * b) + s2) / (2.0 * PI * cube);
        if b > 0.0 { pdf } else { 0.0 }
    }
}
