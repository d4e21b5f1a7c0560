//! Replays ray sets through kernels, checking every hit and timing every kernel.

use std::time::Instant;

use super::{Query, RaySet};
use crate::accel::{Accelerator, Counters, HitBatch, Kernel};
use crate::geometry::Hit;
use crate::measure::statistics::{middle, sorted};

/// Result of a kernel on a ray set.
#[derive(Clone, Debug)]
pub(crate) struct Replay {
    /// The kernel.
    pub kernel: Kernel,
    /// Millions of rays per second on one thread: the median over the repetitions.
    pub mrays_per_s: f64,
    /// Number of hits that differ from those of the set in any bit.
    pub different: usize,
    /// Counters of one repetition.
    pub counters: Counters,
}

/// Rays that are traced with one call.
const BATCH: usize = 16_384;

/// Traces `set` through each of `kernels` in turn, `repetitions` times (at least once).
pub(crate) fn replay(
    accelerator: &Accelerator,
    set: &RaySet,
    kernels: &[Kernel],
    repetitions: u32,
) -> Vec<Replay> {
    let (mut hits, instanced) = (HitBatch::default(), accelerator.has_instances());
    let mut replays: Vec<Replay> = Vec::new();
    for &kernel in kernels {
        accelerator.prepare(kernel, 1);
        let mut counters = Counters::default();
        hits.reset(set.rays.len(), instanced);
        for batch in batches(set) {
            let any = set.query == Query::Occluded;
            counters += accelerator.count(kernel, any, &set.rays, batch, &mut hits);
        }
        let different = differences(set, &hits);
        replays.push(Replay { kernel, mrays_per_s: 0.0, different, counters });
    }
    let mut seconds = vec![Vec::new(); kernels.len()];
    for _ in 0..repetitions.max(1) {
        for (replay, seconds) in replays.iter_mut().zip(&mut seconds) {
            // Kernels write nothing for rays that miss, so resetting all rays to misses is part of
            // the timed work.
            let start = Instant::now();
            hits.reset(set.rays.len(), instanced);
            for batch in batches(set) {
                match set.query {
                    Query::Closest => {
                        accelerator.closest(replay.kernel, &set.rays, batch, &mut hits);
                    }
                    Query::Occluded => {
                        accelerator.occluded(replay.kernel, &set.rays, batch, &mut hits);
                    }
                }
            }
            seconds.push(start.elapsed().as_secs_f64());
            replay.different = replay.different.max(differences(set, &hits));
        }
    }
    for (replay, seconds) in replays.iter_mut().zip(seconds) {
        replay.mrays_per_s = set.rays.len() as f64 / middle(&sorted(seconds)) * 1e-6;
    }
    replays
}

fn batches(set: &RaySet) -> impl Iterator<Item = std::ops::Range<usize>> {
    let count = set.rays.len();
    (0..count).step_by(BATCH).map(move |first| first..count.min(first + BATCH))
}

fn differences(set: &RaySet, hits: &HitBatch) -> usize {
    let at = |hit: Hit| (hit.primitive, hit.instance);
    let same = |i: usize| {
        let same_t = set.query == Query::Occluded || hits.t[i].to_bits() == set.hits.t[i].to_bits();
        same_t && hits.get(i).map(at) == set.hits.get(i).map(at)
    };
    (0..hits.len()).filter(|&i| !same(i)).count()
}
