//! From a scene and settings to an image: tiles on threads, whatever the engine.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use rayon::ThreadPool;

use super::pool::{self, Pinned};
use super::scalar::ScalarEngine;
use super::settings::{Engine, RenderSettings};
use super::stats::WaveStats;
use super::tally::Tally;
use super::timeline::{Event, Lap, Work};
use super::wavefront::{Plan, Planning, WavefrontEngine};
use crate::error::Result;
use crate::film::{Tile, Tiles};
use crate::image::Image;
use crate::scene::Scene;

/// A scene with its acceleration structure and threads, ready to be rendered.
#[derive(Debug)]
pub struct Renderer<'a> {
    settings: RenderSettings,
    engine: Box<dyn TileEngine + 'a>,
    pool: ThreadPool,
    pinned: Pinned,
    seconds: Seconds,
}

/// What an engine does: its workers render tiles.
pub(super) trait TileEngine: Sync + std::fmt::Debug {
    /// What a thread works with.
    fn worker(&self) -> Box<dyn TileWorker + '_>;

    /// Side of the tiles that work is handed out in.
    fn tile_size(&self) -> u32;

    /// How it works, if it has a plan, where that is from, and the seconds that finding it took.
    fn plan(&self) -> Option<(&Plan, Planning, f64)> {
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
    /// What was traced, and what came of it.
    pub tally: Tally,
    /// What the stages of the wavefront engine did; of the scalar engine, where it is asked to count,
    /// the work of its rays, without times.
    pub waves: WaveStats,
    /// Time of each step.
    pub seconds: Seconds,
    /// What each worker did when, if that was asked for; the first [`MOST_EVENTS`].
    pub timeline: Vec<Event>,
}

/// Events of a timeline, at most: some hundred megabytes.
pub const MOST_EVENTS: usize = 1 << 21;

/// Wall-clock seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Seconds {
    /// Building the acceleration structure and starting the threads.
    pub build: f64,
    /// Finding the plan, and making what its trials need.
    pub plan: f64,
    /// Rendering.
    pub render: f64,
}

/// What an engine returns for a tile: its pixels row by row.
#[derive(Debug, Default)]
pub(super) struct TileResult {
    pub(super) pixels: Vec<[f32; 3]>,
    pub(super) tally: Tally,
    pub(super) waves: WaveStats,
    /// The stages one by one, if that was asked for.
    pub(super) laps: Vec<Lap>,
}

/// How far a render is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// Samples finished.
    pub samples: u64,
    /// Rays traced.
    pub rays: u64,
}

/// Is told how far a render is, from any thread, every few thousand samples, or after each wave.
pub trait Observer: Sync {
    /// `progress` is the state now; reports of several threads may arrive out of order.
    fn progressed(&self, progress: Progress);
}

/// Nobody watches.
impl Observer for () {
    fn progressed(&self, _: Progress) {}
}

impl<'a> Renderer<'a> {
    /// Checks the settings, starts the threads, builds the acceleration structure and finds the
    /// plan.
    ///
    /// # Errors
    /// [`Error::Usage`](crate::Error::Usage) where a setting is out of its range,
    /// [`Error::Internal`](crate::Error::Internal) where the threads cannot be started.
    pub fn new(scene: &'a Scene, settings: RenderSettings) -> Result<Self> {
        settings.check()?;
        let start = Instant::now();
        let (pool, pinned) = pool::start(settings.threads, settings.pin)?;
        let engine: Box<dyn TileEngine + 'a> = match settings.engine {
            Engine::Wavefront => Box::new(WavefrontEngine::new(scene, &settings, &pool)),
            Engine::Scalar => Box::new(ScalarEngine::new(scene, &settings)),
        };
        let plan = engine.plan().map_or(0.0, |(.., seconds)| seconds);
        let seconds = Seconds { build: start.elapsed().as_secs_f64() - plan, plan, render: 0.0 };
        Ok(Self { settings, engine, pool, pinned, seconds })
    }

    /// How the wavefront engine works; `None` for others.
    pub fn plan(&self) -> Option<&Plan> {
        self.engine.plan().map(|(plan, ..)| plan)
    }

    /// Where that is from.
    pub fn planning(&self) -> Option<Planning> {
        self.engine.plan().map(|(_, planning, _)| planning)
    }

    /// Worker threads.
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Whether they are pinned to cores.
    pub fn pinned(&self) -> Pinned {
        self.pinned
    }

    /// Renders the image.
    ///
    /// # Errors
    /// [`Error::Internal`](crate::Error::Internal) where there is no memory for the image.
    pub fn render(&self) -> Result<Render> {
        self.render_observed(&())
    }

    /// Renders the image and tells `observer` how far it is.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render_observed(&self, observer: &dyn Observer) -> Result<Render> {
        let RenderSettings { width, height, .. } = self.settings;
        let start = Instant::now();
        let film = Mutex::new(Film::new(Image::try_new(width, height)?));
        let (samples, rays) = (AtomicU64::new(0), AtomicU64::new(0));
        let report = |new_samples, new_rays| {
            observer.progressed(Progress {
                samples: samples.fetch_add(new_samples, Ordering::Relaxed) + new_samples,
                rays: rays.fetch_add(new_rays, Ordering::Relaxed) + new_rays,
            });
        };
        let tiles = Tiles::new(width, height, self.engine.tile_size());
        let next = AtomicU64::new(0);
        self.pool.broadcast(|thread| {
            // None for threads that find no work.
            let mut worker = None;
            while let Some(tile) = tiles.get(next.fetch_add(1, Ordering::Relaxed)) {
                let worker = worker.get_or_insert_with(|| self.engine.worker());
                let begin = Instant::now();
                let mut result = worker.render_tile(tile, &report);
                #[cfg(feature = "slowed")]
                super::slowed::dawdle(begin.elapsed());
                if self.settings.timeline {
                    let (end, work) = (Instant::now(), Work::Tile(tile));
                    result.laps.push(Lap { start: begin, end, work });
                }
                let mut film = film.lock().expect("no thread panics while it holds the film");
                film.add(tile, &result);
                let room = MOST_EVENTS - film.timeline.len();
                let laps = result.laps.iter().take(room);
                film.timeline.extend(laps.map(|lap| lap.event(start, thread.index())));
            }
        });
        let film = film.into_inner().expect("no thread panicked while it held the film");
        Ok(Render {
            image: film.image,
            tally: film.tally,
            waves: film.waves,
            seconds: Seconds { render: start.elapsed().as_secs_f64(), ..self.seconds },
            timeline: film.timeline,
        })
    }
}

/// The image as far as its tiles are done.
#[derive(Debug)]
struct Film {
    image: Image,
    tally: Tally,
    waves: WaveStats,
    timeline: Vec<Event>,
}

impl Film {
    fn new(image: Image) -> Self {
        let (tally, waves) = (Tally::default(), WaveStats::default());
        Self { image, tally, waves, timeline: Vec::new() }
    }

    fn add(&mut self, tile: Tile, result: &TileResult) {
        for (y, row) in (tile.y..).zip(result.pixels.chunks_exact(tile.width as usize)) {
            self.image.put_row(tile.x, y, row);
        }
        self.tally.add(&result.tally);
        self.waves.add(&result.waves);
    }
}
