//! Which plan is fastest on a scene, found by trying: all threads take waves at the same time, as in
//! a render, by every plan.

use std::sync::Mutex;

use rayon::ThreadPool;

use super::plan::{Plan, SegmentPlan, tile_size};
use super::{Prepared, Worker};
use crate::accel::Kernel;
use crate::engine::stats::{SegmentWork, Stage, Stopwatch, WaveStats};
use crate::film::{Tile, Tiles};

/// Segments that are told apart.
const SEGMENTS: usize = 4;
/// Sizes of waves that are tried.
const SIZES: [u32; 4] = [1 << 16, 1 << 15, 1 << 14, 1 << 13];
/// Plans that take so many times as long as the fastest are tried no more: so many that no
/// interruption makes it.
const FAR_BEHIND: f64 = 4.0;

/// How often plans are tried.
struct Effort {
    /// One round for so many paths that a thread renders: it takes 2% to 3% of the time of these.
    paths_a_round: u64,
    /// Rounds, fewer of which tell nothing, and more of which tell nothing new.
    rounds: [u64; 2],
}
const SEGMENT_EFFORT: Effort = Effort { paths_a_round: 1 << 22, rounds: [2, 12] };
const SIZE_EFFORT: Effort = Effort { paths_a_round: 1 << 23, rounds: [3, 8] };

impl Effort {
    /// Rounds where each of so many `threads` renders so many `paths`, if they are worth it.
    fn rounds(&self, paths: u64, threads: u64) -> Option<u64> {
        let [least, most] = self.rounds;
        let rounds = (paths / self.paths_a_round).min(most.div_ceil(threads)).max(least);
        (rounds * self.paths_a_round <= paths).then_some(rounds)
    }
}

/// The fastest plan, on waves from all over the image; in small renders the usual one.
pub(super) fn fastest(prepared: &Prepared<'_>, pool: &ThreadPool) -> Plan {
    let settings = &prepared.settings;
    let threads = pool.current_num_threads();
    let paths = settings.paths() / threads as u64;
    let mut plan = Plan::usual(prepared, threads);

    if let Some(rounds) = SEGMENT_EFFORT.rounds(paths, threads as u64) {
        let plans = each_way(prepared, &plan);
        let tried = try_all(prepared, pool, &plans, rounds);
        plan.segments =
            (1..=SEGMENTS as u32).map(|number| fastest_segment(&tried, number, &plan)).collect();
    }
    if let (0, Some(rounds)) = (settings.wave_size, SIZE_EFFORT.rounds(paths, threads as u64)) {
        let plans = SIZES.map(|wave_size| Plan {
            wave_size,
            tile_size: tile_size(settings, wave_size, threads),
            ..plan.clone()
        });
        let tried = try_all(prepared, pool, &plans, rounds);
        let all = |wave: &WaveStats| (wave.stage(Stage::Generate).active, wave.seconds());
        plan = least(&tried, |tried| tried.cost(all)).map_or(plan, |tried| tried.plan.clone());
    }
    plan
}

/// All that might be fastest: one way for all segments.
fn each_way(prepared: &Prepared<'_>, usual: &Plan) -> Vec<Plan> {
    let kernels = Kernel::ALL.into_iter().filter(|&k| prepared.accelerator.may_win(k));
    let ways = kernels.flat_map(|kernel| {
        // Layouts are made before the clock runs.
        prepared.accelerator.prepare(kernel);
        [false, true].map(|ordered| SegmentPlan { ordered, closest: kernel, occluded: kernel })
    });
    ways.map(|way| Plan { segments: vec![way], ..usual.clone() }).collect()
}

/// How the rays of a segment are traced in the least time.
fn fastest_segment(tried: &[Tried<'_>], number: u32, usual: &Plan) -> SegmentPlan {
    let closest = least(tried, |tried| tried.segment_cost(number, &[Stage::Extend, Stage::Order]));
    let occluded = least(tried, |tried| tried.segment_cost(number, &[Stage::Connect]));
    let (closest, occluded) =
        (closest.map(|tried| tried.plan.segments[0]), occluded.map(|tried| tried.plan.segments[0]));
    let before = usual.segment(number);
    SegmentPlan {
        ordered: number > 1 && closest.unwrap_or(*before).ordered,
        closest: closest.unwrap_or(*before).closest,
        occluded: occluded.unwrap_or(*before).occluded,
    }
}

/// Takes the same paths by each of `plans`, round after round. Those far behind are left out.
fn try_all<'a>(
    prepared: &Prepared<'_>,
    pool: &ThreadPool,
    plans: &'a [Plan],
    rounds: u64,
) -> Vec<Tried<'a>> {
    let settings = &prepared.settings;
    // Tiles and buffers are those of the largest waves.
    let largest = plans.iter().max_by_key(|plan| plan.wave_size).expect("there are plans");
    let tiles = Tiles::new(settings.width, settings.height, largest.tile_size);
    let worker = |_| Mutex::new(Worker::new(prepared, largest));
    let workers: Vec<_> = (0..pool.current_num_threads()).map(worker).collect();
    let tile = |round: u64, thread: usize| {
        let number = round * workers.len() as u64 + thread as u64;
        let place = (2 * number + 1) * tiles.count() / (2 * rounds * workers.len() as u64);
        tiles.get(place).expect("it is one of them")
    };
    let take = |round, plans: &[&'a Plan]| {
        pool.broadcast(|thread| {
            let mut worker = workers[thread.index()].lock().expect("no thread panicked");
            let tile = tile(round, thread.index());
            let paths = tile.pixels() * u64::from(settings.spp);
            let paths = paths.min(u64::from(largest.wave_size));
            plans.iter().map(|plan| worker.time(plan, tile, paths)).collect::<Vec<_>>()
        })
    };

    // Buffers come from the operating system when they are used first.
    take(0, &[largest]);
    let mut tried: Vec<_> = plans.iter().map(|plan| Tried { plan, waves: Vec::new() }).collect();
    for round in 0..rounds {
        let plans: Vec<&Plan> = tried.iter().map(|tried| tried.plan).collect();
        for waves in take(round, &plans) {
            tried.iter_mut().zip(waves).for_each(|(tried, wave)| tried.waves.push(wave));
        }
        let least = tried.iter().map(Tried::seconds).fold(f64::INFINITY, f64::min);
        tried.retain(|tried| tried.seconds() <= FAR_BEHIND * least);
    }
    tried
}

impl<'a> Worker<'a> {
    /// What it takes to trace the first `paths` of `tile` by `plan`.
    fn time(&mut self, plan: &'a Plan, tile: Tile, paths: u64) -> WaveStats {
        self.plan = plan;
        self.watch = Stopwatch::new();
        self.trace_all(tile, paths, &|_, _| ());
        std::mem::take(&mut self.watch.stats)
    }
}

/// A plan and what waves took by it, thread by thread and round by round.
struct Tried<'a> {
    plan: &'a Plan,
    waves: Vec<WaveStats>,
}

/// The one of the least cost, if any has one.
fn least<'b, 'a>(
    tried: &'b [Tried<'a>],
    cost: impl Fn(&Tried<'a>) -> Option<f64>,
) -> Option<&'b Tried<'a>> {
    let costs = tried.iter().filter_map(|tried| Some((tried, cost(tried)?)));
    costs.min_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(tried, _)| tried)
}

impl Tried<'_> {
    /// All that it took.
    fn seconds(&self) -> f64 {
        self.waves.iter().map(WaveStats::seconds).sum()
    }

    /// Seconds of `stages`, the first of which tells the rays, for paths on their segment `number`;
    /// `None` where there were none.
    fn segment_cost(&self, number: u32, stages: &[Stage]) -> Option<f64> {
        let last = SEGMENTS as u32;
        self.cost(|wave| {
            let segments = wave.segments.iter().zip(1..);
            let these = segments.filter(|&(_, n)| n == number || number == last && n > last);
            these.fold((0, 0.0), |(rays, seconds), (work, _): (&SegmentWork, u32)| {
                let taken = stages.iter().map(|&stage| work.stage(stage).seconds).sum::<f64>();
                (rays + work.stage(stages[0]).active, seconds + taken)
            })
        })
    }

    /// The sum of seconds of `work`, which tells rays and seconds of a wave; `None` without rays.
    /// Waves that took far longer a ray than most were interrupted, and count as those.
    fn cost(&self, work: impl Fn(&WaveStats) -> (u64, f64)) -> Option<f64> {
        let works: Vec<(u64, f64)> =
            self.waves.iter().map(work).filter(|&(rays, _)| rays > 0).collect();
        let mut each: Vec<f64> =
            works.iter().map(|&(rays, seconds)| seconds / rays as f64).collect();
        each.sort_by(f64::total_cmp);
        let most = 3.0 * *each.get(each.len() / 2)?;
        Some(works.iter().map(|&(rays, seconds)| seconds.min(most * rays as f64)).sum())
    }
}
