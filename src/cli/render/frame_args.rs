//! The arguments for frames of an animation.

use std::ops::Range;

use clap::Args;

/// Heading in the help.
const HEADING: &str = "Animations";
#[derive(Clone, Debug, Args)]
pub(crate) struct FrameArgs {
    /// Render the frames A to B-1 of an --animation or an --orbit into files with numbers, such as a.0007.png. Frames
    /// that are complete are kept, and --shard I/N renders every N-th frame
    #[arg(long, value_name = "A..B", help_heading = HEADING, value_parser = frames, conflicts_with_all = ["sample_range", "print", "checkpoint", "plan"])]
    frames: Option<Range<u32>>,
    /// Frames per second of the animation
    #[arg(long, value_name = "N", help_heading = HEADING, default_value_t = 24.0, requires = "frames", value_parser = rate)]
    pub(super) fps: f64,
    /// Turn the camera by this angle about the point that it looks at, over all frames, to the right
    #[arg(long, value_name = "DEGREES", help_heading = HEADING, requires = "frames", allow_hyphen_values = true, value_parser = angle)]
    pub(super) orbit: Option<f64>,
}

fn frames(text: &str) -> Result<Range<u32>, String> {
    let ends = text.split_once("..").and_then(|(a, b)| Some(a.parse().ok()?..b.parse().ok()?));
    ends.filter(|frames| !frames.is_empty()).ok_or_else(|| {
        "must be two numbers, the first less than the second, such as 0..120".to_owned()
    })
}

fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|rate: &f64| *rate > 0.0 && rate.is_finite());
    rate.ok_or_else(|| "must be a number above 0".to_owned())
}

fn angle(text: &str) -> Result<f64, String> {
    let angle = text.parse().ok().filter(|angle: &f64| angle.is_finite());
    angle.ok_or_else(|| "must be a number".to_owned())
}

impl FrameArgs {
    /// The frames to render, if there are several.
    pub(super) fn frames(&self) -> Option<Range<u32>> {
        self.frames.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_and_rates_are_parsed() {
        assert_eq!(frames("3..5"), Ok(3..5));
        for wrong in ["", "3", "5..5", "5..3", "-1..3", "a..b"] {
            assert!(frames(wrong).is_err(), "{wrong}");
        }
        assert!(rate("0").is_err() && rate("inf").is_err() && rate("29.97").is_ok());
        assert!(angle("nan").is_err() && angle("-90").is_ok());
    }
}
