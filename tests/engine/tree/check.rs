//! Compares kernels with an oracle.

use glam::Vec3;
use ptfast::internals::{Accelerator, Geometry, Hit, HitBatch, Ray, RayBatch, Stream};
use ptfast::{Kernel, TreeQuality};
use rayon::prelude::*;

use super::rays::{Bundles, adversarial};

/// Number of rays traced for each kind of scene.
pub(crate) const RAYS: usize = if cfg!(feature = "slow-tests") { 10_000_000 } else { 50_000 };
/// Number of rays in a round, which are traced as one batch: a whole number of bundles.
pub(crate) const ROUND: usize = 320 * Bundles::SIZE;

pub(crate) fn bits(hit: Option<Hit>) -> Option<(u32, u32, u32)> {
    hit.map(|hit| (hit.instance, hit.primitive, hit.t.to_bits()))
}

/// The interval of ray number `i`, which was generated for distances up to `t_max` and hits `hit`.
///
/// In one of every four pairs of bundles, all intervals begin above 0, mostly at or next to the
/// hit. In another one, some intervals begin or end at or near the hit. All other intervals are
/// (0, `t_max`).
fn interval(i: usize, t_max: f32, hit: Option<Hit>) -> (f32, f32) {
    let pair = i / Bundles::SIZE / 2 % 4;
    let Some(Hit { t, .. }) = hit else {
        // A beam begins above 0 only if all its rays do.
        return if pair == 2 { (1e-3, t_max) } else { (0.0, t_max) };
    };
    match (pair, i % 8) {
        (2, 0..2) | (3, 0) => (t, t_max),
        (2, 2..4) => (t.next_up(), t_max),
        (2, 4..6) => (t.next_down(), t_max),
        (2, _) | (3, 1) => (0.5 * t, t_max),
        (3, 2) => (0.0, t),
        (3, 3) => (0.0, t.next_up()),
        (3, 4) => (t.next_down(), t.next_up()),
        _ => (0.0, t_max),
    }
}

/// Generates `rays` rays in rounds, to be checked in parallel. `make` generates ray number `i` and the
/// end of its interval.
///
/// Rounds are generated in sequence, so rays from one random stream do not depend on the threads.
pub(crate) fn rounds(
    rays: usize,
    mut make: impl FnMut(usize) -> (Ray, f32) + Send,
) -> impl ParallelIterator<Item = Vec<(Ray, f32)>> {
    let round = move |first| (first..rays.min(first + ROUND)).map(&mut make).collect::<Vec<_>>();
    (0..rays).step_by(ROUND).map(round).par_bridge()
}

/// Compares every kernel with `oracle`. `make` generates ray number `i` and the end of its interval.
pub(crate) fn check_kernels(
    name: &str,
    geometry: &Geometry,
    rays: usize,
    make: impl FnMut(usize) -> (Ray, f32) + Send,
    oracle: impl Fn(&Ray, f32, f32) -> Option<Hit> + Sync,
) {
    let [best, fast] = [(); 2].map(|()| Accelerator::new(geometry.clone()));
    fast.set_quality(TreeQuality::Fast);
    let check_round = |rays: Vec<(Ray, f32)>| {
        let (mut batch, mut want) = (RayBatch::default(), HitBatch::default());
        for (i, (ray, t_max)) in rays.into_iter().enumerate() {
            let hit = oracle(&ray, 0.0, t_max);
            let (t_min, end) = interval(i, t_max, hit);
            batch.push(&ray, t_min, end);
            want.push(if (t_min, end) == (0.0, t_max) { hit } else { oracle(&ray, t_min, end) });
        }
        let each = 0..batch.len();
        let all = Kernel::ALL.map(|kernel| (&best, kernel));
        for (trees, kernel) in
            all.into_iter().chain([Kernel::Beam, Kernel::Stream].map(|k| (&fast, k)))
        {
            // In large scenes, `flat` takes too long to trace all rays, so it traces only some
            // bundles with each kind of interval.
            let share = kernel == Kernel::Flat && geometry.len() > 1000;
            let each = if share { 0..batch.len().min(8 * Bundles::SIZE) } else { each.clone() };
            let (mut closest, mut any) =
                (HitBatch::misses(batch.len()), HitBatch::misses(batch.len()));
            trees.closest(kernel, &batch, each.clone(), &mut closest);
            trees.occluded(kernel, &batch, each.clone(), &mut any);
            for i in each.clone() {
                let told = || format!("{name}, {kernel:?}: {:?}", batch.get(i));
                assert_eq!(bits(closest.get(i)), bits(want.get(i)), "{}", told());
                let occluded = want.get(i).map(|_| Hit::of(0, 0.0));
                assert_eq!(any.get(i), occluded, "{}", told());
            }
        }
        want.primitive.iter().filter(|p| **p != HitBatch::MISS).count()
    };
    let hit: usize = rounds(rays, make).map(check_round).sum();
    assert!(hit > rays / 20, "{name}: only {hit} of {rays} rays hit anything");
}

/// Compares every kernel with brute force on `rays` rays, half of them independent and half in
/// bundles.
pub(crate) fn check(name: &str, geometry: &Geometry, rays: usize, scale: f32, shift: Vec3) {
    let mut random = Stream::new(99);
    let make = |i| adversarial(&mut random, i, geometry, scale, shift);
    let oracle = |ray: &Ray, t_min, t_max| geometry.closest_by_brute_force(ray, t_min, t_max);
    check_kernels(name, geometry, rays / 2, make, oracle);
    let mut bundles = Bundles::new(98, geometry, scale, shift);
    check_kernels(name, geometry, rays / 2, |i| bundles.next(i), oracle);
}
