//! From a scene and settings to an image: tiles on threads, whatever the engine.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Instant;

use super::pool::{Pinned, pool};
use super::scalar::ScalarEngine;
use super::settings::{Engine, RenderSettings};
use super::stats::{Endings, WaveStats};
use super::wavefront::{Plan, WavefrontEngine};
use crate::error::Result;
use crate::film::{Tile, tiles};
use crate::image::Image;
use crate::scene::Scene;

/// A scene with its acceleration structure, ready to be rendered.
#[derive(Debug)]
pub struct Renderer<'a> {
    settings: RenderSettings,
    engine: Box<dyn TileEngine + 'a>,
    build_seconds: f64,
}

/// What an engine does: its workers render tiles.
pub(super) trait TileEngine: Sync + std::fmt::Debug {
    /// What a thread works with.
    fn worker(&self) -> Box<dyn TileWorker + '_>;

    /// Side of the tiles that work is handed out in.
    fn tile_size(&self) -> u32;

    /// How it works, if it has a plan.
    fn plan(&self) -> Option<&Plan> {
        None
    }
}

/// What a thread does.
pub(super) trait TileWorker {
    /// The mean radiance of every pixel of `tile`. Calls `report` now and then with the
    /// samples finished and rays traced since the last call.
    fn render_tile(&mut self, tile: Tile, report: &dyn Fn(u64, u64)) -> TileResult;
}

/// A finished render.
#[derive(Clone, Debug)]
pub struct Render {
    /// The linear image.
    pub image: Image,
    /// Rays traced.
    pub rays: RayCounts,
    /// Samples that were not finite, and counted as black.
    pub non_finite: NonFinite,
    /// How the paths ended.
    pub endings: Endings,
    /// What the stages of the wavefront engine did; empty for others.
    pub waves: WaveStats,
    /// Worker threads used.
    pub threads: usize,
    /// Whether they were pinned to cores.
    pub pinned: Pinned,
    /// Time of each step.
    pub seconds: Seconds,
}

/// Wall-clock seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seconds {
    /// Building the acceleration structure.
    pub build: f64,
    /// Rendering.
    pub render: f64,
}

/// Rays by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RayCounts {
    /// From the camera.
    pub primary: u64,
    /// From a surface, for the closest hit.
    pub bounce: u64,
    /// From a surface to a light.
    pub shadow: u64,
}

impl RayCounts {
    /// All rays.
    pub fn total(&self) -> u64 {
        self.primary + self.bounce + self.shadow
    }

    fn add(&mut self, other: Self) {
        self.primary += other.primary;
        self.bounce += other.bounce;
        self.shadow += other.shadow;
    }
}

/// Samples whose radiance was NaN or infinite.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct NonFinite {
    /// How many.
    pub count: u64,
    /// Pixel and sample of the first in the order of the image.
    pub first: Option<(u32, u32, u32)>,
}

impl NonFinite {
    /// Notes sample `sample` of pixel `(x, y)`.
    pub(super) fn note(&mut self, x: u32, y: u32, sample: u32) {
        self.merge(&Self { count: 1, first: Some((x, y, sample)) });
    }

    fn merge(&mut self, other: &Self) {
        self.count += other.count;
        let order = |&(x, y, sample): &(u32, u32, u32)| (y, x, sample);
        self.first = self.first.into_iter().chain(other.first).min_by_key(order);
    }
}

/// What an engine returns for a tile: its pixels row by row.
#[derive(Debug, Default)]
pub(super) struct TileResult {
    pub(super) pixels: Vec<[f32; 3]>,
    pub(super) rays: RayCounts,
    pub(super) non_finite: NonFinite,
    pub(super) endings: Endings,
    pub(super) waves: WaveStats,
}

/// How far a render is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// Samples finished.
    pub samples: u64,
    /// Rays traced.
    pub rays: u64,
}

/// Is told how far a render is, from any thread, every few thousand samples.
pub trait Observer: Sync {
    /// `progress` is the state now; reports of several threads may arrive out of order.
    fn progressed(&self, progress: Progress);
}

/// Nobody watches.
impl Observer for () {
    fn progressed(&self, _: Progress) {}
}

impl<'a> Renderer<'a> {
    /// Checks the settings and builds the acceleration structure.
    ///
    /// # Errors
    /// [`Error::Usage`](crate::Error::Usage) where a setting is out of its range.
    pub fn new(scene: &'a Scene, settings: RenderSettings) -> Result<Self> {
        settings.check()?;
        let start = Instant::now();
        let engine: Box<dyn TileEngine + 'a> = match settings.engine {
            Engine::Wavefront => Box::new(WavefrontEngine::new(scene, &settings)),
            Engine::Scalar => Box::new(ScalarEngine::new(scene, &settings)),
        };
        Ok(Self { settings, engine, build_seconds: start.elapsed().as_secs_f64() })
    }

    /// How the wavefront engine works; `None` for others.
    pub fn plan(&self) -> Option<&Plan> {
        self.engine.plan()
    }

    /// Renders the image.
    ///
    /// # Errors
    /// [`Error::Internal`](crate::Error::Internal) where the threads cannot be started or memory is
    /// short.
    pub fn render(&self) -> Result<Render> {
        self.render_observed(&())
    }

    /// Renders the image and tells `observer` how far it is.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render_observed(&self, observer: &dyn Observer) -> Result<Render> {
        let RenderSettings { width, height, threads, pin, .. } = self.settings;
        let (pool, pinned) = pool(threads, pin)?;
        let start = Instant::now();
        let film = Mutex::new(Film::new(Image::try_new(width, height)?));
        let (samples, rays) = (AtomicU64::new(0), AtomicU64::new(0));
        let report = |new_samples, new_rays| {
            observer.progressed(Progress {
                samples: samples.fetch_add(new_samples, Ordering::Relaxed) + new_samples,
                rays: rays.fetch_add(new_rays, Ordering::Relaxed) + new_rays,
            });
        };
        let (tiles, next) = (tiles(width, height, self.engine.tile_size()), AtomicUsize::new(0));
        pool.broadcast(|_| {
            let mut worker = self.engine.worker();
            while let Some(&tile) = tiles.get(next.fetch_add(1, Ordering::Relaxed)) {
                let result = worker.render_tile(tile, &report);
                film.lock().expect("no thread panics while it holds the film").add(tile, &result);
            }
        });
        let film = film.into_inner().expect("no thread panicked while it held the film");
        Ok(Render {
            image: film.image,
            rays: film.rays,
            non_finite: film.non_finite,
            endings: film.endings,
            waves: film.waves,
            threads: pool.current_num_threads(),
            pinned,
            seconds: Seconds { build: self.build_seconds, render: start.elapsed().as_secs_f64() },
        })
    }
}

/// The image as far as its tiles are done.
#[derive(Debug)]
struct Film {
    image: Image,
    rays: RayCounts,
    non_finite: NonFinite,
    endings: Endings,
    waves: WaveStats,
}

impl Film {
    fn new(image: Image) -> Self {
        Self {
            image,
            rays: RayCounts::default(),
            non_finite: NonFinite::default(),
            endings: Endings::default(),
            waves: WaveStats::default(),
        }
    }

    fn add(&mut self, tile: Tile, result: &TileResult) {
        for (y, row) in (tile.y..).zip(result.pixels.chunks_exact(tile.width as usize)) {
            self.image.put_row(tile.x, y, row);
        }
        self.rays.add(result.rays);
        self.non_finite.merge(&result.non_finite);
        self.endings.add(&result.endings);
        self.waves.add(&result.waves);
    }
}
