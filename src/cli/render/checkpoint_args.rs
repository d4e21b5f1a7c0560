//! The arguments for checkpoints and time limits.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use jiff::SignedDuration;

use super::part_args::HEADING;

#[derive(Clone, Debug, Args)]
pub(crate) struct CheckpointArgs {
    /// Checkpoint file, a .film. If it exists and belongs to this render, the render continues from it, also
    /// with more samples than before; if it belongs to another render, ptfast stops with an error. The file is
    /// kept when the render is complete [default: NAME.partial.film beside the image, deleted when the render
    /// is complete]
    #[arg(long, help_heading = HEADING, value_name = "FILE")]
    pub(crate) checkpoint: Option<PathBuf>,
    /// Time between checkpoints, such as 90s or 1h30m. SIGUSR1 requests one at once
    #[arg(long, help_heading = HEADING, allow_hyphen_values = true, value_name = "TIME", default_value = "60s", value_parser = duration)]
    pub(crate) checkpoint_every: Duration,
    /// Stop after this time, such as 90s or 1h30m, with a checkpoint and exit code 75. Each run makes some
    /// progress, however short the limit
    #[arg(long, help_heading = HEADING, allow_hyphen_values = true, value_name = "TIME", value_parser = duration)]
    pub(crate) time_limit: Option<Duration>,
}

pub(super) fn duration(text: &str) -> Result<Duration, String> {
    let parsed = text.parse::<SignedDuration>().ok().and_then(|time| Duration::try_from(time).ok());
    parsed.filter(|time| !time.is_zero()).ok_or_else(|| "a time such as 90s or 1h30m".to_owned())
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
