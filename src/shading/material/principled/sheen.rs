//! The sheen of cloth.

use std::f32::consts::PI;
use std::sync::LazyLock;

use glam::Vec3;

use super::albedo::position;
use crate::math::powers::{exp, ln};
use crate::math::{
    Mask, Real, Row, Vector, Word, clamp, max, max_element, min, normalize, sin_cos_turns,
};

/// Least roughness of fibres.
const LEAST_ALPHA: f32 = 0.01;
/// Number of cosines, and of square roots of α, in the table. Both are evenly spaced from 0 to 1.
const NODES: usize = 24;
/// Steps of the integrals along each axis.
const STEPS: u16 = 32;

/// Fibres that stand off a surface, on top of what else it reflects (Estevez and Kulla 2017, "Production
/// Friendly Microfacet Sheen BRDF", with the shadowing of Neubelt and Pettineo 2013, "Crafting a Next-Gen
/// Material Pipeline for The Order: 1886").
pub(super) struct Sheen<R: Real> {
    /// Colour, scaled so that no more light is reflected than arrives.
    color: R::Vec3,
    alpha: R,
    /// Share of the light, in each channel, that is reflected back along the path.
    pub(super) reflects: R::Vec3,
}

/// The shares of reflected light at cosines i and i + 1, first for α number j, then for j + 1, at the index
/// `NODES` j + i.
static TABLE: LazyLock<Vec<Row>> = LazyLock::new(|| {
    let at = |node: usize| node as f32 / (NODES - 1) as f32;
    let value = |i: usize, j: usize| integrate(max(at(i), 1e-3), alpha_of(at(j)));
    let nodes: Vec<f32> =
        (0..NODES * NODES).map(|node| value(node % NODES, node / NODES)).collect();
    let row = |node: usize| {
        let (i, j) = (node % NODES, node / NODES);
        let (i2, j2) = ((i + 1).min(NODES - 1), (j + 1).min(NODES - 1));
        [(i, j), (i2, j), (i, j2), (i2, j2)].map(|(i, j)| nodes[NODES * j + i].to_bits())
    };
    (0..NODES * NODES).map(row).collect()
});

/// The roughness α of fibres for the roughness of a material.
fn alpha_of<R: Real>(roughness: R) -> R {
    max(roughness * roughness, R::splat(LEAST_ALPHA))
}

/// f·cos θi of white fibres.
#[inline(always)]
fn reflect<R: Real>(alpha: R, wo: R::Vec3, wi: R::Vec3) -> R {
    let m = normalize(wo + wi);
    let sin2 = clamp(m[0] * m[0] + m[1] * m[1], R::splat(1.0 / 16_777_216.0), R::ONE);
    let density = (R::splat(2.0) + R::ONE / alpha) * exp(ln(sin2) * 0.5 / alpha) * (0.5 / PI);
    density * wi[2] / ((wo[2] + wi[2] - wo[2] * wi[2]) * 4.0)
}

/// The share of light that white fibres reflect at the cosine `cos`, by the midpoint rule over directions.
fn integrate(cos: f32, alpha: f32) -> f32 {
    let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
    let mut sum = 0.0f64;
    for step in 0..u32::from(STEPS) * u32::from(STEPS) {
        let at = |step: u32| (step as f32 + 0.5) / f32::from(STEPS);
        let (z, turn) = (at(step % u32::from(STEPS)), at(step / u32::from(STEPS)));
        // Half a turn is enough, by symmetry. Steps are finer at grazing angles, where more is reflected.
        let z = z * z;
        let (sin, cos) = sin_cos_turns(0.5 * turn);
        let radius = (1.0 - z * z).sqrt();
        let wi = Vec3::new(radius * cos, radius * sin, z);
        sum += f64::from(reflect(alpha, wo, wi)) * f64::from(2.0 * z.sqrt());
    }
    (sum * std::f64::consts::TAU) as f32 / (f32::from(STEPS) * f32::from(STEPS))
}

/// Computes the table, which takes milliseconds, before a render is timed.
pub(super) fn prepare() {
    LazyLock::force(&TABLE);
}

impl<R: Real> Sheen<R> {
    /// The sheen seen at the cosine `cos`.
    #[inline(always)]
    pub(super) fn new(color: R::Vec3, roughness: R, cos: R) -> Self {
        let mut sheen = Self { color, alpha: R::ONE, reflects: R::Vec3::zero() };
        if !sheen.exists() {
            return sheen;
        }
        sheen.alpha = alpha_of(roughness);
        let share = share(sheen.alpha, cos);
        // With this shadowing, smooth fibres would reflect more light than arrives at grazing angles.
        sheen.color = color / max(share, R::ONE);
        sheen.reflects = color * min(share, R::ONE);
        sheen
    }

    /// Whether any lane has a sheen.
    #[inline(always)]
    pub(super) fn exists(&self) -> bool {
        max_element(self.color).gt(R::ZERO).any()
    }

    /// The share of light that the fibres leave to the layers below.
    #[inline(always)]
    pub(super) fn leaves(&self) -> R {
        R::ONE - max_element(self.reflects)
    }

    /// f·|cos θ|.
    #[inline(always)]
    pub(super) fn value(&self, wo: R::Vec3, wi: R::Vec3) -> R::Vec3 {
        self.color * reflect(self.alpha, wo, wi)
    }
}

/// [`integrate`] by the table.
#[inline(always)]
fn share<R: Real>(alpha: R, cos: R) -> R {
    let ((i, fx), (j, fy)) = (position(cos, NODES), position(alpha.sqrt(), NODES));
    let entry = j.wrapping_mul(R::Word::splat(NODES as u32)).wrapping_add(i);
    let (first, last) = R::gather(&TABLE, R::index(entry, TABLE.len()), |row| row);
    let blend = |a: R, b: R, f: R| a + (b - a) * f;
    blend(blend(first[0], first[1], fx), blend(first[2], last, fx), fy)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;

    #[test]
    fn table_agrees_with_the_integral() {
        let mut random = Stream::new(3);
        let mut worst = 0.0;
        for _ in 0..500 {
            let (cos, roughness) = (random.between(0.1, 1.0), random.between(0.2, 1.0));
            let alpha = alpha_of(roughness);
            worst = max(worst, (share(alpha, cos) - integrate(cos, alpha)).abs());
        }
        assert!(worst < 0.02, "{worst}");
    }
}
