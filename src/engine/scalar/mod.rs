//! The scalar reference engine: it traces one ray at a time in a loop. Its formulas are those of
//! `scene` and `math`, which the wavefront engine uses as well.

mod intersect;
mod path;

use std::sync::Arc;

use glam::Vec3;

use super::{Taken, Tally, Task, UnitEngine, UnitWorker, View, WaveStats, scale};
use crate::accel::Kernel;
use crate::film::UnitSums;
use crate::geometry::Ray;
use crate::math::{PathKey, PixelKey};
use crate::sampler::Randoms;
use intersect::CountingTree;
pub(super) use intersect::{Intersect, Tree};
pub(super) use path::PathTracer;

/// Renders a view sample by sample, with a binary tree.
#[derive(Clone, Debug)]
pub(super) struct ScalarEngine(Arc<View>);

impl ScalarEngine {
    /// Creates an engine. `threads` threads build the tree.
    pub(super) fn new(view: Arc<View>, threads: usize) -> Self {
        view.prepared.accelerator().prepare(Kernel::Scalar, threads);
        view.prepared.tables();
        Self(view)
    }

    /// Number of channels of a sample.
    pub(super) fn channels(&self) -> usize {
        self.0.settings.stored_layers().channels()
    }

    pub(super) fn tree(&self) -> Tree<'_> {
        Tree { tree: self.0.prepared.accelerator().scalar(), geometry: self.0.scene().geometry() }
    }

    /// The camera ray of sample `sample` of pixel `(x, y)`, the sample's weight, and the key of the
    /// path's random numbers.
    pub(super) fn camera_ray(&self, x: u32, y: u32, sample: u32) -> (Ray, f32, PathKey) {
        let View { settings, camera, .. } = &*self.0;
        let key = settings.sampler.path(PixelKey::new(settings.seed, x, y), sample);
        let randoms = Randoms::new(settings.sampler, key, 0);
        let (ray, weight) = camera.ray::<f32, false>(x as f32, y as f32, &randoms);
        (ray, weight, key)
    }

    /// Creates a path tracer for the scene, with `intersect` to answer ray queries.
    pub(super) fn tracer<'a>(&'a self, intersect: &'a mut dyn Intersect) -> PathTracer<'a> {
        let (tables, mut tree) = (self.0.prepared.tables(), self.tree());
        let nesting = tables.bodies_around(self.0.camera.middle(), |ray| tree.closest(ray, 1));
        PathTracer::new(&self.0, nesting, intersect)
    }
}

impl UnitEngine for ScalarEngine {
    fn worker(&self, _: u64) -> Box<dyn UnitWorker> {
        // A worker keeps no state between units.
        Box::new(self.clone())
    }

    fn unit_paths(&self) -> u32 {
        1 << 12
    }
}

impl UnitWorker for ScalarEngine {
    fn take(&mut self, task: &Task, abandon: &dyn Fn() -> bool) -> Option<Taken> {
        if self.0.compute.count {
            let mut tree = CountingTree { tree: self.tree(), stats: WaveStats::default() };
            let taken = self.trace(task, &mut tree, abandon)?;
            Some(Taken { waves: tree.stats, ..taken })
        } else {
            self.trace(task, &mut self.tree(), abandon)
        }
    }
}

impl ScalarEngine {
    /// Traces the samples of `task`.
    fn trace(
        &self,
        task: &Task,
        intersect: &mut dyn Intersect,
        abandon: &dyn Fn() -> bool,
    ) -> Option<Taken> {
        let unit = task.unit;
        let mut tally = Tally::default();
        let mut sums = task.open_sums();
        let mut values = vec![0.0; task.channels];
        let mut tracer = self.tracer(intersect);
        let clamp = self.0.settings.clamp.unwrap_or(f32::INFINITY);
        let layers = self.0.settings.stored_layers();
        for (pixel, sums) in (0..).zip(sums.chunks_exact_mut(task.channels)) {
            let (x, y) = unit.tile.pixel(pixel);
            let mut sum = Vec3::from_slice(sums);
            for sample in unit.first..unit.end {
                let (ray, weight, key) = self.camera_ray(x, y, sample);
                let (radiance, light) = tracer.radiance(ray, key, weight, &mut values);
                sum += tally.counted(radiance, clamp, (x, y, sample));
                if layers.is_empty() {
                    continue;
                }
                layers.add_first_hit(sums, &values, sample);
                // Samples that are not finite are black in all layers.
                if let Some(scale) = scale(radiance, clamp) {
                    layers.add_light(sums, &light, sample, scale);
                }
            }
            sum.write_to_slice(sums);
            if abandon() {
                return None;
            }
        }
        (tally.rays, tally.endings) = (tracer.rays, tracer.endings);
        let (waves, laps) = (WaveStats::default(), Vec::new());
        Some(Taken { part: UnitSums { unit, sums }, tally, waves, laps })
    }
}
