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

use std::time::Instant;

use rayon::ThreadPool;

use super::renderer::{UnitEngine, UnitWorker};
use super::rendering::{Taken, Task};
use super::settings::RenderSettings;
use super::stats::{Stage, StageWork, Stopwatch};
use super::tally::{Endings, Tally};
use crate::accel::{Accelerator, HitBatch};
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
    /// For a render of so many paths.
    pub(super) fn new(
        scene: &'a Scene,
        settings: &RenderSettings,
        paths: u64,
        pool: &ThreadPool,
    ) -> Self {
        // A plan is found without counting, which takes time.
        let uncounted = RenderSettings { count: false, ..settings.clone() };
        let mut prepared = Prepared::new(scene, &uncounted);
        let start = Instant::now();
        let (plan, planning) = match &settings.plan {
            Some(plan) => (plan.clone(), Planning::Given),
            None => trial::find_plan(&prepared, paths, pool),
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

impl UnitEngine for WavefrontEngine<'_> {
    fn worker(&self, paths: u64) -> Box<dyn UnitWorker + '_> {
        Box::new(Worker::new(&self.prepared, &self.plan, paths))
    }

    fn unit_paths(&self) -> u32 {
        self.plan.wave_size
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
    watch: Stopwatch,
}

impl<'a> Worker<'a> {
    /// For units of at most so many `paths`.
    fn new(prepared: &'a Prepared<'a>, plan: &'a Plan, paths: u64) -> Self {
        let watch = Stopwatch::new(prepared.settings.timeline);
        Self { prepared, plan, wave: Wave::new(prepared, paths as usize), watch }
    }

    /// Takes the paths of `task` from the camera to the film; `None` where `abandon` returns true.
    ///
    /// Stages are not inlined: each has the registers for itself, and profiles tell them apart.
    fn trace(&mut self, task: &Task, abandon: &dyn Fn() -> bool) -> Option<Taken> {
        let Self { prepared, plan, wave, watch } = self;
        let Prepared { scene, settings, camera, accelerator, materials, lights, surfaces, cells } =
            prepared;
        let Wave { paths, rays, hits, queues, shadows, next } = wave;
        let unit = task.unit;
        let mut tally = Tally::default();
        watch.start();

        generate(camera, settings, unit, paths, rays);
        tally.rays.primary += rays.len() as u64;
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
                tally.rays.shadow += work.active;
                watch.lap(Stage::Connect, segment, StageWork { counters, ..work });
            }

            if next.len() == 0 {
                break;
            }
            if abandon() {
                return None;
            }
            order(next, plan.segment(segment + 1).ordered, paths, rays);
            tally.rays.bounce += rays.len() as u64;
            watch.lap(Stage::Order, segment + 1, StageWork::of(rays.len()));
        }

        let part = accumulate(paths, task, settings, &mut tally);
        watch.lap(Stage::Accumulate, 1, StageWork::of(unit.paths() as usize));
        let (waves, laps) = watch.take();
        for segment in &waves.segments {
            tally.endings.add(&segment.endings);
        }
        Some(Taken { part, tally, waves, laps })
    }
}

impl UnitWorker for Worker<'_> {
    fn take(&mut self, task: &Task, abandon: &dyn Fn() -> bool) -> Option<Taken> {
        self.trace(task, abandon)
    }
}
