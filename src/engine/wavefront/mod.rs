//! The wavefront engine: waves of paths pass through stages, each a loop over vectors of paths.

mod accumulate;
mod collide;
mod columns;
mod connect;
mod extend;
mod generate;
mod layer_samples;
mod material_sort;
mod order;
mod pass;
mod paths;
mod planning;
mod ray_sort;
mod rays;
mod shade;
mod wave;

use std::sync::Arc;
use std::time::Instant;

use super::{Plan, Planning, Pool, UnitEngine, UnitWorker, View};
use columns::Columns;
use connect::Shadows;
use material_sort::{Queue, Queues};
use paths::{History, Paths, Segment};
use ray_sort::{CellSort, Cells};
use rays::WaveRays;
use shade::{ShadeInputs, ShadeOutputs};
use wave::Worker;

/// Renders a view according to a plan.
#[derive(Debug)]
pub(super) struct WavefrontEngine {
    view: Arc<View>,
    plan: Plan,
    planning: Planning,
    plan_seconds: f64,
}

impl WavefrontEngine {
    /// Creates an engine for a render of `paths` paths. Uses the plan of the settings if they have
    /// one, else the plan `measured` earlier, else finds a plan.
    pub(super) fn new(view: Arc<View>, paths: u64, pool: &Pool, measured: Option<Plan>) -> Self {
        view.prepared.tables();
        let start = Instant::now();
        let (plan, planning) = match (view.compute.plan.given(), measured) {
            (Some(plan), _) => (plan.clone(), Planning::Given),
            (None, Some(plan)) => (plan, Planning::Measured),
            (None, None) => planning::find_plan(&view, paths, pool),
        };
        let plan_seconds = start.elapsed().as_secs_f64();
        for segment in &plan.segments {
            view.prepared.accelerator().prepare(segment.closest, pool.threads());
            view.prepared.accelerator().prepare(segment.occluded, pool.threads());
        }
        Self { view, plan, planning, plan_seconds }
    }
}

impl UnitEngine for WavefrontEngine {
    fn worker(&self, paths: u64) -> Box<dyn UnitWorker> {
        Box::new(Worker::new(&self.view, &self.plan, paths))
    }

    fn unit_paths(&self) -> u32 {
        self.plan.wave_size
    }

    fn plan(&self) -> Option<(&Plan, Planning, f64)> {
        Some((&self.plan, self.planning, self.plan_seconds))
    }
}
