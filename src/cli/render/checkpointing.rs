//! Renders with checkpoints: at intervals, on SIGUSR1, and when the render is stopped.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use super::checkpoint_file::CheckpointFile;
use super::watch::{Schedule, Watch};
use crate::checkpoint::Checkpoint;
use crate::cli::progress::ProgressReport;
use crate::engine::{Layers, Renderer};
use crate::error::{Error, Result};
use crate::image::{Display, Metadata};
use crate::interrupt;

/// Minimum gap between checkpoints, as a multiple of the time that the last one took to write.
const MIN_GAP: u32 = 4;

/// Renders the rest of `checkpoint`, and writes it to `file` whenever `schedule` says.
///
/// # Errors
/// [`Error::Stopped`] when a signal or the time limit stops the render.
///
/// # Panics
/// When a worker panics. The samples that were finished before are in the checkpoint file.
pub(crate) fn render(
    renderer: &Renderer,
    checkpoint: &mut Checkpoint,
    file: &CheckpointFile,
    schedule: &Schedule,
    display: Display,
    progress: &ProgressReport,
) -> Result<()> {
    let mut gap = Duration::ZERO;
    loop {
        let watch = Watch::new(schedule, progress, gap);
        let advance = AssertUnwindSafe(|| renderer.advance(&mut checkpoint.rendering, &watch));
        let advanced = catch_unwind(advance);
        let failed = !matches!(advanced, Ok(Ok(())));
        if failed || checkpoint.is_complete() {
            progress.finish();
        }
        if failed {
            // Ignore an error of writing: the user must see the first panic or error.
            let _ = file.write(checkpoint);
        }
        advanced.unwrap_or_else(|panic| resume_unwind(panic))?;
        if checkpoint.is_complete() {
            return Ok(());
        }
        interrupt::take_request();
        if watch.ends().is_some() {
            progress.finish();
            return Err(stop(checkpoint, file, display, progress));
        }
        let start = Instant::now();
        let written = file.write(checkpoint);
        gap = MIN_GAP * start.elapsed();
        let so_far = checkpoint.rendering.progress();
        match written {
            Ok(()) => progress.saved("checkpoint", so_far, file.path()),
            // The render continues, because the next checkpoint may succeed.
            Err(error) => progress.warn(so_far, &error),
        }
    }
}

/// Saves a render that is stopped, and its picture so far. Returns the error that says how to continue.
fn stop(
    checkpoint: &Checkpoint,
    file: &CheckpointFile,
    display: Display,
    progress: &ProgressReport,
) -> Error {
    let (signal, so_far) = (interrupt::signal(), checkpoint.rendering.progress());
    let outcome = match file.write(checkpoint) {
        Ok(()) => {
            progress.saved("stopped", so_far, file.path());
            let path = file.path().display();
            let again = format!("run the same command again to continue from {path}");
            match file
                .own_picture()
                .map(|picture| (picture, write_picture(checkpoint, picture, display)))
            {
                None => again,
                Some((picture, Ok(()))) => {
                    format!("{again}; {} shows the picture so far", picture.display())
                }
                Some((_, Err(error))) => format!("{again}; {error}"),
            }
        }
        Err(error) => {
            progress.lost(so_far);
            let error = with_earlier(error, checkpoint, file);
            // The checkpoint is the only result of a run that ends at its time limit, so this
            // error is the one to return.
            if signal.is_none() {
                return error;
            }
            format!("cannot save it: {error}")
        }
    };
    Error::Stopped { signal, percent: checkpoint.percent(), outcome }
}

/// Saves a complete render whose image cannot be written. Returns `error` with the
/// path of the checkpoint.
pub(crate) fn save_instead(checkpoint: &Checkpoint, file: &CheckpointFile, error: Error) -> Error {
    match file.write(checkpoint) {
        Ok(()) => with_earlier(error, checkpoint, file),
        Err(_) => error,
    }
}

/// Adds to `error` the checkpoint from which the render can be continued, if there is one.
fn with_earlier(error: Error, checkpoint: &Checkpoint, file: &CheckpointFile) -> Error {
    if !file.has_part_of(&checkpoint.part()) {
        return error;
    }
    let outcome = format!("{} has a checkpoint of the render", file.path().display());
    Error::Saved { error: Box::new(error), outcome }
}

/// Writes the image of the samples that are done, without layers.
pub(crate) fn write_picture(checkpoint: &Checkpoint, path: &Path, display: Display) -> Result<()> {
    let samples = checkpoint.rendering.progress().samples;
    let metadata = Metadata::of_partial(samples);
    checkpoint.rendering.image_with(&Layers::default())?.write(path, display, &metadata)
}
