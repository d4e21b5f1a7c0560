//! The arguments, parsed by clap.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use super::bench_args::BenchArgs;
use super::converge::ConvergeArgs;
use super::dashboard::DashboardArgs;
use super::keep_args::KeepArgs;
use super::limits::LimitArgs;
use super::merge::MergeArgs;
use super::named::named;
use super::path::PathArgs;
use super::progress::Telling;
use super::sample_args::SampleArgs;
use super::share::ShareArgs;
use crate::accel::Kernel;
use crate::engine::{Engine, Pin};
use crate::image::Transfer;
use crate::limits::{MAX_RAYS, MAX_SPP, MAX_THREADS, MAX_WAVE};

/// A CPU path tracer: same seed, same bits.
#[derive(Debug, Parser)]
#[command(name = "ptfast", version, about, max_term_width = 100)]
pub(super) struct Cli {
    #[command(subcommand)]
    pub(super) command: Command,
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Render a scene to an image file
    Render(RenderArgs),
    /// Make one image of the parts of a render
    Merge(MergeArgs),
    /// List, show or check scenes
    Scenes(ScenesArgs),
    /// Render the report's six figures and a page that shows them
    Figures(FiguresArgs),
    /// Tell how two images differ
    Compare(CompareArgs),
    /// Write the rays that a render of a scene traces, with their hits
    Rays(RaysArgs),
    /// Trace one sample of one pixel with the reference engine, and tell its rays
    Path(PathArgs),
    /// Replay rays through each kernel, check every hit, and tell the speed
    Trace(TraceArgs),
    /// Tell how fast scenes are rendered, by each engine, and whether that has changed
    Bench(BenchArgs),
    /// Tell how the error of pictures falls with samples and seconds
    Converge(ConvergeArgs),
    /// Make a page of bench records: speed over commits, stages, lanes, counters
    Dashboard(DashboardArgs),
}

#[derive(Debug, Args)]
pub(super) struct RenderArgs {
    #[command(flatten)]
    pub(super) sample: SampleArgs,
    /// Samples a pixel [default: the scene's]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SPP)))]
    pub(super) spp: Option<u32>,
    /// Scale samples down whose largest component is above this: hides fireflies, loses energy [default:
    /// no clamping]
    #[arg(long, value_name = "RADIANCE")]
    pub(super) clamp: Option<f32>,
    /// Image file: .png, .exr, .hdr or .pfm, or .film, which can be continued and merged [default: the
    /// scene's name with .png, or .film for a part]
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Option<PathBuf>,
    /// Worker threads; the image does not depend on them [default: one for each core that may be used]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_THREADS)))]
    pub(super) threads: Option<u32>,
    /// Engine; the image does not depend on it
    #[arg(long, value_name = "ENGINE", default_value = Engine::Wavefront.name(), value_parser = named(&Engine::ALL, Engine::name))]
    pub(super) engine: Engine,
    /// Transfer curve of 8-bit files
    #[arg(long, value_name = "GAMMA", default_value = Transfer::Srgb.name(), value_parser = named(&Transfer::ALL, Transfer::name))]
    pub(super) gamma: Transfer,
    /// Paths that a worker traces at once; the image does not depend on it
    #[arg(long, value_name = "PATHS", hide = true, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_WAVE)))]
    pub(super) wave_size: Option<u32>,
    /// Whether threads stay on one core each; auto: where there is one for each core
    #[arg(long, value_name = "PIN", default_value = Pin::Auto.name(), value_parser = named(&Pin::ALL, Pin::name))]
    pub(super) pin: Pin,
    /// Work as a plan says, which --json wrote, instead of by its own
    #[arg(long, value_name = "FILE", conflicts_with = "wave_size")]
    pub(super) plan: Option<PathBuf>,
    #[command(flatten)]
    pub(super) share: ShareArgs,
    #[command(flatten)]
    pub(super) keep: KeepArgs,
    /// Do nothing where the file is there already, of the same scene, settings and seed
    #[arg(long)]
    pub(super) skip_complete: bool,
    /// How progress is told on standard error; json: an object a line
    #[arg(long, value_name = "HOW", default_value = Telling::Auto.name(), value_parser = named(&Telling::ALL, Telling::name))]
    pub(super) progress: Telling,
    /// Print exact counts of what was done, and the time of each stage
    #[arg(long)]
    pub(super) stats: bool,
    /// Write a record of the render as JSON
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
    /// Write what each worker did when, as JSON that Perfetto and Chrome open
    #[arg(long, value_name = "FILE")]
    pub(super) trace: Option<PathBuf>,
    /// No progress, and no notices but of samples that were replaced
    #[arg(long, short)]
    pub(super) quiet: bool,
}

#[derive(Debug, Args)]
pub(super) struct ScenesArgs {
    #[command(subcommand)]
    pub(super) command: Option<ScenesCommand>,
}

#[derive(Debug, Subcommand)]
pub(super) enum ScenesCommand {
    /// The built-in scenes [default]
    List,
    /// Print a scene as RON or JSON
    Show {
        /// Built-in scene, cloud:N, mesh:N or path
        #[arg(value_name = "NAME|FILE")]
        scene: String,
        /// Print JSON
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        limits: LimitArgs,
    },
    /// Check a scene file and count what is in it
    Check {
        /// Built-in scene, cloud:N, mesh:N or path
        #[arg(value_name = "NAME|FILE")]
        scene: String,
        #[command(flatten)]
        limits: LimitArgs,
    },
}

#[derive(Debug, Args)]
pub(super) struct FiguresArgs {
    /// Folder for the six pictures and index.html; made if missing
    #[arg(long, value_name = "DIR")]
    pub(super) out: PathBuf,
    /// A tenth of the report's samples
    #[arg(long)]
    pub(super) quick: bool,
    /// Worker threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_THREADS)))]
    pub(super) threads: Option<u32>,
    /// No progress and no notices
    #[arg(long, short)]
    pub(super) quiet: bool,
}

#[derive(Debug, Args)]
pub(super) struct CompareArgs {
    /// Image
    pub(super) a: PathBuf,
    /// Image it is compared with, the reference of relative measures
    pub(super) b: PathBuf,
    /// Compare display values: clamped to [0, 1], then through this curve [default: linear]
    #[arg(long, value_name = "GAMMA", value_parser = named(&Transfer::ALL, Transfer::name))]
    pub(super) display: Option<Transfer>,
    /// Write a false-colour image of the differences
    #[arg(long, value_name = "FILE")]
    pub(super) heatmap: Option<PathBuf>,
    #[command(flatten)]
    pub(super) limits: LimitArgs,
}

#[derive(Debug, Args)]
pub(super) struct RaysArgs {
    /// Built-in scene, cloud:N, mesh:N, or path of a .ron, .json or .txt file
    #[arg(long, value_name = "NAME|FILE")]
    pub(super) scene: String,
    /// Folder for the ray set; made if missing
    #[arg(long, value_name = "DIR")]
    pub(super) out: PathBuf,
    /// Samples a pixel [default: as many as give --max-rays primary rays]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SPP)))]
    pub(super) spp: Option<u32>,
    /// Largest number of rays of each kind, kept in runs of 2048 spread over the render
    #[arg(long, value_name = "N", default_value_t = 1 << 21, value_parser = clap::value_parser!(u64).range(2048..=MAX_RAYS))]
    pub(super) max_rays: u64,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(super) seed: u64,
    #[command(flatten)]
    pub(super) limits: LimitArgs,
}

#[derive(Debug, Args)]
pub(super) struct TraceArgs {
    /// Folder that `ptfast rays` wrote
    #[arg(value_name = "DIR")]
    pub(super) dir: PathBuf,
    /// One kernel [default: all that might be fastest, and scalar]
    #[arg(long, value_name = "KERNEL", value_parser = named(&Kernel::ALL, Kernel::name))]
    pub(super) kernel: Option<Kernel>,
    /// Repetitions, of which the median counts
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(super) reps: u32,
    /// Write the table as JSON
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
}
