//! Trials: what might be fastest is tried, on all threads at the same time as in a render.

use std::ops::Range;
use std::sync::Mutex;

use rayon::ThreadPool;

use super::choice::{SEGMENTS, Tried, fastest, fastest_segment, without_those_behind};
use super::plan::{Plan, SegmentPlan, tile_size};
use super::{Prepared, Worker};
use crate::accel::Kernel;
use crate::engine::settings::RenderSettings;
use crate::engine::stats::WaveStats;
use crate::film::{Tile, Tiles};

/// Sizes of waves that are tried.
const SIZES: [u32; 3] = [1 << 13, 1 << 14, 1 << 15];
/// How long a trial may be.
#[derive(Clone, Copy)]
struct Effort {
    /// One path for so many of a render.
    share: u64,
    /// Fewer rounds tell nothing, more nothing new.
    rounds: [u64; 2],
}
/// Ways differ by factors, ...
const WAYS_EFFORT: Effort = Effort { share: 32, rounds: [3, 12] };
/// ... sizes by a few percent, and the parts of an image differ more.
const SIZES_EFFORT: Effort = Effort { share: 48, rounds: [6, 12] };

/// The fastest plan on waves from all over the image; in small renders the usual one.
pub(super) fn find_plan(prepared: &Prepared<'_>, pool: &ThreadPool) -> Plan {
    let settings = &prepared.settings;
    let mut plan = Plan::usual(prepared, pool.current_num_threads());

    let ways = each_way(prepared, &plan);
    let tried = try_all(prepared, pool, &ways, WAYS_EFFORT);
    if !tried.is_empty() {
        plan.segments = (1..=SEGMENTS).map(|number| fastest_segment(&tried, number)).collect();
    }
    if settings.wave_size == 0 {
        let sizes = SIZES.map(|wave_size| Plan {
            wave_size,
            tile_size: tile_size(settings, wave_size, pool.current_num_threads()),
            ..plan.clone()
        });
        let tried = try_all(prepared, pool, &sizes, SIZES_EFFORT);
        plan = fastest(&tried).map_or(plan, |size| size.plan.clone());
    }
    plan
}

/// All ways that might be fastest, each for all segments.
fn each_way(prepared: &Prepared<'_>, usual: &Plan) -> Vec<Plan> {
    let kernels = Kernel::ALL.into_iter().filter(|&k| prepared.accelerator.may_win(k));
    let ways = kernels.flat_map(|kernel| {
        [false, true].map(|ordered| SegmentPlan { ordered, closest: kernel, occluded: kernel })
    });
    ways.map(|way| Plan { segments: vec![way], ..usual.clone() }).collect()
}

/// Takes the same paths by each of `plans`, round after round. Those that fall behind are left out;
/// none is left in a render that is too small for a trial.
fn try_all<'a>(
    prepared: &Prepared<'_>,
    pool: &ThreadPool,
    plans: &'a [Plan],
    effort: Effort,
) -> Vec<Tried<'a>> {
    // Tiles, ranges and buffers are those of the largest waves.
    let largest = plans.iter().max_by_key(|plan| plan.wave_size).expect("there are plans");
    let threads = pool.current_num_threads() as u64;
    let samples = Samples::new(&prepared.settings, largest);
    let paths_a_round = plans.len() as u64 * u64::from(largest.wave_size);
    let paths = prepared.settings.paths() / threads;
    let Some(rounds) = effort.rounds(paths, paths_a_round, threads) else { return Vec::new() };
    for segment in plans.iter().flat_map(|plan| &plan.segments) {
        prepared.accelerator.prepare(segment.closest);
        prepared.accelerator.prepare(segment.occluded);
    }
    let worker = |_| Mutex::new(Worker::new(prepared, largest));
    let workers: Vec<_> = (0..threads).map(worker).collect();
    // All threads take their waves by the same plan at the same time.
    let take = |plan: &'a Plan, round: u64| {
        pool.broadcast(|thread| {
            let (tile, mut range) = samples.get(round * threads + thread.index() as u64);
            if round == 0 {
                // Some plans are slow beyond measure, which few paths show.
                range.end -= (range.end - range.start) / 4 * 3;
            }
            let mut worker = workers[thread.index()].lock().expect("no thread panicked");
            worker.reset(plan);
            worker.trace_all(tile, range, &|_, _| ());
            std::mem::take(&mut worker.watch.stats)
        })
    };

    // Buffers come from the operating system when they are used first.
    take(largest, 0);
    let mut tried: Vec<_> = plans.iter().map(Tried::new).collect();
    for round in 0..rounds {
        // No plan is always the first, for which nothing is in the caches yet.
        let first = round as usize % tried.len();
        tried.rotate_left(first);
        for tried in &mut tried {
            tried.waves.extend::<Vec<WaveStats>>(take(tried.plan, round));
        }
        tried = without_those_behind(tried);
    }
    tried
}

impl Effort {
    /// Rounds where each of `threads` renders `paths` and takes `paths_a_round`; `None` where the
    /// fewest would be too many.
    fn rounds(self, paths: u64, paths_a_round: u64, threads: u64) -> Option<u64> {
        let [least, most] = self.rounds;
        // Threads share the rounds that are enough.
        let most = most.div_ceil(threads).max(least);
        let rounds = (paths / (self.share * paths_a_round)).min(most);
        (rounds >= least).then_some(rounds)
    }
}

/// Waves from all over an image.
struct Samples {
    size: (u32, u32),
    tiles: Tiles,
    spp: u64,
    wave_size: u64,
}

impl Samples {
    fn new(settings: &RenderSettings, plan: &Plan) -> Self {
        let (width, height) = (settings.width, settings.height);
        Self {
            size: (width, height),
            tiles: Tiles::new(width, height, plan.tile_size),
            spp: settings.spp.into(),
            wave_size: plan.wave_size.into(),
        }
    }

    /// A tile, and the range of its paths from which a wave comes. It begins at pixel number `number` of
    /// a sequence that spreads in both directions (Roberts 2018, "The unreasonable effectiveness of
    /// quasirandom sequences").
    fn get(&self, number: u64) -> (Tile, Range<u64>) {
        let place =
            |side: u32, step: f64| ((0.5 + number as f64 * step).fract() * f64::from(side)) as u32;
        let (x, y) = (place(self.size.0, 0.754_877_666), place(self.size.1, 0.569_840_291));
        let tile = self.tiles.at(x, y);
        let paths = tile.pixels() * self.spp;
        let pixel = u64::from(y - tile.y) * u64::from(tile.width) + u64::from(x - tile.x);
        let first = (pixel * self.spp).min(paths.saturating_sub(self.wave_size));
        (tile, first..paths.min(first + self.wave_size))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trials_are_short() {
        let effort = Effort { share: 10, rounds: [3, 12] };
        let rounds = |paths, threads| effort.rounds(paths, 1000, threads);
        assert_eq!((rounds(29_999, 1), rounds(30_000, 1)), (None, Some(3)));
        assert_eq!((rounds(99_000, 1), rounds(999_000, 1)), (Some(9), Some(12)));
        assert_eq!((rounds(999_000, 2), rounds(999_000, 64)), (Some(6), Some(3)));
    }

    #[test]
    fn samples_come_from_all_over_the_image() {
        for (side, spp) in [(512, 64), (1024, 8), (1024, 256), (4096, 16), (40, 4096)] {
            let (tiles, wave_size) = (Tiles::new(side, side, 32), 1 << 14);
            let samples = Samples { size: (side, side), tiles, spp, wave_size };
            let mut quarters = [0; 4];
            for number in 0..12 {
                let (tile, range) = samples.get(number);
                assert!(range.start < range.end && range.end <= tile.pixels() * spp);
                assert!(range.end - range.start <= wave_size);
                let (x, y) = tile.pixel((range.start / spp) as u32);
                quarters[(2 * x / side + 2 * (2 * y / side)) as usize] += 1;
            }
            assert!(quarters.iter().all(|&n| n > 0), "{side} {spp}: {quarters:?}");
        }
    }
}
