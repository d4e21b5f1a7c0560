//! Renders with checkpoints: at intervals, on SIGUSR1, and when the render is stopped.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use super::checkpoint_file::CheckpointFile;
use super::goal::{Course, Goal, Pass};
use super::watch::{Saving, Schedule, Watch};
use crate::checkpoint::Part;
use crate::cli::arguments::denoise::DenoiseArgs;
use crate::cli::progress::ProgressReport;
use crate::engine::{Layers, Session, Until};
use crate::error::{Error, Result};
use crate::image::{Display, Metadata};
use crate::interrupt;

/// Minimum gap between checkpoints, as a multiple of the time that the last one took to write.
const MIN_GAP: u32 = 4;

/// A render, and where its samples are saved.
pub(crate) struct Saved<'a> {
    pub(crate) session: &'a Session,
    /// Name of the scene.
    pub(crate) scene: &'a str,
    pub(crate) part: &'a Part,
    pub(crate) file: &'a CheckpointFile<'a>,
    /// When the render ends, if not with a number of samples.
    pub(crate) goal: Option<Goal>,
    /// How the picture will be denoised.
    pub(crate) denoise: &'a DenoiseArgs,
    /// The appearance of the picture so far.
    pub(crate) display: Display,
}

impl Saved<'_> {
    /// Renders the rest, and saves it whenever `schedule` says.
    ///
    /// # Errors
    /// [`Error::Stopped`] when a signal or the time limit stops the render.
    ///
    /// # Panics
    /// When a worker panics. The samples that were finished before are in the checkpoint file.
    pub(crate) fn render(
        &self,
        schedule: &Schedule,
        progress: &ProgressReport,
    ) -> Result<Course<'_>> {
        let mut course = Course::new(self.session, self.goal, self.denoise);
        let mut last = Saving { end: Instant::now(), gap: Duration::ZERO };
        loop {
            let next = course.next();
            if !matches!(next, Ok(Some(_))) {
                progress.finish();
            }
            if next.is_err() {
                // Ignore an error of writing: the user must see the first error.
                let _ = self.save();
            }
            let Some(Pass { end, total }) = next? else { return Ok(course) };
            progress.expect(self.session.state().film.pixels() * u64::from(total));
            self.pass(end, schedule, progress, &mut last)?;
        }
    }

    /// Renders until all pixels have `end` samples.
    fn pass(
        &self,
        end: u32,
        schedule: &Schedule,
        progress: &ProgressReport,
        last: &mut Saving,
    ) -> Result<()> {
        loop {
            let watch = Watch::new(schedule, progress, last);
            let render = || self.session.render(Until::Samples(end), &watch);
            let rendered = catch_unwind(AssertUnwindSafe(render));
            if !matches!(rendered, Ok(Ok(_))) {
                progress.finish();
                // Ignore an error of writing: the user must see the first panic or error.
                let _ = self.save();
            }
            let so_far = rendered.unwrap_or_else(|panic| resume_unwind(panic))?;
            if self.session.samples() >= end {
                return Ok(());
            }
            interrupt::take_request();
            if watch.ends().is_some() {
                progress.finish();
                return Err(self.stop(progress));
            }
            let start = Instant::now();
            let saved = self.save();
            *last = Saving { end: Instant::now(), gap: MIN_GAP * start.elapsed() };
            match saved {
                Ok(()) => progress.saved("checkpoint", so_far, self.file.path()),
                // The render continues, because the next checkpoint may succeed.
                Err(error) => progress.warn(so_far, &error),
            }
        }
    }

    /// Writes the checkpoint. That of a render with a goal ends with the samples that there are, so that one with any
    /// larger number continues it.
    fn save(&self) -> Result<()> {
        let mut state = self.session.state();
        if self.goal.is_none() {
            return self.file.write(&self.part.checkpoint(self.scene, &state));
        }
        let (mut part, end) = (self.part.clone(), state.film.samples().end);
        part.end_at(state.film.most_done().max(1));
        state.film.end_at(part.samples.end);
        let saved = self.file.write(&part.checkpoint(self.scene, &state));
        state.film.grow(end);
        saved
    }

    /// Saves a render that is stopped, and its picture so far. Returns the error that says how to continue.
    fn stop(&self, progress: &ProgressReport) -> Error {
        let Self { session, file, .. } = self;
        let (signal, so_far) = (interrupt::signal(), session.progress());
        let outcome = match self.save() {
            Ok(()) => {
                progress.saved("stopped", so_far, file.path());
                let path = file.path().display();
                let again = format!("run the same command again to continue from {path}");
                match file.own_picture().map(|picture| (picture, self.write_picture(picture))) {
                    None => again,
                    Some((picture, Ok(()))) => {
                        format!("{again}; {} shows the picture so far", picture.display())
                    }
                    Some((_, Err(error))) => format!("{again}; {error}"),
                }
            }
            Err(error) => {
                progress.lost(so_far);
                let error = self.with_earlier(error);
                // The checkpoint is the only result of a run that ends at its time limit, so this
                // error is the one to return.
                if signal.is_none() {
                    return error;
                }
                format!("cannot save it: {error}")
            }
        };
        Error::Stopped { signal, samples: self.samples_per_pixel(), outcome }
    }

    /// The number of samples per pixel so far, such as `12.5 of 100 samples per pixel`.
    pub(crate) fn samples_per_pixel(&self) -> String {
        let state = self.session.state();
        let done = (100.0 * state.samples_per_pixel()).floor() / 100.0;
        let of = match self.goal {
            Some(_) => String::new(),
            None => format!(" of {}", state.film.samples().len()),
        };
        format!("{done}{of} samples per pixel")
    }

    /// Saves a complete render whose image cannot be written. Returns `error` with the path of the
    /// checkpoint.
    pub(crate) fn save_instead(&self, error: Error) -> Error {
        match self.save() {
            Ok(()) => self.with_earlier(error),
            Err(_) => error,
        }
    }

    /// Adds to `error` the checkpoint from which the render can be continued, if there is one.
    fn with_earlier(&self, error: Error) -> Error {
        if !self.file.has_samples() {
            return error;
        }
        let outcome = format!("{} has a checkpoint of the render", self.file.path().display());
        Error::Saved { error: Box::new(error), outcome }
    }

    /// Writes the image of the samples that are done, without layers.
    fn write_picture(&self, path: &Path) -> Result<()> {
        let metadata = Metadata::of_partial(self.session.progress().samples);
        let image = self.session.state().image_with(&Layers::default())?;
        image.write(path, self.display, &metadata)
    }
}
