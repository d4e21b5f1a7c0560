//! Renders that are kept: checkpoints while they go on, and what is left of them when they are stopped.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::thread::{self, ScopedJoinHandle};
use std::time::{Duration, Instant};

use clap::Args;
use jiff::SignedDuration;

use super::place::Place;
use super::progress::ProgressReport;
use super::watch::Watch;
use crate::checkpoint::Checkpoint;
use crate::engine::{Progress, Renderer};
use crate::error::{Error, Result};
use crate::image::{Metadata, Transfer};
use crate::interrupt;
use crate::output::{Pending, same_file};

/// So many times as long as a checkpoint took the render goes on before the next, whatever is asked for.
const LEAST_GAP: u32 = 4;

/// Time between checkpoints.
const INTERVAL: Duration = Duration::from_secs(60);

#[derive(Debug, Args)]
pub(super) struct KeepArgs {
    /// Keep what is rendered so far in this .film file, now and then, on SIGUSR1 and when stopped [default: that of
    /// --resume; without, one beside the image, only when stopped]
    #[arg(long, value_name = "FILE")]
    checkpoint: Option<PathBuf>,
    /// Time between checkpoints, such as 90s or 1h30m [default: 60s]
    #[arg(long, value_name = "TIME", value_parser = duration)]
    checkpoint_every: Option<Duration>,
    /// Stop after this time, such as 90s or 1h30m, with a checkpoint and exit code 75; something is rendered in any
    /// case
    #[arg(long, value_name = "TIME", value_parser = duration)]
    time_limit: Option<Duration>,
    /// Go on from a checkpoint of the same scene and settings; there may be more samples than it was for
    #[arg(long, value_name = "FILE")]
    pub(super) resume: Option<PathBuf>,
}

fn duration(text: &str) -> Result<Duration, String> {
    let parsed = text.parse::<SignedDuration>().ok().and_then(|time| Duration::try_from(time).ok());
    parsed.filter(|time| !time.is_zero()).ok_or_else(|| "a time such as 90s or 1h30m".to_owned())
}

/// When a render is kept.
pub(super) struct Keeping {
    /// The time between checkpoints; none where there is one only when it is stopped.
    pub(super) every: Option<Duration>,
    /// How long it may take from `start` on.
    pub(super) time_limit: Option<Duration>,
    /// When the program began.
    pub(super) start: Instant,
    /// How the image is shown as far as it is, when it is stopped; none for those who want no image.
    pub(super) transfer: Option<Transfer>,
}

impl KeepArgs {
    /// When a render of `output` that began at `start` is kept, of which there is an image where `transfer` says how.
    ///
    /// # Errors
    /// [`Error::Usage`] where there are to be checkpoints in no file.
    pub(super) fn keeping(
        &self,
        output: &Path,
        transfer: Option<Transfer>,
        start: Instant,
    ) -> Result<Keeping> {
        if self.checkpoint_every.is_some() && self.file(output).is_none() {
            let message = "--checkpoint-every: --checkpoint must name a file for them";
            return Err(Error::Usage(message.to_owned()));
        }
        let every = self.file(output).map(|_| self.checkpoint_every.unwrap_or(INTERVAL));
        Ok(Keeping { every, time_limit: self.time_limit, start, transfer })
    }

    /// Where a render of `output` is kept.
    pub(super) fn place(&self, output: &Path) -> Place {
        Place::new(output, self.file(output))
    }

    /// The file that the user named for checkpoints of `output`.
    fn file(&self, output: &Path) -> Option<&Path> {
        // A target is whole, or as it was.
        let resumed = self.resume.as_deref().filter(|file| !same_file(file, output));
        self.checkpoint.as_deref().or(resumed)
    }
}

/// Renders what is left of `checkpoint`, and keeps it as `keeping` says. Returns why the whole could not be kept,
/// which is no reason not to write the image.
///
/// # Errors
/// [`Error::Stopped`] where a signal or the limit of time ended it, and it is kept; else where it cannot be.
///
/// # Panics
/// As a worker did; what there is goes to the checkpoint that the user asked for.
pub(super) fn render(
    renderer: &Renderer<'_>,
    checkpoint: &mut Checkpoint,
    keeping: &Keeping,
    place: &mut Place,
    progress: &ProgressReport,
) -> Result<Option<Error>> {
    let mut gap = Duration::ZERO;
    loop {
        let watch = Watch::new(keeping, progress, gap);
        let advance = AssertUnwindSafe(|| renderer.advance(&mut checkpoint.rendering, &watch));
        let advanced = catch_unwind(advance);
        let has_failed = !matches!(advanced, Ok(Ok(())));
        if has_failed || checkpoint.is_complete() {
            progress.finish();
        }
        if has_failed && keeping.every.is_some() {
            // What is told is why the render ends.
            let _ = place.keep_in_the_end(checkpoint);
        }
        advanced.unwrap_or_else(|panic| resume_unwind(panic))?;
        if checkpoint.is_complete() {
            break;
        }
        interrupt::take_request();
        if watch.ends().is_some() {
            progress.finish();
            return Err(stopped(checkpoint, keeping, place, progress)?);
        }
        let start = Instant::now();
        let kept = place.keep(checkpoint);
        gap = LEAST_GAP * start.elapsed();
        let so_far = checkpoint.rendering.progress();
        match kept {
            Ok(()) => progress.kept("checkpoint", so_far, place.file()),
            // There may be room again when it is due the next time.
            Err(error) => progress.warn(so_far, &error),
        }
    }
    // It may be for more samples another time.
    let kept = keeping.every.map_or(Ok(()), |_| place.keep(checkpoint));
    Ok(kept.err())
}

/// Keeps a render that is stopped, shows it, and tells so. Where it cannot be kept, a limit of time is an error like
/// others.
fn stopped(
    checkpoint: &Checkpoint,
    keeping: &Keeping,
    place: &mut Place,
    progress: &ProgressReport,
) -> Result<Error> {
    let signal = interrupt::signal();
    let so_far = checkpoint.rendering.progress();
    let image = place.image();
    let draw = || draw(checkpoint, keeping, &image);
    // Both take their time, and there is little.
    let (mut kept, mut drawn) = thread::scope(|scope| {
        let drawing = thread::Builder::new().spawn_scoped(scope, draw);
        let kept = place.keep(checkpoint);
        // One after the other, where there are no more threads.
        let drawn = drawing.map_or_else(|_| Ok(draw()), ScopedJoinHandle::join);
        (kept, drawn.unwrap_or_else(|panic| resume_unwind(panic)))
    });
    if kept.is_err() || drawn.is_err() {
        // One may have taken the room of the other.
        drop(drawn);
        kept = kept.or_else(|_| place.keep_in_the_end(checkpoint));
        // Where nothing is kept, a signal may be from one who wants to see something at least.
        drawn = if kept.is_ok() || signal.is_some() { draw() } else { Ok(None) };
    }
    // The name is of the checkpoint.
    let image = place.image();
    let shown = drawn.and_then(|drawn| drawn.map(|drawn| drawn.replace(&image)).transpose());
    let mut told = match kept {
        Ok(()) => {
            progress.kept("stopped", so_far, place.file());
            go_on(place)
        }
        Err(error) => {
            progress.lost(so_far);
            match signal {
                None => return Err(with_earlier(error, place)),
                Some(_) if place.has_earlier() => format!("{}, as it was; {error}", go_on(place)),
                Some(_) => format!("nothing is kept, {error}"),
            }
        }
    };
    told += &match shown {
        Ok(None) => String::new(),
        Ok(Some(())) => format!(", {} shows it", image.display()),
        Err(error) => format!(", {error}"),
    };
    Ok(Error::Stopped { signal, percent: checkpoint.percent(), kept: told })
}

/// Keeps a render that is complete, whose image could not be written: `error` says why.
pub(super) fn instead(checkpoint: &Checkpoint, place: &mut Place, error: Error) -> Error {
    match place.keep_in_the_end(checkpoint) {
        Ok(()) => Error::Kept { error: Box::new(error), kept: go_on(place) },
        Err(_) => with_earlier(error, place),
    }
}

/// `error`, and what there is where nothing more could be kept.
fn with_earlier(error: Error, place: &Place) -> Error {
    match place.has_earlier() {
        true => {
            Error::Kept { error: Box::new(error), kept: format!("{}, as it was", go_on(place)) }
        }
        false => error,
    }
}

fn go_on(place: &Place) -> String {
    format!("go on with --resume {}", place.file().display())
}

/// The image as far as it is, where one is wanted, as a file that is to be beside `path`.
fn draw(checkpoint: &Checkpoint, keeping: &Keeping, path: &Path) -> Result<Option<Pending>> {
    let Some(transfer) = keeping.transfer else { return Ok(None) };
    let Progress { samples, .. } = checkpoint.rendering.progress();
    let image = checkpoint.rendering.image()?;
    let metadata = Metadata::of_program().with("ptfast:partial", samples);
    image.pending(path, transfer, &metadata).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_parsed() {
        let seconds = |text| duration(text).map(|time| time.as_secs_f64());
        assert_eq!(seconds("90s"), Ok(90.0));
        assert_eq!(seconds("1h30m"), Ok(5400.0));
        assert_eq!(seconds("500ms"), Ok(0.5));
        for wrong in ["", "90", "-5s", "0s", "5 parsecs"] {
            assert!(duration(wrong).is_err(), "{wrong}");
        }
    }
}
