//! `ptfast rays`.

use std::path::PathBuf;

use clap::Args;

use super::arguments::camera::CameraArgs;
use super::arguments::limits::SceneLimitArgs;
use super::arguments::scene::SceneArg;
use super::console::say;
use super::folder;
use crate::accel::HitBatch;
use crate::engine::ImageSettings;
use crate::error::Result;
use crate::limits::{MAX_RAYS, MAX_SPP};
use crate::measure::{rayset, settings};
use crate::output::check_folder;

#[derive(Debug, Args)]
pub(crate) struct RaysArgs {
    #[command(flatten)]
    scene: SceneArg,
    #[command(flatten)]
    camera: CameraArgs,
    /// Folder for the ray set; created if missing
    #[arg(short, long, visible_alias = "out", value_name = "DIR")]
    output: PathBuf,
    /// Samples per pixel [default: enough for --max-rays primary rays]
    #[arg(long, alias = "samples", value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SPP)))]
    spp: Option<u32>,
    /// Maximum number of rays of each kind. If the render has more, whole runs of 2048 rays are
    /// kept, spread evenly over the render
    #[arg(long, value_name = "N", default_value_t = 1 << 21, value_parser = clap::value_parser!(u64).range(2048..=MAX_RAYS))]
    max_rays: u64,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    limits: SceneLimitArgs,
}

pub(crate) fn run(args: &RaysArgs) -> Result<()> {
    check_folder(&args.output)?;
    let is_set = rayset::is_set(&args.output);
    folder::check_unrelated(&rayset::files(&args.output), |_| is_set)?;
    let scene = args.limits.read(&args.scene)?.resolve()?;
    let camera = args.camera.camera(&scene)?;
    let mut settings =
        ImageSettings { camera: Some(camera), seed: args.seed, ..ImageSettings::of(&scene) };
    let pixels = u64::from(settings.width) * u64::from(settings.height);
    let enough = args.max_rays.div_ceil(pixels).min(u64::from(MAX_SPP));
    settings.spp = args.spp.unwrap_or(enough as u32);
    let sets = rayset::record(&scene, &settings, args.max_rays)?;
    rayset::write(&sets, &args.output)?;
    say(format_args!("scene   {}, {}", scene.name(), settings::describe(&settings)))?;
    for set in &sets.sets {
        let hits = set.hits.primitive.iter().filter(|p| **p != HitBatch::MISS).count();
        let share = 100.0 * hits as f64 / set.rays.len() as f64;
        say(format_args!("{:<7} {} rays, {share:.1}% hit", set.name, set.rays.len()))?;
    }
    say(format_args!("folder  {}", args.output.display()))
}
