//! Refraction by microfacets, and the light that they lose.

use std::sync::LazyLock;

use glam::Vec3;

use super::albedo::{position, schlick_weight};
use super::reflectance_at_normal;
use crate::math::microfacet::Ggx;
use crate::math::{Mask, Real, Row, Word, dot, max};

/// Number of cosines and of roughnesses α in the table. The square roots of both are evenly spaced from 0 to 1.
const NODES: usize = 16;
/// Number of indices of refraction n, evenly spaced in the root of (n − 1)/(n + 1), from 0 to that of 1/2: first those
/// of light that arrives from outside, then those from inside. Above 3, n counts as 3.
const INDICES: usize = 12;
/// Number of entries for each kind of reflectance.
const PLANE: usize = NODES * NODES * 2 * INDICES;
/// Steps of the integrals along each axis.
const STEPS: u16 = 12;

/// The shares of light that white glass reflects and refracts at cosines i and i + 1, first for α number j, then
/// for j + 1, at the index `NODES` (`NODES` k + j) + i for index of refraction k: first for glass that reflects only
/// what is totally reflected, then with Schlick's reflectance. Between these, the shares are linear.
static TABLE: LazyLock<Vec<Row>> = LazyLock::new(|| {
    let at = |node: usize, nodes: usize| node as f32 / (nodes - 1) as f32;
    let value = |node: usize| {
        let (i, j, k) = (node % NODES, node / NODES % NODES, node / (NODES * NODES));
        let root = at(k % INDICES, INDICES);
        let slope = max(0.5 * root * root, 1e-3);
        let ior = (1.0 + slope) / (1.0 - slope);
        let eta = if k < INDICES { ior } else { 1.0 / ior };
        let square = |node: usize| max(at(node, NODES) * at(node, NODES), 1e-3);
        integrate(square(i), square(j), eta, STEPS)
    };
    let nodes: Vec<[f32; 2]> = (0..PLANE).map(value).collect();
    let row = |entry: usize| {
        let (node, reflects) = (entry % PLANE, entry / PLANE);
        let right = if node % NODES + 1 < NODES { 1 } else { 0 };
        let up = if node / NODES % NODES + 1 < NODES { NODES } else { 0 };
        let corners = [node, node + right, node + up, node + up + right];
        corners.map(|node| nodes[node][reflects].to_bits())
    };
    (0..2 * PLANE).map(row).collect()
});

/// The shares of light that white glass reflects and refracts once, as in [`TABLE`], by the midpoint rule over the
/// visible microfacets. `eta` is the index beyond the surface divided by the index before it.
fn integrate(cos: f32, alpha: f32, eta: f32, steps: u16) -> [f32; 2] {
    let (ggx, wo) = (Ggx::new(alpha), Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos));
    let (lo, f0) = (ggx.length(wo), reflectance_at_normal(eta));
    let mut sums = [0.0f64; 2];
    for step in 0..u32::from(steps) * u32::from(steps) {
        let at = |step: u32| (step as f32 + 0.5) / f32::from(steps);
        let (u, v) = (at(step % u32::from(steps)), at(step / u32::from(steps)));
        let m: Vec3 = ggx.sample(wo, 1.0, u, v);
        let facing = dot(wo, m);
        let (bent, enclosed) = outside(facing, eta);
        let (mut reflected, mut refracted) = (0.0, 0.0);
        let wi = m * (2.0 * facing) - wo;
        if wi.z > 0.0 {
            reflected = wi.z * (wo.z + lo) / (wo.z * ggx.length(wi) + wi.z * lo);
        }
        let sin2 = (1.0 - facing * facing) / (eta * eta);
        let wi = m * (facing / eta - max(1.0 - sin2, 0.0).sqrt()) - wo / eta;
        if wi.z < 0.0 {
            refracted = 2.0 * wi.z / (wi.z - ggx.length(wi));
        }
        let shares = match enclosed {
            true => [1.0; 2],
            false => [0.0, f0 + (1.0 - f0) * schlick_weight(bent)],
        };
        for (sum, share) in sums.iter_mut().zip(shares) {
            *sum += f64::from(reflected * share + refracted * (1.0 - share));
        }
    }
    sums.map(|sum| (sum / f64::from(steps) / f64::from(steps)) as f32)
}

/// Computes the table, which takes some 50 milliseconds, before a render is timed.
pub(super) fn prepare() {
    LazyLock::force(&TABLE);
}

/// The share of light that rough glass whose reflectance has the factor `specular` reflects and refracts at the cosine
/// `cos`. The rest would be reflected or refracted more than once.
#[inline(never)]
pub(super) fn kept<R: Real>(cos: R, alpha: R, eta: R, specular: R) -> R {
    let word = |x: usize| R::Word::splat(x as u32);
    let ((i, fx), (j, fy)) = (position(cos.sqrt(), NODES), position(alpha.sqrt(), NODES));
    let (k, fz) = position((((eta - R::ONE) / (eta + R::ONE)).abs() * 2.0).sqrt(), INDICES);
    let inside = eta.lt(R::ONE).select(word(INDICES), word(0));
    let blend = |a: R, b: R, f: R| a + (b - a) * f;
    let at = |k: R::Word, reflects: usize| {
        let plane = k.wrapping_add(inside).wrapping_mul(word(NODES * NODES));
        let entry = plane.wrapping_add(j.wrapping_mul(word(NODES))).wrapping_add(i);
        let entry = entry.wrapping_add(word(PLANE * reflects));
        let (first, last) = R::gather(&TABLE, R::index(entry, TABLE.len()), |row| row);
        blend(blend(first[0], first[1], fx), blend(first[2], last, fx), fy)
    };
    let next = k.wrapping_add(word(1));
    let next = next.le(word(INDICES - 1)).select(next, word(INDICES - 1));
    let by = |reflects: usize| blend(at(k, reflects), at(next, reflects), fz);
    blend(by(0), by(1), specular)
}

/// The cosine outside of a denser body for light that arrives at the cosine `cos` from inside, where
/// `eta` is below 1, and whether it is totally reflected. Other light keeps its cosine.
#[inline(always)]
pub(super) fn outside<R: Real>(cos: R, eta: R) -> (R, R::Mask) {
    let inside = eta.lt(R::ONE);
    if !inside.any() {
        return (cos, R::Mask::NONE);
    }
    let sin2 = (R::ONE - cos * cos) / (eta * eta);
    let bent = max(R::ZERO, R::ONE - sin2).sqrt();
    (inside.select(bent, cos), inside & sin2.ge(R::ONE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;

    #[test]
    fn table_agrees_with_finer_integrals() {
        let mut random = Stream::new(4);
        let mut worst = 0.0;
        for _ in 0..200 {
            let (cos, alpha) = (random.between(0.1, 1.0), random.between(0.03, 1.0));
            let ior = random.between(1.02, 2.5);
            for eta in [ior, 1.0 / ior] {
                let specular = random.uniform();
                let [none, all] = integrate(cos, alpha, eta, 64);
                let fine = none + (all - none) * specular;
                worst = max(worst, (kept(cos, alpha, eta, specular) - fine).abs());
            }
        }
        assert!(worst < 0.025, "{worst}");
    }
}
