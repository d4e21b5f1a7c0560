//! Sessions: a render that can be watched, stopped, continued and changed.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::{
    ComputeSettings, ImageSettings, Layers, Observer, PreparedScene, Progress, Render, RenderState,
    Renderer, Rows, Stop, develop, develop_in_parallel,
};
use crate::error::Result;
use crate::film::Tile;
use crate::image::Image;
use crate::scene::Look;

/// Rows of a snapshot that are computed while workers wait, about as long as they take for one unit of work.
const ROWS: u32 = 32;

/// When [`Session::render`] returns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Until {
    /// When all pixels have all samples of the settings.
    #[default]
    Complete,
    /// When all pixels have this many samples, or all of them.
    Samples(u32),
    /// After this time, or when the render is complete. Workers finish their current unit of work, some milliseconds.
    Time(Duration),
}

/// A render that can be watched, stopped, continued and changed. Its threads, trees and memory are kept.
///
/// [`render`](Self::render) runs in the caller's thread until it has what was asked for. Meanwhile other threads may take
/// snapshots and [cancel](Self::cancel) it. At a number of samples that all pixels have, an image has the same bits as
/// any other render with these settings.
#[derive(Debug)]
pub struct Session {
    renderer: Renderer,
    state: Mutex<RenderState>,
    /// Held by the call that renders.
    renders: Mutex<()>,
    cancelled: AtomicBool,
}

impl Session {
    /// Prepares a render without samples.
    ///
    /// # Errors
    /// Those of [`Renderer::new`] and [`Renderer::begin`].
    pub fn new(
        scene: impl Into<PreparedScene>,
        image: ImageSettings,
        compute: impl Into<ComputeSettings>,
    ) -> Result<Self> {
        let renderer = Renderer::new(scene, image, compute)?;
        let state = renderer.begin()?;
        Ok(Self::of(renderer, state))
    }

    /// Another render of the same scene, on the same threads.
    ///
    /// # Errors
    /// Those of [`set`](Self::set).
    pub fn beside(
        &self,
        image: ImageSettings,
        compute: impl Into<ComputeSettings>,
    ) -> Result<Self> {
        let renderer =
            self.renderer.with(self.renderer.prepared().clone(), image, compute.into())?;
        let state = renderer.begin()?;
        Ok(Self::of(renderer, state))
    }

    /// Continues `state`, which has samples of `renderer`, or none.
    pub(crate) fn of(renderer: Renderer, state: RenderState) -> Self {
        let (state, renders) = (Mutex::new(state), Mutex::new(()));
        Self { renderer, state, renders, cancelled: AtomicBool::new(false) }
    }

    /// The render so far, also after a worker panicked. Workers wait while it is held.
    pub(crate) fn state(&self) -> MutexGuard<'_, RenderState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The renderer.
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Renders until `until`, unless `observer` or [`cancel`](Self::cancel) stops it earlier. Returns the progress. A
    /// second call waits for the first.
    ///
    /// # Errors
    /// If memory runs out, returns [`Error::Resource`](crate::Error::Resource).
    pub fn render(&self, until: Until, observer: &dyn Observer) -> Result<Progress> {
        let _renders = self.renders.lock().unwrap_or_else(PoisonError::into_inner);
        let (end, time) = match until {
            Until::Complete => (u32::MAX, None),
            Until::Samples(samples) => (samples, None),
            Until::Time(time) => (u32::MAX, Some(time)),
        };
        let begin = Instant::now();
        let watch = Watch { session: self, observer, ends: time.map(|time| (begin, time)) };
        let advanced = self.renderer.advance_shared(&self.state, end, &watch);
        self.cancelled.store(false, Ordering::Relaxed);
        advanced.map(|()| self.progress())
    }

    /// Stops the call of [`render`](Self::render) that runs, or else the next one. The samples of unfinished units of
    /// work are lost.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// The progress so far.
    pub fn progress(&self) -> Progress {
        self.state().progress()
    }

    /// The number of samples that all pixels have.
    pub fn samples(&self) -> u32 {
        self.state().film.least_done()
    }

    /// An estimate of the image's relative error: the root of the mean of (x − r)² / (r² + 0.01 m²) over all pixels and
    /// channels, for the colours x, their expected values r, and the mean m of r. `None` unless all pixels have
    /// a number of samples that gives one, such as 48, or 80, 96 or 112 times a power of two.
    ///
    /// # Errors
    /// If memory runs out, returns [`Error::Resource`](crate::Error::Resource).
    pub fn noise(&self) -> Result<Option<f64>> {
        self.state().noise()
    }

    /// Ends the render with the samples that all pixels have: they become the `spp` of its settings.
    ///
    /// # Panics
    /// If some pixels have more samples than others.
    pub(crate) fn end(&mut self) {
        let samples = self.samples();
        self.state().end_at(samples);
        self.renderer.end_at(samples);
    }

    /// Whether all pixels have all samples.
    pub fn is_complete(&self) -> bool {
        self.state().is_complete()
    }

    /// The image so far with its layers, at any time. Workers wait only while some rows are computed, so pixels may
    /// have different numbers of samples.
    ///
    /// # Errors
    /// If memory runs out, returns [`Error::Resource`](crate::Error::Resource).
    pub fn snapshot(&self) -> Result<Image> {
        self.snapshot_of(&self.renderer.image_settings().layers)
    }

    /// [`snapshot`](Self::snapshot) with only those of the render's layers that `layers` has.
    ///
    /// # Errors
    /// Those of [`snapshot`](Self::snapshot).
    pub fn snapshot_of(&self, layers: &Layers) -> Result<Image> {
        let settings = self.renderer.image_settings();
        if let Ok(_renders) = self.renders.try_lock() {
            // The threads have nothing else to do.
            let state = self.state();
            let (area, film) = (state.film.area(), Rows::all(&state.film));
            return self.renderer.install(|| develop_in_parallel(settings, layers, area, &film));
        }
        let area = self.state().film.area();
        let mut image = None;
        for y in (0..area.height).step_by(ROWS as usize) {
            let rows = y..area.height.min(y + ROWS);
            let below = Tile { y: area.y + y, height: rows.end - rows.start, ..area };
            let state = self.state();
            let below = develop(settings, layers, below, &Rows { film: &state.film, rows })?;
            drop(state);
            image = Some(match image {
                None => {
                    let mut first = below;
                    first.reserve(area.pixels() as usize)?;
                    first
                }
                Some(above) => Image::above(above, below),
            });
        }
        Ok(image.unwrap_or_else(|| Image::new(area.width, area.height)))
    }

    /// Returns the image with its layers, and what was counted and measured. Moves the timeline out of the session.
    ///
    /// # Errors
    /// If memory runs out, returns [`Error::Resource`](crate::Error::Resource).
    pub fn finish(&self) -> Result<Render> {
        self.renderer.finish(&mut self.state())
    }

    /// Begins anew with other settings: another camera, size, seed, or set of layers, for example. If only the
    /// number of samples grows, the render continues. Nothing is built again. After an error, nothing has changed.
    ///
    /// # Errors
    /// Those of [`Renderer::set`] and [`Renderer::begin`].
    pub fn set(&mut self, image: ImageSettings, compute: impl Into<ComputeSettings>) -> Result<()> {
        let prepared = self.renderer.prepared().clone();
        self.change(prepared, image, compute.into())
    }

    /// Begins anew with other materials, lights or background. `change` gets those that the scene has. Trees are kept.
    /// After an error, nothing has changed.
    ///
    /// # Errors
    /// Those of [`Scene::with_look`](crate::Scene::with_look) and [`set`](Self::set).
    pub fn change_look(&mut self, change: impl FnOnce(&mut Look)) -> Result<()> {
        let prepared = self.renderer.prepared();
        let mut look = prepared.scene().look();
        change(&mut look);
        let prepared = prepared.with_scene(prepared.scene().with_look(look)?);
        let (image, compute) = (self.renderer.image_settings(), self.renderer.compute_settings());
        self.change(prepared, image.clone(), compute.clone())
    }

    fn change(
        &mut self,
        prepared: PreparedScene,
        image: ImageSettings,
        compute: ComputeSettings,
    ) -> Result<()> {
        let renderer = self.renderer.with(prepared, image, compute)?;
        let fresh = renderer.begin()?;
        let state = self.state.get_mut().expect("no thread panicked while it held the film");
        if !state.extend(renderer.prepared().scene(), renderer.image_settings()) {
            *state = fresh;
        }
        self.renderer = renderer;
        *self.cancelled.get_mut() = false;
        Ok(())
    }
}

struct Watch<'a> {
    session: &'a Session,
    observer: &'a dyn Observer,
    /// The begin of the call, and how long it may take.
    ends: Option<(Instant, Duration)>,
}

impl Observer for Watch<'_> {
    fn progressed(&self, progress: Progress) {
        self.observer.progressed(progress);
    }

    fn stop(&self) -> Stop {
        let is_late = |(begin, time): (Instant, Duration)| begin.elapsed() >= time;
        match self.observer.stop() {
            _ if self.session.cancelled.load(Ordering::Relaxed) => Stop::Now,
            Stop::No if self.ends.is_some_and(is_late) => Stop::Soon,
            stop => stop,
        }
    }
}
