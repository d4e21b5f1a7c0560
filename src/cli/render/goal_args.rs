//! The arguments that end a render by time or noise instead of a number of samples.

use std::time::{Duration, Instant};

use clap::Args;

use super::checkpoint_args::duration;
use super::goal::Goal;
use crate::cli::arguments::IMAGE;
use crate::error::{Error, Result};
use crate::limits::MAX_SPP;

/// Largest number of samples per pixel, unless the user gives another.
const MOST: u32 = 65_536;

/// What these arguments cannot be combined with.
const OTHERS: [&str; 4] = ["spp", "shard", "sample_range", "skip_complete"];

#[derive(Clone, Debug, Args)]
pub(crate) struct GoalArgs {
    /// Take this time, such as 10s or 1h30m, from the start of the program to the finished file. All pixels get
    /// the same number of samples, at least one, and --spp with this number renders the same image
    #[arg(long, value_name = "TIME", help_heading = IMAGE, allow_hyphen_values = true, conflicts_with_all = OTHERS, value_parser = duration)]
    time: Option<Duration>,
    /// Render until the relative error is estimated to be below this, such as 2%: that of the denoised picture with
    /// --denoise
    #[arg(long, value_name = "ERROR", help_heading = IMAGE, allow_hyphen_values = true, conflicts_with_all = OTHERS, value_parser = percentage)]
    noise: Option<f64>,
    /// Largest number of samples per pixel with --time and --noise [default: 65536]
    #[arg(long, value_name = "N", help_heading = IMAGE, conflicts_with = "spp", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SPP)))]
    max_spp: Option<u32>,
}

impl GoalArgs {
    /// The goal, if there is one, of a program that started at `start`.
    ///
    /// # Errors
    /// If there is a limit without a goal.
    pub(crate) fn goal(&self, start: Instant) -> Result<Option<Goal>> {
        let Self { time, noise, max_spp } = *self;
        let goal = Goal { time, noise, most: max_spp.unwrap_or(MOST), denoising: 0.0, start };
        match (time.is_some() || noise.is_some(), max_spp) {
            (true, _) => Ok(Some(goal)),
            (false, None) => Ok(None),
            (false, Some(_)) => {
                Err(Error::Usage("--max-spp is for renders with --time or --noise".to_owned()))
            }
        }
    }
}

fn percentage(text: &str) -> std::result::Result<f64, String> {
    let number = text.strip_suffix('%').and_then(|number| number.trim().parse::<f64>().ok());
    let share =
        number.map(|percent| percent / 100.0).filter(|share| *share > 0.0 && *share <= 10.0);
    share.ok_or_else(|| "must be a percentage such as 2%, above 0% and at most 1000%".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentages_are_parsed() {
        assert_eq!((percentage("2%"), percentage("0.5 %")), (Ok(0.02), Ok(0.005)));
        for wrong in ["", "%", "2", "0%", "-1%", "nan%", "inf%", "1001%"] {
            assert!(percentage(wrong).is_err(), "{wrong}");
        }
    }
}
