//! The commands and their arguments, which clap parses.

use clap::{Parser, Subcommand};

use super::bench::args::BenchArgs;
use super::compare::CompareArgs;
use super::converge::ConvergeArgs;
use super::dashboard::DashboardArgs;
use super::denoise::DenoiseCommand;
use super::figures::FiguresArgs;
use super::merge::MergeArgs;
use super::path::PathArgs;
use super::rays::RaysArgs;
use super::render::args::RenderArgs;
use super::scenes::ScenesArgs;
use super::trace::TraceArgs;
use super::view::ViewArgs;

const EXAMPLES: &str = "\
Examples:
  ptfast render spheres                    render a built-in scene
  ptfast render my.ron --spp 64 -o my.exr  render a scene file
  ptfast render bunny.obj                  show a mesh
  ptfast scenes show cornell > my.ron      start a scene of your own
  ptfast bench --quick                     measure the speed";

#[derive(Debug, Parser)]
#[command(name = "ptfast", version, about, max_term_width = 100, after_help = EXAMPLES)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
    /// With --version: also print commit, instruction set and compiler
    #[arg(short, long)]
    verbose: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene to an image file
    Render(Box<RenderArgs>),
    /// Show a scene in real time, on a page in the browser
    View(Box<ViewArgs>),
    /// Join the parts of a render, or write the picture of its finished samples
    Merge(MergeArgs),
    /// Remove the noise of an image
    Denoise(DenoiseCommand),
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
