//! The plan: how rays are traced. It decides the speed and never the image.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::connect::connect;
use super::extend::extend;
use super::generate::generate;
use super::shade::{Shaded, Shading};
use super::sort::sort;
use super::{Prepared, Wave};
use crate::accel::Kernel;
use crate::engine::stats::Endings;
use crate::film::{Tile, tiles};
use crate::limits;

/// How the wavefront engine works, found by measuring; given back, it repeats a run with the same
/// work and the same counts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Paths that a worker traces at once, 1 to [`limits::MAX_WAVE`].
    pub wave_size: u32,
    /// Side of the tiles that work is handed out in, 1 to [`limits::MAX_SIDE`].
    pub tile_size: u32,
    /// Of segments 1, 2, …; the last holds for all that follow.
    pub segments: Vec<SegmentPlan>,
}

/// How the rays of a segment are traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SegmentPlan {
    /// Whether rays that start near each other and go the same way are put together first. Camera
    /// rays are anyway.
    pub ordered: bool,
    /// Finds their closest hits.
    pub closest: Kernel,
    /// Finds whether the shadow rays from there are occluded.
    pub occluded: Kernel,
}

/// Paths of a wave: with fewer the last segments have too few, with more they leave the caches.
const WAVE: u32 = 1 << 14;
/// Segments that are told apart.
const SEGMENTS: usize = 4;
/// Renders of fewer paths are over before a measurement pays.
const WORTH_MEASURING: u64 = 1 << 19;
/// Waves that are measured at most, and so many paths are rendered for each.
const PROBES: u64 = 4;
const PATHS_A_PROBE: u64 = 1 << 21;
/// Times that each kernel is tried on a wave.
const ROUNDS: usize = 2;

impl Plan {
    /// The plan of segment number `segment`, from 1.
    pub(super) fn segment(&self, segment: u32) -> &SegmentPlan {
        let last = self.segments.len() - 1;
        &self.segments[last.min(segment as usize - 1)]
    }

    /// `Err` says which number is out of range.
    ///
    /// # Errors
    /// Where one is.
    pub fn check(&self) -> Result<(), String> {
        limits::check("wave_size", self.wave_size, limits::MAX_WAVE)?;
        limits::check("tile_size", self.tile_size, limits::MAX_SIDE)?;
        limits::check("number of segments", self.segments.len() as u32, limits::MAX_DEPTH)
    }

    /// What is mostly best for so many primitives.
    fn usual(prepared: &Prepared<'_>) -> Self {
        let primitives = prepared.scene.geometry().len();
        let [first, later] = match primitives {
            0..20 => [Kernel::Flat, Kernel::Flat],
            20..0x4000 => [Kernel::Beam, Kernel::Packet],
            _ => [Kernel::Beam, Kernel::Single],
        };
        let ordered = later == Kernel::Packet;
        let settings = &prepared.settings;
        let wave_size = if settings.wave_size == 0 { WAVE } else { settings.wave_size };
        Self {
            wave_size,
            tile_size: match settings.tile_size {
                0 => tile_size(settings.spp, wave_size),
                size => size,
            },
            segments: vec![
                SegmentPlan { ordered: false, closest: first, occluded: later },
                SegmentPlan { ordered, closest: later, occluded: later },
            ],
        }
    }

    /// The plan that is fastest on waves from all over the image, found by trying; in small renders
    /// the usual one.
    pub(super) fn measure(prepared: &Prepared<'_>) -> Self {
        let usual = Self::usual(prepared);
        let settings = &prepared.settings;
        let pixels = u64::from(settings.width) * u64::from(settings.height);
        let paths = pixels * u64::from(settings.spp);
        if paths < WORTH_MEASURING {
            return usual;
        }
        let probes = (paths / PATHS_A_PROBE).clamp(1, PROBES) as usize;
        let tiles = tiles(settings.width, settings.height, usual.tile_size);
        let mut wave = Wave::new(prepared, &usual);
        let mut trials = Trials::new(prepared);
        for probe in 0..probes {
            let tile = tiles[(2 * probe + 1) * tiles.len() / (2 * probes)];
            trials.run(prepared, &usual, tile, &mut wave);
        }
        Self { segments: trials.fastest(&usual), ..usual }
    }
}

/// The side of tiles that have enough paths for a wave.
fn tile_size(spp: u32, wave_size: u32) -> u32 {
    let mut side = 16;
    while side < 256 && side * side * spp.min(wave_size) < wave_size {
        side *= 2;
    }
    side
}

/// Seconds of every way of tracing the rays of each segment.
struct Trials {
    kernels: Vec<Kernel>,
    segments: Vec<Trial>,
}

#[derive(Clone)]
struct Trial {
    /// By kernel, of rays as they come, and in order.
    closest: [Sums; 2],
    /// Of putting them in order, more than of taking them as they come.
    ordering: f64,
    occluded: Sums,
    shadows: usize,
}

/// Seconds of each kernel.
#[derive(Clone)]
struct Sums(Vec<f64>);

impl Sums {
    /// Adds the least of some times of `trace` by each kernel, so that an interruption does not count.
    fn add(&mut self, kernels: &[Kernel], mut trace: impl FnMut(Kernel)) {
        let mut least = vec![f64::INFINITY; kernels.len()];
        for _ in 0..ROUNDS {
            for (&kernel, least) in kernels.iter().zip(&mut least) {
                *least = least.min(seconds(|| trace(kernel)).0);
            }
        }
        for (sum, least) in self.0.iter_mut().zip(least) {
            *sum += least;
        }
    }

    /// The fastest kernel and its seconds.
    fn fastest(&self, kernels: &[Kernel]) -> (Kernel, f64) {
        let all = kernels.iter().zip(&self.0);
        let least = all.min_by(|(_, a), (_, b)| a.total_cmp(b));
        let (&kernel, &seconds) = least.expect("some kernels always may win");
        (kernel, seconds)
    }
}

impl Trials {
    fn new(prepared: &Prepared<'_>) -> Self {
        let kernels: Vec<Kernel> =
            Kernel::ALL.into_iter().filter(|&k| prepared.accelerator.may_win(k)).collect();
        let none = Sums(vec![0.0; kernels.len()]);
        let closest = [none.clone(), none.clone()];
        let trial = Trial { closest, ordering: 0.0, occluded: none, shadows: 0 };
        Self { kernels, segments: vec![trial; SEGMENTS] }
    }

    /// Takes a wave of `tile` through the first segments, their rays in every way.
    fn run(&mut self, prepared: &Prepared<'_>, plan: &Plan, tile: Tile, wave: &mut Wave) {
        let Prepared { scene, settings, camera, accelerator, materials, surfaces, cells } =
            prepared;
        let Wave { paths, rays, hits, queues, shadows, next } = wave;
        let pixels = u64::from(tile.width) * u64::from(tile.height);
        let count = (pixels * u64::from(settings.spp)).min(u64::from(plan.wave_size));
        generate(camera, settings, tile, 0..count, paths, rays);
        for (segment, trial) in (1..=settings.depth).zip(&mut self.segments) {
            if segment > 1 {
                let (ordered, ()) = seconds(|| rays.order(next, paths));
                trial.closest[1].add(&self.kernels, |kernel| {
                    extend(accelerator, kernel, rays, hits, false);
                });
                let (taken, ()) = seconds(|| rays.take(next, paths));
                trial.ordering += ordered - taken;
            }
            trial.closest[0].add(&self.kernels, |kernel| {
                extend(accelerator, kernel, rays, hits, false);
            });
            sort(rays, hits, materials, queues);
            let shading = Shading { scene, settings, materials, surfaces, cells, segment };
            let endings = &mut Endings::default();
            shading.shade(queues, &mut Shaded { paths, next, shadows, endings });
            trial.shadows += shadows.rays.len();
            trial.occluded.add(&self.kernels, |kernel| {
                // The light is added each time, and never looked at.
                connect(accelerator, kernel, shadows, hits, paths, false);
            });
            if next.len() == 0 {
                break;
            }
        }
    }

    /// What took the least time; where nothing was traced, as before.
    fn fastest(&self, usual: &Plan) -> Vec<SegmentPlan> {
        let mut plans: Vec<SegmentPlan> = Vec::new();
        for trial in &self.segments {
            let (closest, as_they_come) = trial.closest[0].fastest(&self.kernels);
            if as_they_come == 0.0 {
                break;
            }
            let (in_order, seconds) = trial.closest[1].fastest(&self.kernels);
            let ordered = seconds > 0.0 && seconds + trial.ordering < as_they_come;
            let closest = if ordered { in_order } else { closest };
            plans.push(SegmentPlan { ordered, closest, occluded: usual.segment(1).occluded });
            if trial.shadows > 0 {
                let (occluded, _) = trial.occluded.fastest(&self.kernels);
                plans.last_mut().expect("just pushed").occluded = occluded;
            }
        }
        plans
    }
}

/// How long `f` takes.
fn seconds<T>(f: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let value = f();
    (start.elapsed().as_secs_f64(), value)
}
