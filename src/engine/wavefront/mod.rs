//! The wavefront engine: waves of paths go through stages, each a loop over vectors of them.

mod accumulate;
mod cells;
mod choice;
mod collide;
mod columns;
mod connect;
mod extend;
mod generate;
mod light;
mod materials;
mod order;
mod paths;
mod plan;
mod rays;
mod shade;
mod sort;
mod trial;

use std::ops::Range;
use std::time::Instant;

use rayon::ThreadPool;

use super::renderer::{TileEngine, TileResult, TileWorker};
use super::settings::RenderSettings;
use super::stats::{Stage, StageWork, Stopwatch};
use super::tally::Endings;
use crate::accel::{Accelerator, HitBatch};
use crate::film::{PixelSum, Tile};
use crate::geometry::lanes::Surfaces;
use crate::scene::{CameraFrame, Scene};
use accumulate::accumulate;
use cells::Cells;
use collide::collide;
use connect::{Shadows, connect};
use extend::extend;
use generate::generate;
use light::LightTable;
use materials::Materials;
use order::{Next, order};
use paths::Paths;
use plan::wave_length;
pub use plan::{Plan, Planning, SegmentPlan};
use rays::Rays;
use shade::{Shaded, Shading};
use sort::{Queue, sort};

/// A scene that is ready to be rendered, and how.
#[derive(Debug)]
pub(super) struct WavefrontEngine<'a> {
    prepared: Prepared<'a>,
    plan: Plan,
    planning: Planning,
    plan_seconds: f64,
}

/// A scene as vectors read it.
#[derive(Debug)]
struct Prepared<'a> {
    scene: &'a Scene,
    settings: RenderSettings,
    camera: CameraFrame,
    accelerator: Accelerator<'a>,
    materials: Materials,
    lights: LightTable,
    surfaces: Surfaces<'a>,
    cells: Cells,
}

impl<'a> Prepared<'a> {
    fn new(scene: &'a Scene, settings: &RenderSettings) -> Self {
        let accelerator = Accelerator::new(scene.geometry(), scene.camera().shutter());
        Self {
            scene,
            settings: settings.clone(),
            camera: scene.camera().frame(settings.width, settings.height),
            materials: Materials::new(scene),
            lights: LightTable::new(scene.lights()),
            surfaces: Surfaces::new(scene.geometry()),
            cells: Cells::new(&accelerator.bounds()),
            accelerator,
        }
    }
}

impl<'a> WavefrontEngine<'a> {
    pub(super) fn new(scene: &'a Scene, settings: &RenderSettings, pool: &ThreadPool) -> Self {
        // A plan is found without counting, which takes time.
        let uncounted = RenderSettings { count: false, ..settings.clone() };
        let mut prepared = Prepared::new(scene, &uncounted);
        let start = Instant::now();
        let (plan, planning) = match &settings.plan {
            Some(plan) => (plan.clone(), Planning::Given),
            None => trial::find_plan(&prepared, pool),
        };
        let plan_seconds = start.elapsed().as_secs_f64();
        prepared.settings.count = settings.count;
        for segment in &plan.segments {
            prepared.accelerator.prepare(segment.closest);
            prepared.accelerator.prepare(segment.occluded);
        }
        Self { prepared, plan, planning, plan_seconds }
    }
}

impl TileEngine for WavefrontEngine<'_> {
    fn worker(&self) -> Box<dyn TileWorker + '_> {
        Box::new(Worker::new(&self.prepared, &self.plan))
    }

    fn tile_size(&self) -> u32 {
        self.plan.tile_size
    }

    fn plan(&self) -> Option<(&Plan, Planning, f64)> {
        Some((&self.plan, self.planning, self.plan_seconds))
    }
}

/// Paths on their way, and what their stages hand to each other. Its size depends on the plan and on
/// the kinds of materials, not on the image or its samples.
#[derive(Debug)]
struct Wave {
    paths: Paths,
    /// The rays that are traced next.
    rays: Rays,
    /// What they hit.
    hits: HitBatch,
    /// Paths by what they have hit.
    queues: Vec<Queue>,
    shadows: Shadows,
    /// Paths that go on.
    next: Next,
}

impl Wave {
    /// Room for `capacity` paths.
    fn new(prepared: &Prepared<'_>, capacity: usize) -> Self {
        let shadows = if prepared.settings.samples_lights(prepared.scene) { capacity } else { 0 };
        let queue = |_: &_| Queue::with_capacity(capacity);
        Self {
            paths: Paths::new(capacity),
            rays: Rays::with_capacity(capacity),
            hits: HitBatch::default(),
            queues: prepared.materials.bins.iter().map(queue).collect(),
            shadows: Shadows::with_capacity(shadows),
            next: Next::with_capacity(capacity),
        }
    }
}

/// A thread's wave, and what comes of it.
#[derive(Debug)]
struct Worker<'a> {
    prepared: &'a Prepared<'a>,
    plan: &'a Plan,
    wave: Wave,
    /// The pixel whose samples are being added.
    sum: PixelSum,
    result: TileResult,
    watch: Stopwatch,
}

impl<'a> Worker<'a> {
    fn new(prepared: &'a Prepared<'a>, plan: &'a Plan) -> Self {
        let paths = plan.tile_paths(&prepared.settings);
        let capacity = paths.min(u64::from(plan.wave_size)) as usize;
        Self {
            prepared,
            plan,
            wave: Wave::new(prepared, capacity),
            sum: PixelSum::default(),
            result: TileResult::default(),
            watch: Stopwatch::new(prepared.settings.timeline),
        }
    }

    /// Starts over, by another plan.
    fn reset(&mut self, plan: &'a Plan) {
        self.plan = plan;
        self.sum = PixelSum::default();
        self.result = TileResult::default();
        self.watch = Stopwatch::new(false);
    }

    /// Takes the paths number `range` of `tile` wave after wave. Tells `report` how many paths and
    /// rays these were.
    fn trace_all(&mut self, tile: Tile, range: Range<u64>, report: &dyn Fn(u64, u64)) {
        let paths = tile.pixels() * u64::from(self.prepared.settings.spp);
        let length = wave_length(paths, self.plan.wave_size);
        for first in range.clone().step_by(length as usize) {
            let end = range.end.min(first + length);
            let before = self.result.tally.rays.total();
            self.trace(tile, first..end);
            report(end - first, self.result.tally.rays.total() - before);
        }
    }

    /// Takes the paths number `range` of `tile` from the camera to the film.
    ///
    /// Stages are not inlined: each has the registers for itself, and profiles tell them apart.
    fn trace(&mut self, tile: Tile, range: Range<u64>) {
        let Self { prepared, plan, wave, sum, result, watch } = self;
        let Prepared { scene, settings, camera, accelerator, materials, lights, surfaces, cells } =
            prepared;
        let Wave { paths, rays, hits, queues, shadows, next } = wave;
        watch.start();

        generate(camera, settings, tile, range.clone(), paths, rays);
        result.tally.rays.primary += rays.len() as u64;
        watch.lap(Stage::Generate, 1, StageWork::of(rays.len()));

        for segment in 1..=settings.depth {
            let how = plan.segment(segment);
            let counters = extend(accelerator, how.closest, rays, hits, settings.count);
            watch.lap(Stage::Extend, segment, StageWork { counters, ..StageWork::of(rays.len()) });

            if !scene.media().is_empty() {
                let numbers = (settings.sampler, segment);
                collide(scene.media(), materials, numbers, paths, rays, hits);
                watch.lap(Stage::Collide, segment, StageWork::of(rays.len()));
            }

            sort(rays, hits, materials, queues);
            watch.lap(Stage::Sort, segment, StageWork::of(rays.len()));

            let shading = Shading { scene, settings, materials, lights, surfaces, cells, segment };
            let mut endings = Endings::default();
            let shaded = &mut Shaded { paths, next, shadows, endings: &mut endings };
            let work = shading.shade(queues, shaded);
            watch.ended(segment, &endings);
            watch.lap(Stage::Shade, segment, work);

            if !shadows.rays.is_empty() {
                let counters =
                    connect(accelerator, how.occluded, shadows, hits, paths, settings.count);
                let work = StageWork::of(shadows.rays.len());
                result.tally.rays.shadow += work.active;
                watch.lap(Stage::Connect, segment, StageWork { counters, ..work });
            }

            if next.len() == 0 {
                break;
            }
            order(next, plan.segment(segment + 1).ordered, paths, rays);
            result.tally.rays.bounce += rays.len() as u64;
            watch.lap(Stage::Order, segment + 1, StageWork::of(rays.len()));
        }

        let samples = (range.end - range.start) as usize;
        accumulate(paths, tile, range, settings, sum, result);
        watch.lap(Stage::Accumulate, 1, StageWork::of(samples));
    }
}

impl TileWorker for Worker<'_> {
    fn render_tile(&mut self, tile: Tile, report: &dyn Fn(u64, u64)) -> TileResult {
        let paths = tile.pixels() * u64::from(self.prepared.settings.spp);
        self.trace_all(tile, 0..paths, report);
        self.result.waves = std::mem::take(&mut self.watch.stats);
        self.result.laps = self.watch.laps.as_mut().map(std::mem::take).unwrap_or_default();
        for segment in &self.result.waves.segments {
            self.result.tally.endings.add(&segment.endings);
        }
        std::mem::take(&mut self.result)
    }
}
