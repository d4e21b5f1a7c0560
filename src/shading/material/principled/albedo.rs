//! The share of light that GGX microfacets reflect, as a table over direction and roughness.

use std::array;
use std::sync::LazyLock;

use glam::Vec3;

use crate::math::microfacet::Ggx;
use crate::math::{Mask, Real, Row, Word, clamp, dot, max, whole};

/// Number of cosines and of roughnesses in the table. The cosines are evenly spaced from 0 to 1, and so
/// are the square roots of the roughnesses.
const NODES: usize = 32;
/// Samples along each axis for each entry.
const STEPS: u16 = 24;

/// Two integrals over the microfacets' reflected directions, with Schlick's approximation of the
/// reflectance: F = f0 (1 − w) + f90 w, where w = (1 − cosine)⁵. The share of reflected light is
/// f0 `low` + f90 `high` (Karis 2013, "Real Shading in Unreal Engine 4").
#[derive(Clone, Copy, Debug)]
pub(in crate::shading::material) struct Shares<R> {
    /// Integral of 1 − w.
    pub(in crate::shading::material) low: R,
    /// Integral of w.
    pub(in crate::shading::material) high: R,
}

/// Entries (cosine `i`, roughness `j`) and (cosine `i + 1`, roughness `j`) at index `NODES j + i`.
static TABLE: LazyLock<Vec<Row>> = LazyLock::new(|| {
    let nodes: Vec<[[f32; 2]; NODES]> =
        (0..NODES).map(|j| array::from_fn(|i| node(i, j))).collect();
    let entry = |j: usize, i: usize| {
        let ([a, b], [c, d]) = (nodes[j][i], nodes[j][(i + 1).min(NODES - 1)]);
        [a, b, c, d].map(f32::to_bits)
    };
    (0..NODES).flat_map(|j| (0..NODES).map(move |i| entry(j, i))).collect()
});

/// The means of [`TABLE`], weighted with the cosine, for roughness `j` and `j + 1` at index `j`.
static MEANS: LazyLock<Vec<Row>> = LazyLock::new(|| {
    let mean = |j: usize, part: usize| {
        let value = |i: usize| f64::from(f32::from_bits(TABLE[NODES * j + i][part]));
        // 2 ∫ (linear function) cos d cos over each interval of length h.
        let h = 1.0 / (NODES - 1) as f64;
        let interval = |i: usize| {
            let (x, a, b) = (h * i as f64, value(i), value(i + 1));
            h * (a * (x + h / 3.0) + b * (x + 2.0 * h / 3.0))
        };
        (0..NODES - 1).map(interval).sum::<f64>() as f32
    };
    let row = |j: usize| {
        let next = (j + 1).min(NODES - 1);
        [mean(j, 0), mean(j, 1), mean(next, 0), mean(next, 1)].map(f32::to_bits)
    };
    (0..NODES).map(row).collect()
});

fn node(i: usize, j: usize) -> [f32; 2] {
    let at = |node: usize| node as f32 / (NODES - 1) as f32;
    integrate(max(at(i), 1e-3), max(at(j) * at(j), 1e-3), STEPS)
}

/// [`Shares`] for the cosine `cos` and the roughness `alpha`, by the midpoint rule over the visible
/// microfacets.
fn integrate(cos: f32, alpha: f32, steps: u16) -> [f32; 2] {
    let (ggx, wo) = (Ggx::new(alpha), Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos));
    let lo = ggx.length(wo);
    let mut sums = [0.0f64; 2];
    for step in 0..u32::from(steps) * u32::from(steps) {
        let at = |step: u32| (step as f32 + 0.5) / f32::from(steps);
        let (u, v) = (at(step % u32::from(steps)), at(step / u32::from(steps)));
        let m: Vec3 = ggx.sample(wo, 1.0, u, v);
        let facing = dot(wo, m);
        let wi = m * (2.0 * facing) - wo;
        if wi.z > 0.0 {
            let weight = wi.z * (wo.z + lo) / (wo.z * ggx.length(wi) + wi.z * lo);
            let high = schlick_weight(facing);
            sums[0] += f64::from(weight * (1.0 - high));
            sums[1] += f64::from(weight * high);
        }
    }
    sums.map(|sum| (sum / f64::from(steps) / f64::from(steps)) as f32)
}

/// (1 − `cos`)⁵, the weight of the reflectance at grazing angles (Schlick 1994).
#[inline(always)]
pub(super) fn schlick_weight<R: Real>(cos: R) -> R {
    let x = clamp(R::ONE - cos, R::ZERO, R::ONE);
    let x2 = x * x;
    x2 * x2 * x
}

/// Position `x` in [0, 1] among so many nodes: the one before it, and the distance to it.
#[inline(always)]
pub(super) fn position<R: Real>(x: R, nodes: usize) -> (R::Word, R) {
    let scaled = clamp(x, R::ZERO, R::ONE) * (nodes - 1) as f32;
    (whole(scaled), scaled - scaled.floor())
}

impl Shares<f32> {
    /// Computes the tables, which take milliseconds, before a render is timed.
    pub(in crate::shading::material) fn prepare() {
        LazyLock::force(&MEANS);
    }
}

impl<R: Real> Shares<R> {
    /// The shares for light that leaves or arrives at the cosine `cos` to the normal.
    #[inline(always)]
    pub(super) fn at(cos: R, alpha: R) -> Self {
        let ((i, fx), (j, fy)) = (position(cos, NODES), position(alpha.sqrt(), NODES));
        let table = &TABLE[..];
        let last = R::Word::splat(NODES as u32 - 1);
        let next = j.wrapping_add(R::Word::splat(1));
        let next = next.le(last).select(next, last);
        let row = |j: R::Word| {
            let entry = j.wrapping_mul(R::Word::splat(NODES as u32)).wrapping_add(i);
            let (first, last) = R::gather(table, R::index(entry, table.len()), |row| row);
            let blend = |a: R, b: R| a + (b - a) * fx;
            (blend(first[0], first[2]), blend(first[1], last))
        };
        let ((low, high), (next_low, next_high)) = (row(j), row(next));
        Self { low: low + (next_low - low) * fy, high: high + (next_high - high) * fy }
    }

    /// The means over the hemisphere, weighted with the cosine. They are those of
    /// [`Shares::at`], without further approximation.
    #[inline(always)]
    pub(in crate::shading::material) fn mean(alpha: R) -> Self {
        let (j, fy) = position(alpha.sqrt(), NODES);
        let (first, last) = R::gather(&MEANS, R::index(j, NODES), |row| row);
        let blend = |a: R, b: R| a + (b - a) * fy;
        Self { low: blend(first[0], first[2]), high: blend(first[1], last) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;

    #[test]
    fn tables_agree_with_finer_integrals() {
        let mut random = Stream::new(2);
        let mut worst = 0.0;
        for _ in 0..300 {
            let (cos, alpha) = (random.between(0.03, 1.0), random.between(0.03, 1.0));
            let [low, high] = integrate(cos, alpha, 100);
            let shares = Shares::at(cos, alpha);
            worst = max(worst, max((shares.low - low).abs(), (shares.high - high).abs()));
        }
        assert!(worst < 0.01, "{worst}");
    }

    #[test]
    fn means_are_integrals_of_the_table() {
        for alpha in [0.0, 0.01, 0.3, 0.77, 1.0] {
            const STEPS: u16 = 10_000;
            let (mut low, mut high) = (0.0, 0.0);
            for step in 0..STEPS {
                let cos = (f32::from(step) + 0.5) / f32::from(STEPS);
                let shares = Shares::at(cos, alpha);
                low += f64::from(2.0 * cos * shares.low) / f64::from(STEPS);
                high += f64::from(2.0 * cos * shares.high) / f64::from(STEPS);
            }
            let mean = Shares::mean(alpha);
            assert!((f64::from(mean.low) - low).abs() < 1e-4, "{alpha}: {mean:?} {low}");
            assert!((f64::from(mean.high) - high).abs() < 1e-4, "{alpha}: {mean:?} {high}");
        }
    }
}
