//! Which plan is fastest on a scene, found by trying: whole waves, each in every way.

use super::plan::{Plan, SegmentPlan};
use super::{Prepared, Wave, Worker};
use crate::accel::Kernel;
use crate::engine::stats::{Stage, WaveStats};
use crate::film::{Tile, tiles};

/// Segments that are told apart.
const SEGMENTS: usize = 4;
/// Renders of fewer paths are over before a trial pays.
const WORTH_TRYING: u64 = 1 << 20;
/// Waves that are tried at most, one for so many paths that are rendered.
const MOST_WAVES: u64 = 12;
const PATHS_A_WAVE: u64 = 1 << 21;
/// Ways that take so many times as long as the fastest are tried no more: so many that no
/// interruption makes it.
const FAR_BEHIND: f64 = 4.0;

/// The fastest plan on waves from all over the image; in small renders the usual one.
pub(super) fn fastest(prepared: &Prepared<'_>) -> Plan {
    let usual = Plan::usual(prepared);
    let settings = &prepared.settings;
    let pixels = u64::from(settings.width) * u64::from(settings.height);
    let paths = pixels * u64::from(settings.spp);
    if paths < WORTH_TRYING {
        return usual;
    }
    let mut ways = Way::all(prepared, &usual);
    let tiles = tiles(settings.width, settings.height, usual.tile_size);
    let waves = (paths / PATHS_A_WAVE).clamp(2, MOST_WAVES) as usize;
    let mut buffers = Wave::new(prepared, &usual);
    for wave in 0..waves {
        let tile = tiles[(2 * wave + 1) * tiles.len() / (2 * waves)];
        for way in &mut ways {
            buffers = way.run(prepared, tile, buffers);
        }
        let least = ways.iter().map(Way::seconds).fold(f64::INFINITY, f64::min);
        ways.retain(|way| way.seconds() <= FAR_BEHIND * least);
    }
    let segment = |segment| fastest_of(&ways, segment, &usual);
    Plan { segments: (1..=SEGMENTS as u32).map(segment).collect(), ..usual }
}

/// How the rays of a segment are traced in the least time.
fn fastest_of(ways: &[Way], segment: u32, usual: &Plan) -> SegmentPlan {
    let closest = least(ways, |way| way.cost(segment, &[Stage::Extend, Stage::Order]));
    let occluded = least(ways, |way| way.cost(segment, &[Stage::Connect]));
    let before = usual.segment(segment);
    SegmentPlan {
        ordered: segment > 1 && closest.map_or(before.ordered, |way| way.how.ordered),
        closest: closest.map_or(before.closest, |way| way.how.closest),
        occluded: occluded.map_or(before.occluded, |way| way.how.occluded),
    }
}

/// The way of the least cost, if any has one.
fn least(ways: &[Way], cost: impl Fn(&Way) -> Option<f64>) -> Option<&Way> {
    let costs = ways.iter().filter_map(|way| Some((way, cost(way)?)));
    costs.min_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(way, _)| way)
}

/// A way of tracing all segments, and what it took, wave by wave.
struct Way {
    how: SegmentPlan,
    plan: Plan,
    waves: Vec<WaveStats>,
}

impl Way {
    /// All that might be fastest.
    fn all(prepared: &Prepared<'_>, usual: &Plan) -> Vec<Self> {
        let kernels = Kernel::ALL.into_iter().filter(|&k| prepared.accelerator.may_win(k));
        let hows = kernels.flat_map(|kernel| {
            // Layouts are made before the clock runs.
            prepared.accelerator.prepare(kernel);
            [false, true].map(|ordered| SegmentPlan { ordered, closest: kernel, occluded: kernel })
        });
        let way = |how| {
            let plan = Plan { segments: vec![how], ..usual.clone() };
            Self { how, plan, waves: Vec::new() }
        };
        hows.map(way).collect()
    }

    /// Takes a wave of `tile` from the camera to its end.
    fn run(&mut self, prepared: &Prepared<'_>, tile: Tile, buffers: Wave) -> Wave {
        let pixels = u64::from(tile.width) * u64::from(tile.height);
        let paths = pixels * u64::from(prepared.settings.spp);
        let mut worker = Worker::new(prepared, &self.plan, buffers);
        worker.trace(tile, 0..paths.min(u64::from(self.plan.wave_size)));
        self.waves.push(worker.watch.stats);
        worker.wave
    }

    /// All that it took.
    fn seconds(&self) -> f64 {
        let seconds = |wave: &WaveStats| Stage::ALL.map(|stage| wave.stage(stage).seconds);
        self.waves.iter().flat_map(seconds).sum()
    }

    /// Seconds of `stages`, the first of which tells the rays, for paths on their segment `segment`;
    /// `None` where there were none.
    /// Waves that took far longer a ray than most were interrupted, and count as those.
    fn cost(&self, segment: u32, stages: &[Stage]) -> Option<f64> {
        let last = SEGMENTS as u32;
        let work = |wave: &WaveStats| {
            let (mut rays, mut seconds) = (0, 0.0);
            for (works, number) in wave.segments.iter().zip(1..) {
                if number == segment || segment == last && number > last {
                    rays += works[stages[0] as usize].active;
                    seconds += stages.iter().map(|&s| works[s as usize].seconds).sum::<f64>();
                }
            }
            (rays, seconds)
        };
        let works: Vec<(u64, f64)> =
            self.waves.iter().map(work).filter(|&(rays, _)| rays > 0).collect();
        let mut each: Vec<f64> =
            works.iter().map(|&(rays, seconds)| seconds / rays as f64).collect();
        each.sort_by(f64::total_cmp);
        let most = 3.0 * *each.get(each.len() / 2)?;
        Some(works.iter().map(|&(rays, seconds)| seconds.min(most * rays as f64)).sum())
    }
}
