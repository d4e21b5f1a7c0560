//! Renders that are kept: checkpoints while they go on, and what is left of them when they are stopped.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, ScopedJoinHandle};
use std::time::{Duration, Instant};

use clap::Args;
use jiff::SignedDuration;

use super::place::Place;
use super::progress::ProgressReport;
use crate::checkpoint::Checkpoint;
use crate::engine::{Observer, Progress, Renderer, Stop};
use crate::error::{Error, Result};
use crate::image::{Metadata, Transfer};
use crate::interrupt;
use crate::output::{Pending, same_file};

/// How long workers may take to finish what they are at, once a render is to be stopped.
const PATIENCE: Duration = Duration::from_millis(500);
/// So many times as long as a checkpoint took the render goes on before the next, whatever is asked for.
const LEAST_GAP: u32 = 4;

/// Time between checkpoints.
const INTERVAL: Duration = Duration::from_secs(60);

#[derive(Debug, Args)]
pub(super) struct KeepArgs {
    /// Keep what is rendered so far in this .film file, now and then, on SIGUSR1 and when stopped [default: that of
    /// --resume, or one beside the image, when stopped]
    #[arg(long, value_name = "FILE")]
    checkpoint: Option<PathBuf>,
    /// Time between checkpoints, such as 90s or 1h30m [default: 60s]
    #[arg(long, value_name = "TIME", requires = "checkpoint", value_parser = duration)]
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
    every: Option<Duration>,
    /// How long it may take from `start` on.
    time_limit: Option<Duration>,
    /// When the program began.
    start: Instant,
    /// How the image is shown as far as it is, when it is stopped; none for those who want no image.
    pub(super) transfer: Option<Transfer>,
}

impl KeepArgs {
    /// When a render that began at `start` is kept, of which there is an image where `transfer` says how.
    pub(super) fn keeping(&self, transfer: Option<Transfer>, start: Instant) -> Keeping {
        let every = self.checkpoint.as_ref().map(|_| self.checkpoint_every.unwrap_or(INTERVAL));
        Keeping { every, time_limit: self.time_limit, start, transfer }
    }

    /// Where a render of `output` is kept.
    pub(super) fn place(&self, output: &Path) -> Place {
        // A target is whole, or as it was.
        let resumed = self.resume.as_deref().filter(|file| !same_file(file, output));
        Place::new(output, self.checkpoint.as_deref().or(resumed))
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
    let (kept, drawn) = thread::scope(|scope| {
        let drawing = thread::Builder::new().spawn_scoped(scope, draw);
        let kept = place.keep_in_the_end(checkpoint);
        // One after the other, where there are no more threads.
        let drawn = drawing.map_or_else(|_| Ok(draw()), ScopedJoinHandle::join);
        (kept, drawn.unwrap_or_else(|panic| resume_unwind(panic)))
    });
    // The name is of the checkpoint.
    let image = place.image();
    let shown = drawn.and_then(|drawn| drawn.map(|drawn| drawn.replace(&image)).transpose());
    let mut told = match kept {
        Ok(()) => {
            progress.kept("stopped", so_far, place.file());
            format!("go on with --resume {}", place.file().display())
        }
        Err(error) => {
            progress.lost(so_far);
            if signal.is_none() {
                return Err(error);
            }
            format!("nothing is kept, {error}")
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
    if place.keep_in_the_end(checkpoint).is_err() {
        return error;
    }
    let kept = format!("go on with --resume {}", place.file().display());
    Error::Kept { error: Box::new(error), kept }
}

/// The image as far as it is, where one is wanted, as a file that is to be beside `path`.
fn draw(checkpoint: &Checkpoint, keeping: &Keeping, path: &Path) -> Result<Option<Pending>> {
    let Some(transfer) = keeping.transfer else { return Ok(None) };
    let Progress { samples, .. } = checkpoint.rendering.progress();
    let image = checkpoint.rendering.image()?;
    let metadata = Metadata::of_program().with("ptfast:partial", samples);
    image.pending(path, transfer, &metadata).map(Some)
}

/// Watches a render, and stops it where something is to be done.
struct Watch<'a> {
    keeping: &'a Keeping,
    progress: &'a ProgressReport,
    /// When it began, and how long it goes on at least before it is kept.
    start: Instant,
    gap: Duration,
    /// Whether something was done since: a limit of time that was over before would end every run at nothing.
    advanced: AtomicBool,
    /// When it was first noticed that the render is to end.
    noticed: OnceLock<Instant>,
}

impl<'a> Watch<'a> {
    fn new(keeping: &'a Keeping, progress: &'a ProgressReport, gap: Duration) -> Self {
        let (start, advanced) = (Instant::now(), AtomicBool::new(false));
        Self { keeping, progress, start, gap, advanced, noticed: OnceLock::new() }
    }

    /// Whether the render is to end, and since when that is known.
    fn ends(&self) -> Option<Instant> {
        let is_over = |limit: Duration| self.keeping.start.elapsed() >= limit;
        let ends = interrupt::signal().is_some()
            || self.keeping.time_limit.is_some_and(is_over)
                && self.advanced.load(Ordering::Relaxed);
        ends.then(|| *self.noticed.get_or_init(Instant::now))
    }

    fn is_to_be_kept(&self) -> bool {
        let since = self.start.elapsed();
        let due = self.keeping.every.is_some_and(|every| since >= every);
        let advanced = self.advanced.load(Ordering::Relaxed);
        due && since >= self.gap || interrupt::is_requested() && advanced
    }
}

impl Observer for Watch<'_> {
    fn progressed(&self, progress: Progress) {
        self.advanced.store(true, Ordering::Relaxed);
        self.progress.progressed(progress);
    }

    fn stop(&self) -> Stop {
        match self.ends() {
            Some(noticed) if noticed.elapsed() > PATIENCE => Stop::Now,
            Some(_) => Stop::Soon,
            None if self.is_to_be_kept() => Stop::Soon,
            None => Stop::No,
        }
    }
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
