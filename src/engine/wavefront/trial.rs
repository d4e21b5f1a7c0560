//! Trials: what might be fastest is tried, on all threads at the same time as in a render.

use std::ops::Range;
use std::sync::Mutex;

use rayon::ThreadPool;

use super::choice::{SEGMENTS, Tried, fastest, fastest_segment, without_those_far_behind};
use super::plan::{Plan, SegmentPlan, tile_size};
use super::{Prepared, Worker};
use crate::accel::Kernel;
use crate::engine::settings::RenderSettings;
use crate::engine::stats::WaveStats;
use crate::film::{Tile, Tiles};

/// Sizes of waves that are tried.
const SIZES: [u32; 4] = [1 << 13, 1 << 14, 1 << 15, 1 << 16];
/// Rounds of a trial: fewer tell nothing, more nothing new.
const ROUNDS: Range<u64> = 3..13;
/// A trial takes no more paths than one in so many of a render.
const SHARE: u64 = 32;

/// The fastest plan on waves from all over the image; in small renders the usual one.
pub(super) fn find_plan(prepared: &Prepared<'_>, pool: &ThreadPool) -> Plan {
    let settings = &prepared.settings;
    let mut plan = Plan::usual(prepared, pool.current_num_threads());

    let ways = each_way(prepared, &plan);
    let tried = try_all(prepared, pool, &ways);
    if !tried.is_empty() {
        plan.segments = (1..=SEGMENTS).map(|number| fastest_segment(&tried, number)).collect();
    }
    if settings.wave_size == 0 {
        let sizes = SIZES.map(|wave_size| Plan {
            wave_size,
            tile_size: tile_size(settings, wave_size, pool.current_num_threads()),
            ..plan.clone()
        });
        plan = fastest(&try_all(prepared, pool, &sizes)).map_or(plan, |size| size.plan.clone());
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

/// Takes the same paths by each of `plans`, round after round. Those far behind are left out; none is
/// left in a render that is too small for a trial.
fn try_all<'a>(prepared: &Prepared<'_>, pool: &ThreadPool, plans: &'a [Plan]) -> Vec<Tried<'a>> {
    // Tiles, ranges and buffers are those of the largest waves.
    let largest = plans.iter().max_by_key(|plan| plan.wave_size).expect("there are plans");
    let threads = pool.current_num_threads() as u64;
    let samples = Samples::new(&prepared.settings, largest);
    let rounds = rounds(prepared.settings.paths() / threads, threads, plans.len(), largest);
    if rounds < ROUNDS.start {
        return Vec::new();
    }
    for segment in plans.iter().flat_map(|plan| &plan.segments) {
        prepared.accelerator.prepare(segment.closest);
        prepared.accelerator.prepare(segment.occluded);
    }
    let worker = |_| Mutex::new(Worker::new(prepared, largest));
    let workers: Vec<_> = (0..threads).map(worker).collect();
    // All threads take their waves by the same plan at the same time.
    let take = |plan: &'a Plan, round: u64| {
        pool.broadcast(|thread| {
            let (tile, range) = samples.get(round * threads + thread.index() as u64);
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
        tried = without_those_far_behind(tried);
    }
    tried
}

/// Rounds of a trial of so many plans, where each of `threads` renders `paths`.
fn rounds(paths: u64, threads: u64, plans: usize, largest: &Plan) -> u64 {
    let paths_a_round = plans as u64 * u64::from(largest.wave_size);
    // Threads share the rounds that are enough, but for the fewest.
    let most = (ROUNDS.end - 1).div_ceil(threads).max(ROUNDS.start);
    (paths / (SHARE * paths_a_round)).min(most)
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

    fn plan(wave_size: u32) -> Plan {
        let way = SegmentPlan { ordered: false, closest: Kernel::Flat, occluded: Kernel::Flat };
        Plan { wave_size, tile_size: 16, segments: vec![way] }
    }

    #[test]
    fn trials_are_short() {
        let rounds = |paths, threads| rounds(paths, threads, 10, &plan(1 << 14));
        assert_eq!(rounds(1 << 20, 1), 0);
        assert_eq!((rounds(16_000_000, 1), rounds(1 << 40, 1)), (3, 12));
        assert_eq!((rounds(1 << 40, 2), rounds(1 << 40, 64)), (6, 3));
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
