//! The commands and their arguments, which clap parses.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use super::bench_args::BenchArgs;
use super::checkpoint_args::CheckpointArgs;
use super::compare::CompareArgs;
use super::converge::ConvergeArgs;
use super::dashboard::DashboardArgs;
use super::display_args::DisplayArgs;
use super::figures::FiguresArgs;
use super::limits::SceneLimitArgs;
use super::merge::MergeArgs;
use super::named::named;
use super::path::PathArgs;
use super::progress::ProgressMode;
use super::rays::RaysArgs;
use super::sample_args::{IMAGE, SampleArgs, SceneArg};
use super::share::ShareArgs;
use super::trace::TraceArgs;
use crate::engine::{Engine, Pin};
use crate::limits::{MAX_SPP, MAX_THREADS, MAX_WAVE};

const EXAMPLES: &str = "\
Examples:
  ptfast render spheres                    render a built-in scene
  ptfast render my.ron --spp 64 -o my.exr  render a scene file
  ptfast render bunny.obj                  show a mesh
  ptfast scenes show cornell > my.ron      start a scene of your own
  ptfast bench --quick                     measure the speed";

#[derive(Debug, Parser)]
#[command(name = "ptfast", version, about, max_term_width = 100, after_help = EXAMPLES)]
pub(super) struct Cli {
    #[command(subcommand)]
    pub(super) command: Command,
    /// With --version: also print commit, instruction set and compiler
    #[arg(short, long)]
    verbose: bool,
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Render a scene to an image file
    Render(Box<RenderArgs>),
    /// Join the parts of a render, or write the picture of its finished samples
    Merge(MergeArgs),
    /// List, show or check scenes
    Scenes(ScenesArgs),
    /// Render the six figures of the report that ptfast follows, with a page that shows them
    Figures(FiguresArgs),
    /// Measure how two images differ
    Compare(CompareArgs),
    /// Record the rays of a render and their hits, for `trace` and other programs
    Rays(RaysArgs),
    /// Trace one sample of one pixel and print each ray
    Path(PathArgs),
    /// Replay recorded rays through each kernel, check every hit, and measure the speed
    Trace(TraceArgs),
    /// Measure the speed of renders, and compare it with a baseline or another build
    Bench(BenchArgs),
    /// Measure how the error falls with samples and seconds
    Converge(ConvergeArgs),
    /// Write a page that shows the speed over many bench records
    Dashboard(DashboardArgs),
}

const SPEED: &str = "Speed";
const REPORTS: &str = "Reports";

#[derive(Debug, Args)]
pub(super) struct RenderArgs {
    #[command(flatten)]
    pub(super) sample: SampleArgs,
    /// Samples per pixel [default: the scene's]
    #[arg(long, alias = "samples", value_name = "N", help_heading = IMAGE, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SPP)))]
    pub(super) spp: Option<u32>,
    /// Scale down samples with a component above this value. Hides fireflies, but loses energy [default: no
    /// clamping]
    #[arg(long, value_name = "RADIANCE", help_heading = IMAGE)]
    pub(super) clamp: Option<f32>,
    /// Hide the background behind the scene, and write an alpha channel. For .png and .exr
    #[arg(long, help_heading = IMAGE)]
    pub(super) transparent: bool,
    /// Output file: an image (.png, .exr, .hdr, .pfm), a .film that can be continued and merged, or - for a PNG on
    /// standard output [default: SCENE.png, or .film for a part]
    #[arg(short, long, visible_alias = "out", value_name = "FILE", help_heading = IMAGE)]
    pub(super) output: Option<PathBuf>,
    #[command(flatten)]
    pub(super) display: DisplayArgs,
    /// Do nothing if the output file is complete and has the same scene, settings and seed
    #[arg(long, help_heading = IMAGE)]
    pub(super) skip_complete: bool,
    #[command(flatten)]
    pub(super) share: ShareArgs,
    #[command(flatten)]
    pub(super) checkpoint: CheckpointArgs,
    /// Worker threads. The image does not depend on them [default: one per available core]
    #[arg(short = 'j', long, value_name = "N", help_heading = SPEED, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_THREADS)))]
    pub(super) threads: Option<u32>,
    /// Engine. The image does not depend on it
    #[arg(long, value_name = "ENGINE", help_heading = SPEED, default_value = Engine::Wavefront.name(), value_parser = named(&Engine::ALL, Engine::name))]
    pub(super) engine: Engine,
    /// Paths that a worker traces at once. The image does not depend on it
    #[arg(long, value_name = "PATHS", hide = true, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_WAVE)))]
    pub(super) wave_size: Option<u32>,
    /// Whether to pin each thread to a core; auto: if there is a core for each thread
    #[arg(long, value_name = "PIN", help_heading = SPEED, default_value = Pin::Auto.name(), value_parser = named(&Pin::ALL, Pin::name))]
    pub(super) pin: Pin,
    /// Use the plan of an earlier render, from a file that --json wrote
    #[arg(long, value_name = "FILE", help_heading = SPEED, conflicts_with = "wave_size")]
    pub(super) plan: Option<PathBuf>,
    /// How to show progress on standard error; json: one object per line
    #[arg(long, value_name = "HOW", help_heading = REPORTS, default_value = ProgressMode::Auto.name(), value_parser = named(&ProgressMode::ALL, ProgressMode::name))]
    pub(super) progress: ProgressMode,
    /// Print only this to standard output: the image's BLAKE3 hash [default: a summary]
    #[arg(long, value_name = "WHAT", help_heading = REPORTS, value_parser = ["hash"])]
    pub(super) print: Option<String>,
    /// Also print the plan, exact counts, and the time of each stage
    #[arg(long, help_heading = REPORTS)]
    pub(super) stats: bool,
    /// Write a record of the render as JSON
    #[arg(long, value_name = "FILE", help_heading = REPORTS)]
    pub(super) json: Option<PathBuf>,
    /// Write a timeline of each worker, as JSON for Perfetto and Chrome
    #[arg(long, value_name = "FILE", help_heading = REPORTS)]
    pub(super) trace: Option<PathBuf>,
    /// Print errors only, and what --print asks for
    #[arg(long, short, help_heading = REPORTS)]
    pub(super) quiet: bool,
    #[command(flatten)]
    pub(super) limits: SceneLimitArgs,
}

#[derive(Debug, Args)]
pub(super) struct ScenesArgs {
    #[command(subcommand)]
    pub(super) command: Option<ScenesCommand>,
}

#[derive(Debug, Subcommand)]
pub(super) enum ScenesCommand {
    /// List the built-in scenes [default]
    List,
    /// Print a scene as RON or JSON
    Show {
        #[command(flatten)]
        scene: SceneArg,
        /// Print JSON instead of RON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        limits: SceneLimitArgs,
    },
    /// Check a scene, count its elements, and warn if its picture would be black
    Check {
        #[command(flatten)]
        scene: SceneArg,
        #[command(flatten)]
        limits: SceneLimitArgs,
    },
}
