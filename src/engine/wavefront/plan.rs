//! The plan: how rays are traced. It decides the speed and never the image.

use std::ops::Range;
use std::time::Instant;

use serde::{Deserialize, Serialize};

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
const PROBES: u64 = 16;
const PATHS_A_PROBE: u64 = 1 << 20;
/// Times that each kernel is tried on a wave.
const ROUNDS: usize = 2;
/// Has no divisor in common with any number of probes.
const STRIDE: usize = 17;
/// Kernels that take so many times as long as the fastest are tried no more.
const FAR_BEHIND: f64 = 1.5;
/// Rays of the first heat, for kernels that would take very long for all.
const HEAT: usize = 512;
/// What measuring may take of the time that rendering will, after the fewest waves.
const SHARE: f64 = 0.05;
const FEWEST_PROBES: usize = 6;

impl Plan {
    /// The plan of segment number `segment`, from 1.
    pub fn segment(&self, segment: u32) -> &SegmentPlan {
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
        let (start, mut measured) = (Instant::now(), 0);
        for probe in 0..probes {
            // Neighbouring probes are far apart, so that fewer than all still come from all over.
            let place = probe * STRIDE % probes;
            let tile = tiles[(2 * place + 1) * tiles.len() / (2 * probes)];
            measured += trials.run(prepared, &usual, tile, &mut wave);
            let rendering = trials.least() / measured as f64 * paths as f64;
            // The first may all have seen the sky.
            if probe + 1 >= FEWEST_PROBES && start.elapsed().as_secs_f64() > SHARE * rendering {
                break;
            }
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
    /// Adds the least of some times of `trace` by each kernel over `rays` rays, so that an interruption
    /// does not count. Those that are far behind are out of the race, if it can be on some rays.
    fn add(
        &mut self,
        kernels: &[Kernel],
        rays: usize,
        mut trace: impl FnMut(Kernel, Range<usize>),
    ) {
        let middle = rays / 2..rays.min(rays / 2 + HEAT);
        for (range, far_behind) in [(middle, 2.0 * FAR_BEHIND), (0..rays, FAR_BEHIND)] {
            let mut least = vec![f64::INFINITY; kernels.len()];
            for _ in 0..ROUNDS {
                for ((&kernel, least), sum) in kernels.iter().zip(&mut least).zip(&self.0) {
                    if sum.is_finite() {
                        *least = least.min(seconds(|| trace(kernel, range.clone())).0);
                    }
                }
            }
            let best = least.iter().copied().fold(f64::INFINITY, f64::min);
            for (sum, least) in self.0.iter_mut().zip(least) {
                *sum += if least > far_behind * best { f64::INFINITY } else { least };
            }
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
    /// Returns their number.
    fn run(&mut self, prepared: &Prepared<'_>, plan: &Plan, tile: Tile, wave: &mut Wave) -> u64 {
        let Prepared { scene, settings, camera, accelerator, materials, surfaces, cells } =
            prepared;
        let Wave { paths, rays, hits, queues, shadows, next } = wave;
        let pixels = u64::from(tile.width) * u64::from(tile.height);
        let count = (pixels * u64::from(settings.spp)).min(u64::from(plan.wave_size));
        generate(camera, settings, tile, 0..count, paths, rays);
        for (segment, trial) in (1..=settings.depth).zip(&mut self.segments) {
            if segment > 1 {
                hits.reset(next.len());
                let (ordered, ()) = seconds(|| rays.order(next, paths));
                trial.closest[1].add(&self.kernels, rays.len(), |kernel, range| {
                    accelerator.closest(kernel, &rays.batch, range, hits);
                });
                let (taken, ()) = seconds(|| rays.take(next, paths));
                trial.ordering += ordered - taken;
            }
            hits.reset(rays.len());
            trial.closest[0].add(&self.kernels, rays.len(), |kernel, range| {
                accelerator.closest(kernel, &rays.batch, range, hits);
            });
            extend(accelerator, trial.closest[0].fastest(&self.kernels).0, rays, hits, false);
            sort(rays, hits, materials, queues);
            let shading = Shading { scene, settings, materials, surfaces, cells, segment };
            let endings = &mut Endings::default();
            shading.shade(queues, &mut Shaded { paths, next, shadows, endings });
            trial.shadows += shadows.rays.len();
            if !shadows.rays.is_empty() {
                hits.reset(shadows.rays.len());
                trial.occluded.add(&self.kernels, shadows.rays.len(), |kernel, range| {
                    accelerator.occluded(kernel, &shadows.rays, range, hits);
                });
            }
            if next.len() == 0 {
                break;
            }
        }
        count
    }

    /// The least seconds of all rays.
    fn least(&self) -> f64 {
        let trials = self.segments.iter().flat_map(|trial| [&trial.closest[0], &trial.occluded]);
        trials.map(|sums| sums.fastest(&self.kernels).1).sum()
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
