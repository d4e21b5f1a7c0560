//! The arguments of `ptfast render`.

use std::path::PathBuf;

use clap::Args;

use super::checkpoint_args::CheckpointArgs;
use super::frame_args::FrameArgs;
use super::goal_args::GoalArgs;
use super::part_args::PartArgs;
use crate::accel::TreeQuality;
use crate::cli::arguments::{DenoiseArgs, DisplayArgs, IMAGE, SampleArgs, SceneLimitArgs, named};
use crate::cli::progress::ProgressMode;
use crate::engine::{Engine, FirstHits, Layers, Pin};
use crate::limits::{MAX_SPP, MAX_THREADS, MAX_WAVE};

const SPEED: &str = "Speed";
const REPORTS: &str = "Reports";

#[derive(Clone, Debug, Args)]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub(crate) sample: SampleArgs,
    /// Samples per pixel [default: the scene's]
    #[arg(long, alias = "samples", value_name = "N", help_heading = IMAGE, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SPP)))]
    pub(crate) spp: Option<u32>,
    #[command(flatten)]
    pub(crate) goal: GoalArgs,
    /// Scale down samples with a component above this value. Hides fireflies, but loses energy [default: no
    /// clamping]
    #[arg(long, value_name = "RADIANCE", help_heading = IMAGE)]
    pub(crate) clamp: Option<f32>,
    /// Hide the background behind the scene, and write an alpha channel. For .png and .exr
    #[arg(long, help_heading = IMAGE)]
    pub(crate) transparent: bool,
    /// Layers to write besides color, with commas between them: alpha, albedo, normal, depth, position, uv, direct,
    /// indirect, emission, background, instance, material, samples, halves. An .exr has all of them, beside other
    /// formats each layer is a .pfm
    #[arg(long, value_name = "LIST", help_heading = IMAGE, default_value = "color", hide_default_value = true)]
    pub(crate) layers: Layers,
    /// The hit that layers hold: that of the camera ray, or the first behind smooth mirrors and clear glass
    #[arg(long, value_name = "HIT", help_heading = IMAGE, default_value = FirstHits::Surface.name(), value_parser = named(&FirstHits::ALL, FirstHits::name))]
    pub(crate) first_hit: FirstHits,
    #[command(flatten)]
    pub(crate) denoise: DenoiseArgs,
    /// Output file: an image (.png, .exr, .hdr, .pfm), a .film that can be continued and merged, or - for a PNG on
    /// standard output [default: SCENE.png, or .film for a part]
    #[arg(short, long, visible_alias = "out", value_name = "FILE", help_heading = IMAGE)]
    pub(crate) output: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) display: DisplayArgs,
    /// Do nothing if the output file is complete and has the same scene, settings and seed
    #[arg(long, help_heading = IMAGE)]
    pub(crate) skip_complete: bool,
    #[command(flatten)]
    pub(crate) frame: FrameArgs,
    #[command(flatten)]
    pub(crate) part: PartArgs,
    #[command(flatten)]
    pub(crate) checkpoint: CheckpointArgs,
    /// Worker threads. The image does not depend on them [default: one per available core]
    #[arg(short = 'j', long, value_name = "N", help_heading = SPEED, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_THREADS)))]
    pub(crate) threads: Option<u32>,
    /// Engine. The image does not depend on it
    #[arg(long, value_name = "ENGINE", help_heading = SPEED, default_value = Engine::Wavefront.name(), value_parser = named(&Engine::ALL, Engine::name))]
    pub(crate) engine: Engine,
    /// Paths that a worker traces at once. The image does not depend on it
    #[arg(long, value_name = "PATHS", hide = true, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_WAVE)))]
    pub(crate) wave_size: Option<u32>,
    /// Whether to pin each thread to a core; auto: if there is a core for each thread
    #[arg(long, value_name = "PIN", help_heading = SPEED, default_value = Pin::Auto.name(), value_parser = named(&Pin::ALL, Pin::name))]
    pub(crate) pin: Pin,
    /// Whether trees are built fast, or best for the speed of rays [default: whichever is ready first]
    #[arg(long, value_name = "QUALITY", help_heading = SPEED, value_parser = named(&TreeQuality::ALL, TreeQuality::name))]
    pub(crate) tree: Option<TreeQuality>,
    /// Use the plan of an earlier render, from a file that --json wrote
    #[arg(long, value_name = "FILE", help_heading = SPEED, conflicts_with = "wave_size")]
    pub(crate) plan: Option<PathBuf>,
    /// How to show progress on standard error; json: one object per line
    #[arg(long, value_name = "HOW", help_heading = REPORTS, default_value = ProgressMode::Auto.name(), value_parser = named(&ProgressMode::ALL, ProgressMode::name))]
    pub(crate) progress: ProgressMode,
    /// Print only this to standard output: the image's BLAKE3 hash, or a line with name and hash for colour and each
    /// layer [default: a summary]
    #[arg(long, value_name = "WHAT", help_heading = REPORTS, value_parser = ["hash", "hashes"])]
    pub(crate) print: Option<String>,
    /// Also print the plan, exact counts, and the time of each stage
    #[arg(long, help_heading = REPORTS)]
    pub(crate) stats: bool,
    /// Write a record of the render as JSON
    #[arg(long, value_name = "FILE", help_heading = REPORTS)]
    pub(crate) json: Option<PathBuf>,
    /// Write a timeline of each worker, as JSON for Perfetto and Chrome
    #[arg(long, value_name = "FILE", help_heading = REPORTS)]
    pub(crate) trace: Option<PathBuf>,
    /// Print errors only, and what --print asks for
    #[arg(long, short, help_heading = REPORTS)]
    pub(crate) quiet: bool,
    #[command(flatten)]
    pub(crate) limits: SceneLimitArgs,
}
