//! Kernels beside an oracle.

use glam::Vec3;
use ptfast::accel::{Accelerator, HitBatch, Kernel, RayBatch};
use ptfast::geometry::{Geometry, Hit, Ray};
use ptfast::math::random::Stream;
use rayon::prelude::*;

use crate::rays::{Bundles, adversarial};

/// Rays of one kind of scene.
pub(crate) const RAYS: usize = if cfg!(feature = "slow-tests") { 10_000_000 } else { 120_000 };
/// Rays of one batch.
pub(crate) const ROUND: usize = 20_000;

pub(crate) fn bits(hit: Option<Hit>) -> Option<(u32, u32)> {
    hit.map(|hit| (hit.primitive, hit.t.to_bits()))
}

/// Compares every kernel with `oracle`, over rays that `make` makes.
pub(crate) fn check_kernels(
    name: &str,
    geometry: &Geometry,
    rays: usize,
    mut make: impl FnMut(usize) -> (Ray, f32) + Send,
    oracle: impl Fn(&Ray, f32) -> Option<Hit> + Sync,
) {
    let accelerator = Accelerator::new(geometry, (0.0, 1.0));
    let kernels: Vec<Kernel> = Kernel::ALL
        .into_iter()
        .filter(|kernel| *kernel != Kernel::Flat || geometry.len() <= 1000)
        .collect();
    let rounds = (0..rays)
        .step_by(ROUND)
        .map(|first| (first..rays.min(first + ROUND)).map(&mut make).collect::<Vec<_>>());
    let check_round = |rays: Vec<(Ray, f32)>| {
        let (mut batch, mut want) = (RayBatch::default(), HitBatch::default());
        for (ray, t_max) in rays {
            batch.push(&ray, 0.0, t_max);
            want.push(oracle(&ray, t_max));
        }
        let each = 0..batch.len();
        for &kernel in &kernels {
            let (mut closest, mut any) =
                (HitBatch::misses(batch.len()), HitBatch::misses(batch.len()));
            accelerator.closest(kernel, &batch, each.clone(), &mut closest);
            accelerator.occluded(kernel, &batch, each.clone(), &mut any);
            for i in each.clone() {
                let told = || format!("{name}, {kernel:?}: {:?}", batch.get(i));
                assert_eq!(bits(closest.get(i)), bits(want.get(i)), "{}", told());
                let occluded = want.get(i).map(|_| Hit { t: 0.0, primitive: 0 });
                assert_eq!(any.get(i), occluded, "{}", told());
            }
        }
        want.primitive.iter().filter(|p| **p != HitBatch::MISS).count()
    };
    // Rays are made one after the other, from one stream; rounds of them are independent.
    let hit: usize = rounds.par_bridge().map(check_round).sum();
    assert!(hit > rays / 20, "{name}: only {hit} of {rays} rays hit anything");
}

/// Compares every kernel with brute force, over `rays` rays: half of them each for itself, half in
/// bundles.
pub(crate) fn check(name: &str, geometry: &Geometry, rays: usize, scale: f32, shift: Vec3) {
    let mut random = Stream::new(99);
    let make = |i| adversarial(&mut random, i, geometry, scale, shift);
    let oracle = |ray: &Ray, t_max| geometry.closest_by_brute_force(ray, 0.0, t_max);
    check_kernels(name, geometry, rays / 2, make, oracle);
    let mut bundles = Bundles::new(98, geometry, scale, shift);
    check_kernels(name, geometry, rays / 2, |i| bundles.next(i), oracle);
}
