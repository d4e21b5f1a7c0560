//! The main loop of the wavefront engine: a worker passes a wave of paths through the stages.

use std::sync::Arc;

use super::accumulate::accumulate;
use super::collide::collide;
use super::connect::connect;
use super::extend::{closest, extend};
use super::generate::generate;
use super::layer_samples::LayerSamples;
use super::material_sort::sort;
use super::order::{Next, order};
use super::pass::Passing;
use super::{Cells, Paths, Queues, ShadeInputs, ShadeOutputs, Shadows, WaveRays};
use crate::accel::HitBatch;
use crate::engine::{
    Endings, Plan, Stage, StageWork, Stopwatch, Taken, Tally, Task, UnitWorker, View,
};
use crate::shading::Nesting;

/// The paths of a wave, and the data that the stages hand to each other. The size of a wave depends
/// on the plan and on the kinds of materials, not on the image or its samples.
#[derive(Debug)]
struct Wave {
    paths: Paths,
    /// The rays to trace next.
    rays: WaveRays,
    /// The hits of these rays.
    hits: HitBatch,
    /// The paths, sorted by the key of their hit.
    queues: Queues,
    shadows: Shadows,
    /// The paths that continue.
    next: Next,
    cells: Cells,
    layers: LayerSamples,
}

impl Wave {
    /// Creates a wave with room for `capacity` paths.
    fn new(view: &View, capacity: usize) -> Self {
        let shadows = if view.settings.samples_lights(view.scene()) { capacity } else { 0 };
        let keys = view.prepared.tables().looks.keys().len();
        Self {
            paths: Paths::new(
                capacity,
                view.camera.is_weighted(),
                !view.prepared.tables().bodies.are_clear(),
            ),
            rays: WaveRays::with_capacity(capacity),
            hits: HitBatch::default(),
            queues: Queues::new(keys, capacity, view.prepared.accelerator().has_instances()),
            shadows: Shadows::with_capacity(shadows),
            next: Next::with_capacity(capacity),
            cells: Cells::new(&view.prepared.accelerator().bounds()),
            layers: LayerSamples::new(view.settings.stored_layers(), capacity),
        }
    }
}

/// The wave of a thread, with the plan for tracing it and a stopwatch for its stages.
#[derive(Debug)]
pub(super) struct Worker {
    view: Arc<View>,
    pub(super) plan: Plan,
    wave: Wave,
    /// The bodies around the camera.
    nesting: Nesting<f32>,
    watch: Stopwatch,
}

impl Worker {
    /// Creates a worker for units of at most `paths` paths.
    pub(super) fn new(view: &Arc<View>, plan: &Plan, paths: u64) -> Self {
        let watch = Stopwatch::new(view.compute.timeline);
        let wave = Wave::new(view, paths as usize);
        let (accelerator, kernel) = (view.prepared.accelerator(), plan.segment(1).closest);
        let nesting = view
            .prepared
            .tables()
            .bodies_around(view.camera.middle(), |ray| closest(accelerator, kernel, ray));
        Self { view: Arc::clone(view), plan: plan.clone(), wave, nesting, watch }
    }

    /// Traces the paths of `task` from the camera to the film. Returns `None` if `abandon` returns
    /// true.
    ///
    /// Stages are not inlined: each then has all registers to itself, and profiles list it
    /// separately.
    pub(super) fn trace(&mut self, task: &Task, abandon: &dyn Fn() -> bool) -> Option<Taken> {
        let Self { view, plan, wave, nesting, watch } = self;
        let View { prepared, settings, compute, camera, survival } = &**view;
        let (scene, accelerator) = (prepared.scene(), prepared.accelerator());
        let tables = prepared.tables();
        let Wave { paths, rays, hits, queues, shadows, next, cells, layers } = wave;
        let unit = task.unit;
        let mut tally = Tally::default();
        watch.start();

        generate(camera, settings, unit, paths, rays);
        paths.begin_in(*nesting);
        tally.rays.primary += rays.len() as u64;
        layers.begin(rays.len(), settings.first_hit);
        watch.lap(Stage::Generate, 1, StageWork::of(rays.len()));

        for segment in 1..=settings.depth {
            let how = plan.segment(segment);
            let counters = extend(accelerator, how.closest, rays, hits, compute.count);
            watch.lap(Stage::Extend, segment, StageWork { counters, ..StageWork::of(rays.len()) });

            if !tables.media.is_empty() {
                collide(tables, (settings.sampler, segment), paths, rays, hits);
                watch.lap(Stage::Collide, segment, StageWork::of(rays.len()));
            }

            let (kernel, count) = (how.closest, compute.count);
            let passing =
                tables.looks.have_panes().then_some(Passing { tables, accelerator, kernel, count });
            if let Some(passing) = passing {
                let work = passing.pass(settings, segment, paths, rays, hits);
                tally.rays.bounce += work.active;
                watch.lap(Stage::Extend, segment, work);
            }

            sort(rays, hits, &tables.looks, queues);
            watch.lap(Stage::Sort, segment, StageWork::of(rays.len()));

            let shading = ShadeInputs {
                scene,
                settings,
                survival: *survival,
                camera,
                tables,
                cells,
                segment,
            };
            let mut endings = Endings::default();
            let shaded = &mut ShadeOutputs { paths, next, shadows, layers, endings: &mut endings };
            let work = shading.shade(queues, shaded);
            watch.ended(segment, &endings);
            layers.store_radiance(paths, segment);
            watch.lap(Stage::Shade, segment, work);

            if shadows.len() > 0 {
                if how.shadows_ordered {
                    shadows.sort(cells);
                }
                let trace = (accelerator, how.occluded);
                let work = connect(trace, shadows, hits, paths, passing, compute.count);
                tally.rays.shadow += work.active;
                watch.lap(Stage::Connect, segment, work);
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

        paths.apply_weights(unit.paths() as usize);
        let part = accumulate(paths, layers, task, settings, &mut tally);
        watch.lap(Stage::Accumulate, 1, StageWork::of(unit.paths() as usize));
        let (waves, laps) = watch.take();
        for segment in &waves.segments {
            tally.endings.add(&segment.endings);
        }
        Some(Taken { part, tally, waves, laps })
    }
}

impl UnitWorker for Worker {
    fn take(&mut self, task: &Task, abandon: &dyn Fn() -> bool) -> Option<Taken> {
        self.trace(task, abandon)
    }
}
