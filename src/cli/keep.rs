//! Renders that are kept: checkpoints while they go on, and what is left of them when they are stopped.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;
use std::thread::{self, ScopedJoinHandle};
use std::time::{Duration, Instant};

use super::keep_args::Keeping;
use super::place::Place;
use super::progress::ProgressReport;
use super::watch::Watch;
use crate::checkpoint::Checkpoint;
use crate::engine::{Progress, Renderer};
use crate::error::{Error, Result};
use crate::image::Metadata;
use crate::interrupt;
use crate::output::Pending;

/// So many times as long as a checkpoint took the render goes on before the next, whatever is asked for.
const LEAST_GAP: u32 = 4;

/// Renders what is left of `checkpoint`, and keeps it as `keeping` says. Returns why the whole could not be kept,
/// which is no reason not to write the image.
///
/// # Errors
/// [`Error::Stopped`] where a signal or the limit of time ended it, and it is kept; else where it cannot be.
///
/// # Panics
/// As a worker did; what there is goes to the checkpoint that the user asked for.
pub(super) fn render(
    renderer: &Renderer,
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
    Ok(keeping.in_the_end.then(|| place.keep(checkpoint)).and_then(Result::err))
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
            go_on(place.file())
        }
        Err(error) => {
            progress.lost(so_far);
            match (signal, place.earlier()) {
                (None, _) => return Err(with_earlier(error, place)),
                (_, Some(file)) => format!("{}, as it was; {error}", go_on(file)),
                (_, None) => format!("nothing is kept, {error}"),
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
        Ok(()) => Error::Kept { error: Box::new(error), kept: go_on(place.file()) },
        Err(_) => with_earlier(error, place),
    }
}

/// `error`, and what there is where nothing more could be kept.
fn with_earlier(error: Error, place: &Place) -> Error {
    match place.earlier() {
        Some(file) => {
            Error::Kept { error: Box::new(error), kept: format!("{}, as it was", go_on(file)) }
        }
        None => error,
    }
}

fn go_on(file: &Path) -> String {
    format!("go on with --resume {}", file.display())
}

/// The image as far as it is, where one is wanted, as a file that is to be beside `path`.
fn draw(checkpoint: &Checkpoint, keeping: &Keeping, path: &Path) -> Result<Option<Pending>> {
    let Some(transfer) = keeping.transfer else { return Ok(None) };
    let Progress { samples, .. } = checkpoint.rendering.progress();
    let image = checkpoint.rendering.image()?;
    let metadata = Metadata::of_program().with("ptfast:partial", samples);
    image.pending(path, transfer, &metadata).map(Some)
}
