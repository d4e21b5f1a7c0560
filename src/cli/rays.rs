//! `ptfast rays`.

use super::args::RaysArgs;
use super::say;
use crate::accel::HitBatch;
use crate::engine::RenderSettings;
use crate::error::Result;
use crate::limits::MAX_SPP;
use crate::output::check_folder;
use crate::rayset;

pub(super) fn run(args: &RaysArgs) -> Result<()> {
    check_folder(&args.out)?;
    let scene = args.limits.load(&args.scene)?;
    let mut settings = RenderSettings { seed: args.seed, ..RenderSettings::of(&scene) };
    let pixels = u64::from(settings.width) * u64::from(settings.height);
    let enough = args.max_rays.div_ceil(pixels).min(u64::from(MAX_SPP));
    settings.spp = args.spp.unwrap_or(enough as u32);
    let sets = rayset::record(&scene, &settings, args.max_rays)?;
    rayset::write(&sets, &args.out)?;
    say(format_args!(
        "scene   {}, {} x {}, {} spp, seed {}, sampling {}",
        scene.name(),
        settings.width,
        settings.height,
        settings.spp,
        settings.seed,
        settings.sampling.name()
    ))?;
    for set in &sets.sets {
        let hits = set.hits.primitive.iter().filter(|p| **p != HitBatch::MISS).count();
        let share = 100.0 * hits as f64 / set.rays.len() as f64;
        say(format_args!("{:<7} {} rays, {share:.1}% hit", set.name, set.rays.len()))?;
    }
    say(format_args!("folder  {}", args.out.display()))
}
