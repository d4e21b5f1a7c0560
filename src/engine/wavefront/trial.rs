//! Trials: what might be fastest is tried, on all threads at the same time as in a render.

use std::sync::Mutex;

use super::choice::{PLANNED, Tried, fastest, fastest_segment, without_those_behind};
use super::wave::Worker;
use crate::accel::Kernel;
use crate::engine::plan::{Plan, Planning, SegmentPlan};
use crate::engine::pool::Pool;
use crate::engine::prepared::View;
use crate::engine::settings::RenderSettings;
use crate::engine::stats::WaveStats;
use crate::engine::unit::Task;
use crate::film::{CHUNK, Grid, Tile, Unit};

/// Sizes of waves that are tried.
const SIZES: [u32; 3] = [1 << 13, 1 << 14, 1 << 15];

/// How long a trial may be.
#[derive(Clone, Copy)]
struct Effort {
    /// One path for so many of a render.
    share: u64,
    /// Fewer rounds tell nothing, more nothing new.
    rounds: [u64; 2],
    /// The first round is so many times shorter: what is slow beyond measure shows at once.
    first: u64,
}

/// Ways differ by factors, ...
const WAYS_EFFORT: Effort = Effort { share: 32, rounds: [3, 12], first: 4 };
/// ... sizes by a few percent, and the parts of an image differ more.
const SIZES_EFFORT: Effort = Effort { share: 48, rounds: [6, 12], first: 1 };

/// The fastest plan on waves from all over the image; in renders of few `paths` the usual one. And whether it was
/// measured.
pub(super) fn find_plan(view: &View, paths: u64, pool: &Pool) -> (Plan, Planning) {
    // Counting takes time.
    let settings = RenderSettings { count: false, ..view.settings.clone() };
    let (view, settings) = (&View { settings: settings.clone(), ..view.clone() }, &settings);
    let primitives = view.scene().geometry().len();
    let usual = Plan::usual(primitives, paths, pool.threads(), settings.wave_size);

    let ways = each_way(view, &usual);
    let tried = try_all(view, paths, pool, &ways, WAYS_EFFORT);
    let ways_tried = !tried.is_empty();
    let planned = 1..=settings.depth.min(PLANNED);
    let segment = |number| fastest_segment(&tried, number, usual.segment(number));
    let plan = match tried.as_slice() {
        [] => usual,
        _ => Plan { segments: planned.map(segment).collect(), ..usual },
    };

    let sizes = each_size(settings, &plan);
    let tried = try_all(view, paths, pool, &sizes, SIZES_EFFORT);
    let planning =
        if ways_tried || !tried.is_empty() { Planning::Measured } else { Planning::Usual };
    (fastest(&tried).map_or(plan, |size| size.plan.clone()), planning)
}

/// `plan` with each size of waves that may be chosen.
fn each_size(settings: &RenderSettings, plan: &Plan) -> Vec<Plan> {
    let sizes = SIZES.map(|wave_size| Plan { wave_size, ..plan.clone() });
    sizes.into_iter().filter(|_| settings.wave_size == 0).collect()
}

/// All ways that might be fastest, each for all segments.
fn each_way(view: &View, usual: &Plan) -> Vec<Plan> {
    let kernels = Kernel::ALL.into_iter().filter(|&k| view.prepared.accelerator().may_win(k));
    let ways = kernels.flat_map(|kernel| {
        [false, true].map(|ordered| SegmentPlan { ordered, closest: kernel, occluded: kernel })
    });
    ways.map(|way| Plan { segments: vec![way], ..usual.clone() }).collect()
}

/// Takes paths from the same places by each of `plans`, round after round. Those that fall behind are
/// left out; none is left in a render that is too small for a trial.
fn try_all<'a>(
    view: &View,
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
        view.prepared.accelerator().prepare(segment.closest);
        view.prepared.accelerator().prepare(segment.occluded);
    }
    let workers: Vec<_> = (0..threads).map(|_| Mutex::new(None)).collect();
    // A pixel may have more than a wave.
    let room = paths.max(u64::from(CHUNK));
    // All threads take their waves by the same plan at the same time.
    let take = |plan: &'a Plan, round: u64| {
        let paths = if round == 0 { paths.div_ceil(effort.first) } else { paths };
        pool.broadcast(|thread: usize| {
            let number = round * threads + thread as u64;
            let mut worker = workers[thread].lock().expect("no thread panicked");
            let worker = worker.get_or_insert_with(|| Worker::new(view, largest, room));
            worker.plan = plan;
            let units = units(&view.settings, plan, number, paths);
            units
                .filter_map(|unit| worker.trace(&Task { unit, open: Vec::new() }, &|| false))
                .map(|taken| taken.waves)
                .collect()
        })
    };

    // Buffers come from the operating system when they are used first.
    take(largest, 0);
    let mut tried: Vec<_> = plans.iter().map(Tried::new).collect();
    for round in 0..rounds {
        for tried in &mut tried {
            tried.waves.extend(take(tried.plan, round).into_iter().map(sum));
        }
        tried = without_those_behind(tried, round);
        // Each is the first in its turn, for which nothing is in the caches yet.
        tried.rotate_left(1);
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

/// What a thread did for the units of a trial.
fn sum(waves: Vec<WaveStats>) -> WaveStats {
    waves.iter().fold(WaveStats::default(), |mut sum, wave| {
        sum.add(wave);
        sum
    })
}

/// The units that a trial takes, about so many paths: of neighbouring pixels at place number `number` of a
/// sequence that spreads in both directions (Roberts 2018, "The unreasonable effectiveness of
/// quasirandom sequences").
fn units(
    settings: &RenderSettings,
    plan: &Plan,
    number: u64,
    paths: u64,
) -> impl Iterator<Item = Unit> {
    let RenderSettings { width, height, spp, .. } = *settings;
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
    use crate::engine::pool::Pin;
    use crate::scene::Scene;

    #[test]
    fn trials_are_short() {
        let effort = Effort { share: 10, rounds: [3, 12], first: 1 };
        let rounds = |paths, threads| effort.rounds(paths, 1000, threads);
        assert_eq!((rounds(29_999, 1), rounds(30_000, 1)), (None, Some(3)));
        assert_eq!((rounds(99_000, 1), rounds(999_000, 1)), (Some(9), Some(12)));
        assert_eq!((rounds(999_000, 2), rounds(999_000, 64)), (Some(6), Some(3)));
    }

    fn settings(side: u32, spp: u32) -> RenderSettings {
        let scene = Scene::load("cornell").unwrap();
        RenderSettings { width: side, height: side, spp, ..RenderSettings::of(&scene) }
    }

    fn plan() -> Plan {
        let way = SegmentPlan { ordered: false, closest: Kernel::Flat, occluded: Kernel::Flat };
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
                    for (x, y) in [(x, y), (x + width - 1, y + height - 1)] {
                        quarters[(2 * x / side + 2 * (2 * y / side)) as usize] += 1;
                    }
                }
            }
            assert!(quarters.iter().all(|&n| n > 0), "{side} {spp}: {quarters:?}");
        }
    }

    #[test]
    fn sizes_are_tried_where_none_is_given() {
        let sizes = |settings: &RenderSettings| -> Vec<u32> {
            each_size(settings, &plan()).iter().map(|plan| plan.wave_size).collect()
        };
        let large = settings(400, 100);
        assert_eq!(sizes(&large), SIZES);
        assert!(sizes(&RenderSettings { wave_size: 5000, ..large.clone() }).is_empty());

        let scene = Scene::load("cornell").unwrap();
        let render = |spp| RenderSettings { spp, threads: 1, depth: 2, ..large.clone() };
        let pool = Pool::start(1, Pin::Off).unwrap();
        let tried = |spp| {
            let settings = render(spp);
            let view = View::new((&scene).into(), settings.clone());
            let sizes = each_size(&settings, &plan());
            let tried = |paths| try_all(&view, paths, &pool, &sizes, SIZES_EFFORT).len();
            [tried(settings.paths()), tried(settings.paths() / 2)]
        };
        assert_eq!(tried(100), [0, 0]);
        // How many fall behind is chance's; a half of it, as a shard is, is too small again.
        let [whole, half] = tried(200);
        assert!(whole > 0 && half == 0);
    }
}
