//! Trials: measure which plan is fastest, on all threads at once as in a render.

use std::sync::{Arc, Mutex};

use super::fastest::{Tried, without_those_behind};
use crate::engine::wavefront::wave::Worker;
use crate::engine::{ImageSettings, Plan, Pool, Task, View, WaveStats};
use crate::film::{CHUNK, Grid, Tile, Unit};

/// Limits the length of a trial.
#[derive(Clone, Copy)]
pub(super) struct Effort {
    /// A trial traces at most 1/`share` as many paths as the render.
    pub(super) share: u64,
    /// Minimum and maximum number of rounds. Fewer would be too noisy, more would not help.
    pub(super) rounds: [u64; 2],
    /// The first round is shorter by this factor, which is enough to recognise plans that are far
    /// too slow.
    pub(super) first: u64,
}

/// Traces paths from the same parts of the image with each of `plans`, round after round. Drops
/// plans that fall behind. Returns an empty list if the render is too small for a trial.
pub(super) fn try_all<'a>(
    view: &Arc<View>,
    all_paths: u64,
    pool: &Pool,
    plans: &'a [Plan],
    effort: Effort,
) -> Vec<Tried<'a>> {
    let Some(largest) = plans.iter().max_by_key(|plan| plan.wave_size) else { return Vec::new() };
    let threads = pool.threads() as u64;
    let paths = u64::from(largest.wave_size);
    let paths_a_thread = all_paths / threads;
    let Some(rounds) = effort.rounds(paths_a_thread, plans.len() as u64 * paths, threads) else {
        return Vec::new();
    };
    for segment in plans.iter().flat_map(|plan| &plan.segments) {
        view.prepared.accelerator().prepare(segment.closest, pool.threads());
        view.prepared.accelerator().prepare(segment.occluded, pool.threads());
    }
    let workers: Vec<_> = (0..threads).map(|_| Mutex::new(None)).collect();
    let channels = view.settings.stored_layers().channels();
    // A single pixel may have more paths than a wave.
    let room = paths.max(u64::from(CHUNK));
    // All threads trace waves with the same plan at the same time.
    let take = |plan: &'a Plan, round: u64| {
        let paths = if round == 0 { paths.div_ceil(effort.first) } else { paths };
        pool.broadcast(|thread: usize| {
            let number = round * threads + thread as u64;
            let mut worker = workers[thread].lock().expect("no thread panicked");
            let worker = worker.get_or_insert_with(|| Worker::new(view, largest, room));
            worker.plan.clone_from(plan);
            let units = units(&view.settings, plan, number, paths);
            units
                .filter_map(|unit| {
                    worker.trace(&Task { unit, open: Vec::new(), channels }, &|| false)
                })
                .map(|taken| taken.waves)
                .collect()
        })
    };

    // Warm up: the operating system provides the memory of buffers when they are first used.
    take(largest, 0);
    let mut tried: Vec<_> = plans.iter().map(Tried::new).collect();
    for round in 0..rounds {
        for tried in &mut tried {
            tried.waves.extend(take(tried.plan, round).into_iter().map(sum));
        }
        tried = without_those_behind(tried, round);
        // Rotate, because the first plan of a round has the disadvantage of cold caches.
        tried.rotate_left(1);
    }
    tried
}

impl Effort {
    /// Returns the number of rounds if each of `threads` threads renders `paths` paths, and traces
    /// `paths_a_round` paths per round. Returns `None` if even the minimum number of rounds would
    /// take too long.
    fn rounds(self, paths: u64, paths_a_round: u64, threads: u64) -> Option<u64> {
        let [least, most] = self.rounds;
        // The maximum is the number of rounds of all threads together.
        let most = most.div_ceil(threads).max(least);
        let rounds = (paths / (self.share * paths_a_round)).min(most);
        (rounds >= least).then_some(rounds)
    }
}

/// Adds up the work of a thread for the units of a round.
fn sum(waves: Vec<WaveStats>) -> WaveStats {
    waves.iter().fold(WaveStats::default(), |mut sum, wave| {
        sum.add(wave);
        sum
    })
}

/// Returns units of about `paths` paths in total, of neighbouring pixels. Their position is number
/// `number` of a sequence that covers the image evenly (Roberts 2018, "The unreasonable
/// effectiveness of quasirandom sequences").
fn units(
    settings: &ImageSettings,
    plan: &Plan,
    number: u64,
    paths: u64,
) -> impl Iterator<Item = Unit> {
    let ImageSettings { width, height, spp, .. } = *settings;
    let wave = u64::from(plan.wave_size);
    let samples = spp.min(CHUNK);
    let parts = |whole: Tile, paths: u64| Grid::new(whole, paths / u64::from(samples));
    let image = parts(Tile { x: 0, y: 0, width, height }, paths);
    let at =
        |parts: u32, step: f64| ((0.5 + number as f64 * step).fract() * f64::from(parts)) as u32;
    let [columns, rows] = image.size();
    let around = image.part(at(columns, 0.754_877_666), at(rows, 0.569_840_291));
    parts(around, wave).map(move |tile| Unit { tile, first: 0, end: samples })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::Kernel;
    use crate::engine::SegmentPlan;
    use crate::scene::Scene;

    #[test]
    fn trials_are_short() {
        let effort = Effort { share: 10, rounds: [3, 12], first: 1 };
        let rounds = |paths, threads| effort.rounds(paths, 1000, threads);
        assert_eq!((rounds(29_999, 1), rounds(30_000, 1)), (None, Some(3)));
        assert_eq!((rounds(99_000, 1), rounds(999_000, 1)), (Some(9), Some(12)));
        assert_eq!((rounds(999_000, 2), rounds(999_000, 64)), (Some(6), Some(3)));
    }

    fn settings(side: u32, spp: u32) -> ImageSettings {
        let scene = Scene::load("cornell").unwrap();
        ImageSettings { width: side, height: side, spp, ..ImageSettings::of(&scene) }
    }

    fn plan() -> Plan {
        let (closest, occluded) = (Kernel::Flat, Kernel::Flat);
        let way = SegmentPlan { ordered: false, closest, occluded, shadows_ordered: false };
        Plan { wave_size: 1 << 14, segments: vec![way] }
    }

    #[test]
    fn units_come_from_all_over_the_image() {
        for (side, spp) in [(512, 64), (1024, 8), (1024, 256), (4096, 16), (40, 4096)] {
            let settings = settings(side, spp);
            let mut quarters = [0; 4];
            for number in 0..12 {
                let units: Vec<Unit> = units(&settings, &plan(), number, 1 << 15).collect();
                let paths: u64 = units.iter().map(Unit::paths).sum();
                assert!((1 << 14..=1 << 15).contains(&paths), "{side} {spp}: {paths} paths");
                for Unit { tile: Tile { x, y, width, height }, end, .. } in units {
                    assert!(end <= spp);
                    let (right, lower) = (x + width - 1, y + height - 1);
                    for (x, y) in [(x, y), (right, y), (x, lower), (right, lower)] {
                        quarters[(2 * x / side + 2 * (2 * y / side)) as usize] += 1;
                    }
                }
            }
            assert!(quarters.iter().all(|&n| n > 0), "{side} {spp}: {quarters:?}");
        }
    }
}
