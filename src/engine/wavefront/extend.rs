//! Extend: what the rays hit.

use super::rays::Rays;
use crate::accel::{Accelerator, Counters, HitBatch, Kernel};
use crate::simd::LANES;

/// Finds the closest hits of `rays`. Returns the work, if it is to `count` it.
pub(super) fn extend(
    accelerator: &Accelerator,
    kernel: Kernel,
    rays: &Rays,
    hits: &mut HitBatch,
    count: bool,
) -> Counters {
    // Whole vectors are read.
    hits.reset(rays.len().next_multiple_of(LANES));
    let all = 0..rays.len();
    if count {
        return accelerator.count(kernel, false, &rays.batch, all, hits);
    }
    accelerator.closest(kernel, &rays.batch, all, hits);
    Counters::default()
}
