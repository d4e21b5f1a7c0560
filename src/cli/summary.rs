//! What `ptfast render` says of a render that is done.

use std::path::Path;

use super::record::Run;
use super::{notice, path, say};
use crate::engine::RenderSettings;
use crate::error::Result;

/// Of the scene that was `given`, whose image or film is `output`.
pub(super) fn summarize(run: &Run<'_>, given: &str, output: &Path) -> Result<()> {
    let Run { scene, settings, renderer, render, hash, seconds } = *run;
    let RenderSettings { width, height, spp, depth, seed, .. } = settings;
    let (sampling, sampler) = (settings.sampling.name(), settings.sampler.name());
    let engine = settings.engine.name();
    let roulette = if settings.roulette { "on" } else { "off" };
    let rays = &render.tally.rays;
    let million = |n: u64| n as f64 * 1e-6;
    let total = seconds.load + seconds.build + seconds.plan + seconds.render + seconds.write;
    if let Some((x, y, sample)) = render.tally.non_finite.first {
        notice(format_args!(
            "{} samples were not finite and count as black; the first again, ray by ray: {}",
            render.tally.non_finite.count,
            path::command(given, settings, (x, y), sample)
        ));
    }
    if settings.clamp < f32::INFINITY {
        notice(format_args!("{} samples were clamped to {}", render.tally.clamped, settings.clamp));
    }
    say(format_args!(
        "scene   {}, {width} x {height}, {spp} spp, depth {depth}, seed {seed}, sampling {sampling}, sampler {sampler}, roulette {roulette}",
        scene.name()
    ))?;
    say(format_args!(
        "time    {total:.2} s = load {:.2} + build {:.2} + plan {:.2} + render {:.2} + write {:.2}, {engine} engine, {} threads",
        seconds.load,
        seconds.build,
        seconds.plan,
        seconds.render,
        seconds.write,
        renderer.threads()
    ))?;
    say(format_args!(
        "rays    {:.2} M = {:.2} M primary + {:.2} M bounce + {:.2} M shadow",
        million(rays.total()),
        million(rays.primary),
        million(rays.bounce),
        million(rays.shadow)
    ))?;
    say(format_args!(
        "speed   {:.2} Mrays/s, {:.2} Msamples/s",
        million(rays.total()) / seconds.render,
        million(rays.primary) / seconds.render
    ))?;
    if let Some(hash) = hash {
        say(format_args!("hash    {hash}"))?;
    }
    say(format_args!("version ptfast {}", env!("CARGO_PKG_VERSION")))?;
    say(format_args!("file    {}", output.display()))
}
