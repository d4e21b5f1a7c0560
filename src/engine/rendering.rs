//! A render under way: what there is of it so far.

use std::time::Instant;

use super::settings::RenderSettings;
use super::stats::WaveStats;
use super::tally::Tally;
use super::timeline::{Event, Lap};
use super::unit::{Taken, Task};
use crate::error::{Error, Result};
use crate::film::{Film, Part, Schedule, Tile};
use crate::image::Image;
use crate::scene::Scene;

/// Events of a timeline, at most: some hundred megabytes.
pub(crate) const MOST_EVENTS: usize = 1 << 21;

/// Units that wait for another, at most, but for one a worker: each has some thousand paths.
const MOST_EARLY: usize = 1000;

/// A render under way.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// The samples so far.
    #[doc(hidden)]
    pub film: Film,
    /// What was traced for them, and what came of it.
    pub tally: Tally,
    /// What the stages of the wavefront engine did; of the scalar engine, where it is asked to count,
    /// the work of its rays, without times.
    pub(crate) waves: WaveStats,
    /// Wall-clock seconds that it took.
    pub seconds: f64,
    /// What each worker did when, if that was asked for; the first `MOST_EVENTS`.
    pub(crate) timeline: Vec<Event>,
    /// The scene and the settings of the samples, once there are any.
    source: Option<(Scene, RenderSettings)>,
}

impl Rendering {
    /// Nothing but a film.
    pub(crate) fn new(film: Film) -> Self {
        Self {
            film,
            tally: Tally::default(),
            waves: WaveStats::default(),
            seconds: 0.0,
            timeline: Vec::new(),
            source: None,
        }
    }

    /// Notes that samples of `scene` with `settings` are to come.
    ///
    /// # Errors
    /// [`Error::Usage`] if there are samples of another scene, or with other settings that decide the image.
    pub(super) fn claim(&mut self, scene: &Scene, settings: &RenderSettings) -> Result<()> {
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

    /// Counts what was traced for another part of the render, too.
    pub(crate) fn add(&mut self, other: &Self) {
        self.tally.add(&other.tally);
        self.seconds += other.seconds;
    }

    /// The image as far as it is; black where nothing is done.
    ///
    /// # Errors
    /// [`Error::Internal`] where there is no memory for it.
    pub fn image(&self) -> Result<Image> {
        let Tile { width, height, .. } = self.film.area();
        Ok(Image::from_pixels(width, height, self.film.means()?))
    }

    /// How far it is.
    pub fn progress(&self) -> Progress {
        Progress { samples: self.film.samples_done(), rays: self.tally.rays.total() }
    }
}

/// How far a render is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// Samples finished.
    pub samples: u64,
    /// Rays traced.
    pub rays: u64,
}

/// What the workers share.
#[derive(Debug)]
pub(super) struct Shared<'a> {
    rendering: &'a mut Rendering,
    schedule: Schedule,
    progress: Progress,
    start: Instant,
    /// Seconds of the timeline that were before.
    before: f64,
    /// What came of units whose pixels lack earlier samples, which another worker still has.
    early: Vec<(Part, Tally)>,
}

impl<'a> Shared<'a> {
    pub(super) fn new(rendering: &'a mut Rendering, schedule: Schedule) -> Self {
        let ends = rendering.timeline.iter().map(|event| event.start + event.seconds);
        let before = ends.fold(0.0, f64::max);
        let (progress, start) = (rendering.progress(), Instant::now());
        Self { rendering, schedule, progress, start, before, early: Vec::new() }
    }

    /// Whether so much waits for what another worker still has that more would take memory in vain.
    pub(super) fn is_far_ahead(&self) -> bool {
        self.early.len() >= MOST_EARLY
    }

    /// The next unit of work.
    pub(super) fn next(&mut self) -> Option<Task> {
        let film = &self.rendering.film;
        let unit = self.schedule.next(film)?;
        Some(Task { unit, open: film.open_sums(unit) })
    }

    /// Adds what came of one, and tells how far the render is.
    ///
    /// # Errors
    /// Where there is no memory for it.
    pub(super) fn add(&mut self, taken: Taken, worker: usize) -> Result<Progress> {
        let Taken { part, tally, waves, laps } = taken;
        let Rendering { film, tally: all, waves: all_waves, timeline, .. } = &mut *self.rendering;
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
