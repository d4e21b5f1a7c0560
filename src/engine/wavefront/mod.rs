//! The wavefront engine: waves of paths go through stages, each a loop over vectors of them.

mod accumulate;
mod cells;
mod choice;
mod collide;
mod columns;
mod connect;
mod extend;
mod generate;
mod order;
mod paths;
mod plan;
mod rays;
mod shade;
mod sort;
mod trial;

use std::time::Instant;

use rayon::ThreadPool;

use super::prepared::View;
use super::renderer::{UnitEngine, UnitWorker};
use super::rendering::{Taken, Task};
use super::stats::{Stage, StageWork, Stopwatch};
use super::tally::{Endings, Tally};
use crate::accel::HitBatch;
use accumulate::accumulate;
use cells::Cells;
use collide::collide;
use connect::{Shadows, connect};
use extend::extend;
use generate::generate;
use order::{Next, order};
use paths::Paths;
pub use plan::{Plan, Planning, SegmentPlan};
use rays::Rays;
use shade::{Shaded, Shading};
use sort::{Queues, sort};

/// A view, and the plan by which it is rendered.
#[derive(Debug)]
pub(super) struct WavefrontEngine {
    view: View,
    plan: Plan,
    planning: Planning,
    plan_seconds: f64,
}

impl WavefrontEngine {
    /// For a render of `paths` paths.
    pub(super) fn new(view: View, paths: u64, pool: &ThreadPool) -> Self {
        view.prepared.tables();
        let start = Instant::now();
        let (plan, planning) = match &view.settings.plan {
            Some(plan) => (plan.clone(), Planning::Given),
            None => trial::find_plan(&view, paths, pool),
        };
        let plan_seconds = start.elapsed().as_secs_f64();
        for segment in &plan.segments {
            view.prepared.accelerator().prepare(segment.closest);
            view.prepared.accelerator().prepare(segment.occluded);
        }
        Self { view, plan, planning, plan_seconds }
    }
}

impl UnitEngine for WavefrontEngine {
    fn worker(&self, paths: u64) -> Box<dyn UnitWorker + '_> {
        Box::new(Worker::new(&self.view, &self.plan, paths))
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
    queues: Queues,
    shadows: Shadows,
    /// Paths that go on.
    next: Next,
    cells: Cells,
}

impl Wave {
    /// Room for `capacity` paths.
    fn new(view: &View, capacity: usize) -> Self {
        let shadows = if view.settings.samples_lights(view.scene()) { capacity } else { 0 };
        let keys = view.prepared.tables().looks.keys().len();
        Self {
            paths: Paths::new(capacity),
            rays: Rays::with_capacity(capacity),
            hits: HitBatch::default(),
            queues: Queues::new(keys, capacity),
            shadows: Shadows::with_capacity(shadows),
            next: Next::with_capacity(capacity),
            cells: Cells::new(&view.prepared.accelerator().bounds()),
        }
    }
}

/// A thread's wave, and what comes of it.
#[derive(Debug)]
struct Worker<'a> {
    view: &'a View,
    plan: &'a Plan,
    wave: Wave,
    watch: Stopwatch,
}

impl<'a> Worker<'a> {
    /// For units of at most so many `paths`.
    fn new(view: &'a View, plan: &'a Plan, paths: u64) -> Self {
        let watch = Stopwatch::new(view.settings.timeline);
        Self { view, plan, wave: Wave::new(view, paths as usize), watch }
    }

    /// Takes the paths of `task` from the camera to the film; `None` where `abandon` returns true.
    ///
    /// Stages are not inlined: each has the registers for itself, and profiles tell them apart.
    fn trace(&mut self, task: &Task, abandon: &dyn Fn() -> bool) -> Option<Taken> {
        let Self { view, plan, wave, watch } = self;
        let View { prepared, settings, camera } = view;
        let (scene, accelerator) = (prepared.scene(), prepared.accelerator());
        let tables = prepared.tables();
        let Wave { paths, rays, hits, queues, shadows, next, cells } = wave;
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

            if !tables.media.is_empty() {
                collide(tables, (settings.sampler, segment), paths, rays, hits);
                watch.lap(Stage::Collide, segment, StageWork::of(rays.len()));
            }

            sort(rays, hits, &tables.looks, queues);
            watch.lap(Stage::Sort, segment, StageWork::of(rays.len()));

            let shading = Shading { scene, settings, tables, cells, segment };
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
