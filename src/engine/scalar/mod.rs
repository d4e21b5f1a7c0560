//! The scalar reference engine: one ray, one loop, written from the report and the papers.

pub(super) mod bsdf;
mod intersect;
pub(super) mod light;
pub(super) mod medium;
mod path;

use glam::Vec3;

use super::contract::counted;
use super::dimension::{Dimension, Randoms};
use super::renderer::{TileEngine, TileResult, TileWorker};
use super::settings::RenderSettings;
use super::stats::WaveStats;
use super::tally::RayCounts;
use crate::accel::Bvh2;
use crate::film::{PixelSum, Tile};
use crate::geometry::Ray;
use crate::math::random::{PathKey, PixelKey};
use crate::scene::{CameraFrame, CameraSample, Scene};
use intersect::CountingTree;
pub(super) use intersect::{Intersect, Tree};
pub(super) use path::PathTracer;

/// A scene on a binary tree, rendered sample by sample.
#[derive(Debug)]
pub(super) struct ScalarEngine<'a> {
    scene: &'a Scene,
    settings: RenderSettings,
    camera: CameraFrame,
    tree: Bvh2,
}

impl<'a> ScalarEngine<'a> {
    pub(super) fn new(scene: &'a Scene, settings: &RenderSettings) -> Self {
        Self {
            scene,
            settings: settings.clone(),
            camera: scene.camera().frame(settings.width, settings.height),
            tree: Bvh2::new(scene.geometry(), scene.camera().shutter()),
        }
    }

    pub(super) fn tree(&self) -> Tree<'_> {
        Tree { tree: &self.tree, geometry: self.scene.geometry() }
    }

    /// The first ray of sample `sample` of pixel `(x, y)`, and the path's random numbers.
    pub(super) fn camera_ray(&self, x: u32, y: u32, sample: u32) -> (Ray, PathKey) {
        let sampler = self.settings.sampler;
        let key = sampler.path(PixelKey::new(self.settings.seed, x, y), sample);
        (self.camera.ray(x, y, camera_sample(&Randoms::new(sampler, key, 0))), key)
    }
}

/// Samples between two reports of progress.
const REPORT_EVERY: u64 = 4096;

impl TileEngine for ScalarEngine<'_> {
    fn worker(&self) -> Box<dyn TileWorker + '_> {
        // It has no state between tiles.
        Box::new(self)
    }

    fn tile_size(&self) -> u32 {
        match self.settings.tile_size {
            0 => 32,
            size => size,
        }
    }
}

impl TileWorker for &ScalarEngine<'_> {
    fn render_tile(&mut self, tile: Tile, report: &dyn Fn(u64, u64)) -> TileResult {
        if self.settings.count {
            let tree = CountingTree { tree: self.tree(), stats: WaveStats::default() };
            let (result, counting) = self.trace_tile(tile, tree, report);
            TileResult { waves: counting.stats, ..result }
        } else {
            self.trace_tile(tile, self.tree(), report).0
        }
    }
}

impl ScalarEngine<'_> {
    /// Renders `tile` with what finds the hits, and gives that back.
    fn trace_tile<I: Intersect>(
        &self,
        tile: Tile,
        intersect: I,
        report: &dyn Fn(u64, u64),
    ) -> (TileResult, I) {
        let mut result = TileResult::default();
        let mut tracer = PathTracer::new(self.scene, intersect, &self.settings);
        let mut sum = PixelSum::default();
        let mut reported = RayCounts::default();
        for y in tile.y..tile.y + tile.height {
            for x in tile.x..tile.x + tile.width {
                for sample in 0..self.settings.spp {
                    let (ray, key) = self.camera_ray(x, y, sample);
                    let radiance = tracer.radiance(ray, key);
                    match counted(radiance, self.settings.clamp) {
                        Some((radiance, clamped)) => {
                            sum.add(radiance);
                            result.tally.clamped += u64::from(clamped);
                        }
                        None => {
                            sum.add(Vec3::ZERO);
                            result.tally.non_finite.note(x, y, sample);
                        }
                    }
                    let samples = tracer.rays.primary - reported.primary;
                    if samples == REPORT_EVERY {
                        report(samples, tracer.rays.total() - reported.total());
                        reported = tracer.rays;
                    }
                }
                result.pixels.push(sum.take_mean().to_array());
            }
        }
        let rays = tracer.rays.total() - reported.total();
        report(tracer.rays.primary - reported.primary, rays);
        result.tally.rays = tracer.rays;
        result.tally.endings = tracer.endings;
        (result, tracer.intersect)
    }
}

fn camera_sample(randoms: &Randoms) -> CameraSample {
    CameraSample {
        pixel: randoms.two(Dimension::PIXEL),
        lens: randoms.two(Dimension::LENS),
        time: randoms.one(Dimension::TIME),
    }
}
