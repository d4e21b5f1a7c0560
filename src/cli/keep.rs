//! Renders that are kept: checkpoints while they go on, and what is left of them when they are stopped.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use clap::Args;
use jiff::SignedDuration;

use super::progress::ProgressReport;
use super::share::Share;
use crate::checkpoint::{Checkpoint, Identity};
use crate::engine::{Observer, Progress, Renderer, Stop};
use crate::error::{Error, Result};
use crate::image::{Image, Metadata, Transfer};
use crate::interrupt;
use crate::limits::Limits;

/// How long workers may take to finish what they are at, once a render is to be stopped.
const PATIENCE: Duration = Duration::from_millis(500);
/// Time between checkpoints.
const INTERVAL: Duration = Duration::from_secs(60);

#[derive(Debug, Args)]
pub(super) struct KeepArgs {
    /// Keep what is rendered so far in this .film file, now and then, on SIGUSR1 and when stopped [default: that
    /// of --resume, or one beside the image, when stopped]
    #[arg(long, value_name = "FILE")]
    pub(super) checkpoint: Option<PathBuf>,
    /// Time between checkpoints, such as 90s or 1h30m [default: 60s]
    #[arg(long, value_name = "TIME", requires = "checkpoint", value_parser = duration)]
    pub(super) checkpoint_every: Option<Duration>,
    /// Stop after this time, such as 90s or 1h30m, with a checkpoint and exit code 75
    #[arg(long, value_name = "TIME", value_parser = duration)]
    pub(super) time_limit: Option<Duration>,
    /// Go on from a checkpoint of the same scene and settings; there may be more samples than it was for
    #[arg(long, value_name = "FILE")]
    pub(super) resume: Option<PathBuf>,
}

fn duration(text: &str) -> Result<Duration, String> {
    let parsed = text.parse::<SignedDuration>().ok().and_then(|time| Duration::try_from(time).ok());
    parsed.filter(|time| !time.is_zero()).ok_or_else(|| "a time such as 90s or 1h30m".to_owned())
}

/// Where a render is kept, and when.
pub(super) struct Keeping {
    /// The checkpoint.
    pub(super) file: PathBuf,
    /// The time between checkpoints; none where there is one only when it is stopped.
    pub(super) every: Option<Duration>,
    /// How long it may take from `start` on.
    pub(super) time_limit: Option<Duration>,
    /// When the program began.
    pub(super) start: Instant,
    /// The image as far as it is, when it is stopped; none for those who want no image.
    pub(super) partial: Option<(PathBuf, Transfer)>,
}

impl Keeping {
    /// Refuses to begin anew what is kept already: it would be lost.
    ///
    /// # Errors
    /// [`Error::Usage`] that says how to go on.
    pub(super) fn check(&self, identity: &Identity, share: &Share, limits: &Limits) -> Result<()> {
        let file = self.file.display();
        let Ok(there) = Checkpoint::read(&self.file, limits) else { return Ok(()) };
        let percent = there.percent();
        let same = there.identity == *identity
            && there.shard == share.shard
            && there.rendering.film.samples() == share.samples;
        if same && there.rendering.film.samples_done() > 0 {
            return Err(Error::Usage(format!(
                "{file} has {percent}% of this render: go on with --resume {file}, or remove it"
            )));
        }
        match self.every {
            Some(_) if !same => Err(Error::Usage(format!(
                "{file} is of another render: name another file, or remove it"
            ))),
            _ => Ok(()),
        }
    }
}

impl KeepArgs {
    /// Of a render that writes `output`, an image where `transfer` says how.
    pub(super) fn keeping(
        &self,
        output: &Path,
        transfer: Option<Transfer>,
        start: Instant,
    ) -> Keeping {
        let given = self.checkpoint.as_ref().or(self.resume.as_ref());
        let partial = |extension: &str| {
            let stem = output.file_stem().unwrap_or_default().to_string_lossy();
            output.with_file_name(format!("{stem}.partial.{extension}"))
        };
        let extension = output.extension().unwrap_or_default().to_string_lossy();
        Keeping {
            file: given.cloned().unwrap_or_else(|| partial("film")),
            every: self.checkpoint.as_ref().map(|_| self.checkpoint_every.unwrap_or(INTERVAL)),
            time_limit: self.time_limit,
            start,
            partial: transfer.map(|transfer| (partial(&extension), transfer)),
        }
    }
}

/// Renders what is left of `checkpoint`, and keeps it as `keeping` says. Returns why the whole could not be kept,
/// which is no reason not to write the image.
///
/// # Errors
/// [`Error::Stopped`] where a signal or the limit of time ended it, and it is kept; else where it cannot be.
pub(super) fn render(
    renderer: &Renderer<'_>,
    checkpoint: &mut Checkpoint,
    keeping: &Keeping,
    progress: &ProgressReport,
) -> Result<Option<Error>> {
    loop {
        let watch = Watch::new(keeping, progress);
        let advanced = renderer.advance(&mut checkpoint.rendering, &watch);
        if advanced.is_err() || checkpoint.is_complete() {
            progress.finish();
        }
        advanced?;
        let so_far = checkpoint.rendering.progress();
        if checkpoint.is_complete() {
            progress.done(so_far);
            break;
        }
        interrupt::take_request();
        let kept = checkpoint.write(&keeping.file);
        // A signal may have come meanwhile.
        if watch.ends().is_some() {
            progress.finish();
            progress.kept("stopped", so_far, &keeping.file);
            return Err(stopped(checkpoint, keeping, kept)?);
        }
        match kept {
            Ok(()) => progress.kept("checkpoint", so_far, &keeping.file),
            // There may be room again when it is due the next time.
            Err(error) => progress.warn(so_far, &error),
        }
    }
    // It may be for more samples another time.
    let kept = keeping.every.map_or(Ok(()), |_| checkpoint.write(&keeping.file));
    Ok(kept.err())
}

/// Tells that a render was stopped, and shows it; `kept` is whether its checkpoint is written, without which a limit
/// of time is an error like others.
fn stopped(checkpoint: &Checkpoint, keeping: &Keeping, kept: Result<()>) -> Result<Error> {
    let signal = interrupt::signal();
    let mut kept = match kept {
        Ok(()) => format!("go on with --resume {}", keeping.file.display()),
        Err(error) if signal.is_none() => return Err(error),
        Err(error) => format!("nothing is kept, {error}"),
    };
    if let Some((path, transfer)) = &keeping.partial {
        let Progress { samples, .. } = checkpoint.rendering.progress();
        let area = checkpoint.identity.area();
        let means = checkpoint.rendering.film.means()?;
        let image = Image::from_pixels(area.width, area.height, means);
        let metadata = Metadata::of_program().with("ptfast:partial", samples);
        // What can be continued is there already.
        kept += &match image.write(path, *transfer, &metadata) {
            Ok(()) => format!(", {} shows it", path.display()),
            Err(error) => format!(", {error}"),
        };
    }
    Ok(Error::Stopped { signal, percent: checkpoint.percent(), kept })
}

/// Watches a render, and stops it where something is to be done.
struct Watch<'a> {
    keeping: &'a Keeping,
    progress: &'a ProgressReport,
    last_kept: Instant,
    /// When it was first noticed that the render is to end.
    noticed: OnceLock<Instant>,
}

impl<'a> Watch<'a> {
    fn new(keeping: &'a Keeping, progress: &'a ProgressReport) -> Self {
        Self { keeping, progress, last_kept: Instant::now(), noticed: OnceLock::new() }
    }

    /// Whether the render is to end, and since when that is known.
    fn ends(&self) -> Option<Instant> {
        let limit = self.keeping.time_limit;
        let ends = interrupt::signal().is_some()
            || limit.is_some_and(|limit| self.keeping.start.elapsed() >= limit);
        ends.then(|| *self.noticed.get_or_init(Instant::now))
    }

    fn is_to_be_kept(&self) -> bool {
        let due = |every: Duration| self.last_kept.elapsed() >= every;
        self.keeping.every.is_some_and(due) || interrupt::is_requested()
    }
}

impl Observer for Watch<'_> {
    fn progressed(&self, progress: Progress) {
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
