//! A render in progress: the samples, counts and times so far.

use std::borrow::BorrowMut;
use std::sync::{Mutex, MutexGuard};
use std::time::Instant;

use super::{
    Event, ImageSettings, Lap, Layer, Layers, Rows, Taken, Tally, Task, WaveStats, develop,
};
use crate::error::{Error, Result};
use crate::film::{Film, Schedule, UnitSums};
use crate::image::{Image, ImageLayer};
use crate::scene::Scene;

/// Maximum number of events of a timeline: about a hundred megabytes.
pub(crate) const MOST_EVENTS: usize = 1 << 21;

/// Number of finished units, of some thousand paths each, that may wait for an earlier unit. Each
/// worker may exceed it by one.
const MOST_EARLY: usize = 1000;

/// A render in progress.
#[derive(Clone, Debug)]
pub struct RenderState {
    /// The samples rendered so far.
    #[doc(hidden)]
    pub film: Film,
    /// Counts of rays, path endings and samples so far.
    pub tally: Tally,
    /// The work of the wavefront engine's stages. For the scalar engine, the counted work of its
    /// rays, but no times; empty unless the settings ask for counting.
    pub(crate) waves: WaveStats,
    /// Wall-clock seconds of rendering so far.
    pub seconds: f64,
    /// The activities of all workers, if the settings ask for them. Only the first
    /// `MOST_EVENTS` are kept.
    pub(crate) timeline: Vec<Event>,
    /// The scene and settings that the samples belong to; `None` before the first pass.
    source: Option<(Scene, ImageSettings)>,
    /// The settings of the film.
    settings: ImageSettings,
}

impl RenderState {
    /// A rendering with the samples of `film`, whose layers are those of `settings`, and with empty counts.
    pub(crate) fn new(film: Film, settings: &ImageSettings) -> Self {
        Self {
            film,
            settings: settings.clone(),
            tally: Tally::default(),
            waves: WaveStats::default(),
            seconds: 0.0,
            timeline: Vec::new(),
            source: None,
        }
    }

    /// Records that the following samples belong to `scene` and `settings`.
    ///
    /// # Errors
    /// If earlier samples belong to another scene, or to other settings that affect the image,
    /// returns [`Error::Usage`].
    pub(super) fn claim(&mut self, scene: &Scene, settings: &ImageSettings) -> Result<()> {
        match &self.source {
            Some((other, with)) if other != scene || !with.same_image(settings) => {
                let message = "the rendering has samples of another scene, camera or setting: begin a new one";
                Err(Error::Usage(message.to_owned()))
            }
            Some(_) => Ok(()),
            None => {
                self.source = Some((scene.clone(), settings.clone()));
                Ok(())
            }
        }
    }

    /// Makes room for more samples, if the scene and all other settings stay the same. Returns whether they do.
    pub(super) fn extend(&mut self, scene: &Scene, settings: &ImageSettings) -> bool {
        let same =
            |(other, with): &(Scene, ImageSettings)| other == scene && with.same_image(settings);
        let extended = self.source.as_ref().is_some_and(same) && settings.spp >= self.settings.spp;
        if extended {
            self.film.grow(settings.spp);
            self.settings = settings.clone();
        }
        extended
    }

    /// Adds the counts and seconds of another part of the same render.
    pub(crate) fn add(&mut self, other: &Self) {
        self.tally.add(&other.tally);
        self.seconds += other.seconds;
    }

    /// Returns the image rendered so far, with its layers. Pixels without samples are black. If the background
    /// is hidden, the image has an alpha channel.
    ///
    /// # Errors
    /// If there is not enough memory for the image, returns [`Error::Resource`].
    pub fn image(&self) -> Result<Image> {
        self.image_with(&self.settings.layers)
    }

    /// [`image`](Self::image) with only those of the film's layers that are `wanted`.
    pub(crate) fn image_with(&self, wanted: &Layers) -> Result<Image> {
        develop(&self.settings, wanted, self.film.area(), &Rows::all(&self.film))
    }

    /// Returns a layer of the image rendered so far; `None` if the film lacks it.
    ///
    /// # Errors
    /// If there is not enough memory for it, returns [`Error::Resource`].
    pub fn layer(&self, layer: Layer) -> Result<Option<ImageLayer>> {
        let image = self.image_with(&Layers::new([layer]))?;
        Ok(image.layer(layer.name()).cloned())
    }

    /// Ends the render with the first `samples` samples of each pixel, which all pixels have.
    pub(super) fn end_at(&mut self, samples: u32) {
        self.film.end_at(samples);
        self.settings.spp = samples;
        if let Some((_, settings)) = &mut self.source {
            settings.spp = samples;
        }
    }

    /// An estimate of the image's relative error, as far as the number of samples gives one: see
    /// [`Session::noise`](super::Session::noise).
    pub(super) fn noise(&self) -> Result<Option<f64>> {
        self.film.relative_error()
    }

    /// Whether all pixels have all samples.
    pub fn is_complete(&self) -> bool {
        self.film.samples_done() == self.film.samples_to_do()
    }

    /// The percentage of the samples that are done, rounded down.
    pub fn percent(&self) -> u64 {
        self.film.samples_done() * 100 / self.film.samples_to_do().max(1)
    }

    /// The mean number of finished samples per pixel.
    pub(crate) fn samples_per_pixel(&self) -> f64 {
        let samples = f64::from(self.film.samples().end - self.film.samples().start);
        samples * self.film.samples_done() as f64 / self.film.samples_to_do().max(1) as f64
    }

    /// The progress of the render so far.
    pub fn progress(&self) -> Progress {
        Progress { samples: self.film.samples_done(), rays: self.tally.rays.total() }
    }
}

/// Progress of a render.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// Number of finished samples.
    pub samples: u64,
    /// Number of traced rays.
    pub rays: u64,
}

/// The state that the workers of a pass share.
#[derive(Debug)]
pub(super) struct Shared<'a, S> {
    /// Locked for a moment only, so that other threads may look at it.
    rendering: &'a Mutex<S>,
    schedule: Schedule,
    progress: Progress,
    start: Instant,
    /// Seconds at which the timeline of earlier passes ends: the offset of new events.
    before: f64,
    /// Finished units whose pixels lack earlier samples, which another worker is still rendering.
    early: Vec<(UnitSums, Tally)>,
}

/// Locks `mutex`.
///
/// # Panics
/// If a thread panicked while it held the lock.
pub(super) fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().expect("no thread panics while it holds the lock")
}

impl<'a, S: BorrowMut<RenderState>> Shared<'a, S> {
    pub(super) fn new(rendering: &'a Mutex<S>, schedule: Schedule) -> Self {
        let state = locked(rendering);
        let state = (*state).borrow();
        let ends = state.timeline.iter().map(|event| event.start + event.seconds);
        let before = ends.fold(0.0, f64::max);
        let (progress, start) = (state.progress(), Instant::now());
        Self { rendering, schedule, progress, start, before, early: Vec::new() }
    }

    /// Whether the limit of finished units that wait for an earlier one is reached.
    pub(super) fn is_far_ahead(&self) -> bool {
        self.early.len() >= MOST_EARLY
    }

    /// Returns the next unit of work; `None` if no unit is left.
    pub(super) fn next(&mut self) -> Option<Task> {
        let state = locked(self.rendering);
        let film = &(*state).borrow().film;
        let unit = self.schedule.next(film)?;
        Some(Task { unit, open: film.open_sums(unit), channels: film.channels() })
    }

    /// Adds a finished unit of worker number `worker`, and returns the progress of the render.
    ///
    /// # Errors
    /// If there is not enough memory for its samples, returns [`Error::Resource`].
    pub(super) fn add(&mut self, taken: Taken, worker: usize) -> Result<Progress> {
        let Taken { part, tally, waves, laps } = taken;
        let mut state = locked(self.rendering);
        let RenderState { film, tally: all, waves: all_waves, timeline, .. } =
            (*state).borrow_mut();
        all_waves.add(&waves);
        let room = MOST_EVENTS - timeline.len();
        let event = |lap: &Lap| {
            let event = lap.event(self.start, worker);
            Event { start: event.start + self.before, ..event }
        };
        timeline.extend(laps.iter().take(room).map(event));
        self.early.push((part, tally));
        while let Some(index) = self.early.iter().position(|(part, _)| film.is_next(part.unit)) {
            let (part, tally) = self.early.swap_remove(index);
            film.add(&part)?;
            all.add(&tally);
            self.progress.samples += part.unit.paths();
            self.progress.rays += tally.rays.total();
        }
        Ok(self.progress)
    }
}
