//! The arguments of `ptfast bench`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::arguments::{SceneLimitArgs, named};
use crate::engine::Engine;
use crate::limits::{MAX_SIDE, MAX_SPP, MAX_THREADS};
use crate::measure::statistics::Estimate;

#[derive(Debug, Args)]
pub(crate) struct BenchArgs {
    /// Built-in scene, cloud:N, mesh:N, forest:N or path; may be repeated [default: the built-in
    /// scenes, mesh:100000 and forest:10000]
    #[arg(long = "scene", value_name = "SCENE")]
    pub(crate) scenes: Vec<String>,
    /// Engine; may be repeated [default: all]
    #[arg(long = "engine", value_name = "ENGINE", value_parser = named(&Engine::ALL, Engine::name))]
    pub(crate) engines: Vec<Engine>,
    /// Worker threads; may be repeated [default: one, and one per available core]
    #[arg(short = 'j', long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_THREADS)))]
    pub(crate) threads: Vec<u32>,
    /// A quarter of the pixels and 6 blocks: takes about a minute
    #[arg(long)]
    pub(crate) quick: bool,
    /// Width in pixels; the height is in proportion [default: as many pixels as 640 x 360]
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SIDE)))]
    pub(crate) width: Option<u32>,
    /// Number of blocks; each renders everything twice, in opposite orders [default: 12]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(Estimate::LEAST as i64..=10_000))]
    pub(crate) blocks: Option<u32>,
    /// Samples per pixel
    #[arg(long, alias = "samples", value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SPP)))]
    pub(crate) spp: u32,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Write the record as JSON
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Compare with a record that --json wrote on this machine earlier
    #[arg(long, value_name = "FILE", conflicts_with = "against")]
    pub(crate) baseline: Option<PathBuf>,
    /// Compare with another ptfast binary, which runs alternately with this one
    #[arg(long, value_name = "PROGRAM")]
    pub(crate) against: Option<PathBuf>,
    /// Judge each row: improved, same, regressed or unclear. Rows that seem changed or were disturbed are measured
    /// again, up to three times. Exit with code 3 if a row regressed; unclear rows do not change the exit code
    #[arg(long)]
    pub(crate) gate: bool,
    /// Smallest change of speed that counts for --gate, in percent
    #[arg(long, value_name = "PERCENT", default_value_t = 1.0)]
    pub(crate) threshold: f64,
    /// Also write the record in another format: criterion, gha (github-action-benchmark), bmf (Bencher) or csv
    /// (Apache Otava); may be repeated
    #[arg(long, num_args = 2, value_names = ["FORMAT", "DIR"])]
    pub(crate) export: Vec<String>,
    /// Measure another ptfast binary instead of this one
    #[arg(long, value_name = "PROGRAM")]
    pub(crate) program: Option<PathBuf>,
    /// No progress and no notices
    #[arg(long, short)]
    pub(crate) quiet: bool,
    #[command(flatten)]
    pub(crate) limits: SceneLimitArgs,
}
