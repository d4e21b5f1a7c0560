//! When and where a render is kept, as it is asked for.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use jiff::SignedDuration;

use super::place::Place;
use crate::error::{Error, Result};
use crate::image::Transfer;
use crate::output::same_file;

/// Time between checkpoints.
const INTERVAL: Duration = Duration::from_secs(60);

#[derive(Debug, Args)]
pub(super) struct KeepArgs {
    /// Keep what is rendered so far in this .film file, now and then, on SIGUSR1, when stopped and in the end [default:
    /// that of --resume, if it is for as many samples, but not in the end; else one beside the image, on SIGUSR1 and
    /// when stopped]
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
    /// The time between checkpoints; none where there is one only on SIGUSR1 and when it is stopped.
    pub(super) every: Option<Duration>,
    /// Whether it is kept when it is complete, too.
    pub(super) in_the_end: bool,
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
        let every = self.file(output).map(|_| self.checkpoint_every.unwrap_or(INTERVAL));
        self.check(every)?;
        let in_the_end = self.checkpoint.is_some();
        Ok(Keeping { every, in_the_end, time_limit: self.time_limit, start, transfer })
    }

    /// Where a render of `output` is kept.
    pub(super) fn place(&self, output: &Path) -> Place {
        Place::new(output, self.file(output), self.resume.as_deref())
    }

    /// Has a render of more samples than what is resumed leave that as it is, unless the user names it for both.
    ///
    /// # Errors
    /// As [`keeping`](Self::keeping).
    pub(super) fn spare_resumed(&self, keeping: &mut Keeping, place: &mut Place) -> Result<()> {
        if self.checkpoint.is_none() && keeping.every.take().is_some() {
            place.leave();
        }
        self.check(keeping.every)
    }

    fn check(&self, every: Option<Duration>) -> Result<()> {
        match (self.checkpoint_every, every) {
            (Some(_), None) => {
                let message = "--checkpoint-every: --checkpoint must name a file for them";
                Err(Error::Usage(message.to_owned()))
            }
            _ => Ok(()),
        }
    }

    /// The file that the user named for checkpoints of `output`.
    fn file(&self, output: &Path) -> Option<&Path> {
        // A target is whole, or as it was.
        let resumed = self.resume.as_deref().filter(|file| !same_file(file, output));
        self.checkpoint.as_deref().or(resumed)
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
