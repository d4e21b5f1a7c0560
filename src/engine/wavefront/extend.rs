//! Extend: finds the hits of rays.

use super::WaveRays;
use crate::accel::{Accelerator, Counters, HitBatch, Kernel, RayBatch};
use crate::geometry::{Hit, Ray};
use crate::simd::LANES;

/// Finds the closest hits of `rays`. Returns the work of the kernel if `count` is set.
#[inline(never)]
pub(super) fn extend(
    accelerator: &Accelerator,
    kernel: Kernel,
    rays: &WaveRays,
    hits: &mut HitBatch,
    count: bool,
) -> Counters {
    trace(accelerator, kernel, false, &rays.batch, hits, count)
}

/// Finds the closest hits of `rays`. If `any` is set, only finds out whether each ray has a hit.
/// The length of `hits` is rounded up so that whole vectors can be read.
pub(super) fn trace(
    accelerator: &Accelerator,
    kernel: Kernel,
    any: bool,
    rays: &RayBatch,
    hits: &mut HitBatch,
    count: bool,
) -> Counters {
    hits.reset(rays.len().next_multiple_of(LANES), accelerator.has_instances());
    let all = 0..rays.len();
    match (count, any) {
        (true, _) => return accelerator.count(kernel, any, rays, all, hits),
        (false, false) => accelerator.closest(kernel, rays, all, hits),
        (false, true) => accelerator.occluded(kernel, rays, all, hits),
    }
    Counters::default()
}

/// Finds the closest hit of a single ray.
pub(super) fn closest(accelerator: &Accelerator, kernel: Kernel, ray: &Ray) -> Option<Hit> {
    let (mut rays, mut hits) = (RayBatch::default(), HitBatch::default());
    rays.push(ray, 0.0, f32::INFINITY);
    trace(accelerator, kernel, false, &rays, &mut hits, false);
    hits.get(0)
}
