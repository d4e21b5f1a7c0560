//! The summary that `ptfast render` prints.

use super::goal::percent;
use super::record::{Run, StepSeconds};
use super::target::Target;
use crate::cli::console::say;
use crate::error::Result;
use crate::measure::settings;

/// Prints the summary of `run`, which wrote `output`.
pub(crate) fn print(run: &Run<'_>, output: &Target) -> Result<()> {
    let Run { scene, renderer, render, hash, denoised, seconds, noise, .. } = *run;
    let settings = settings::describe(renderer.image_settings());
    let engine = renderer.compute_settings().engine.name();
    let rays = &render.tally.rays;
    let million = |n: u64| n as f64 * 1e-6;
    let StepSeconds { load, build, plan, render: rendering, write, denoise } = seconds;
    let denoising = denoise.map_or(String::new(), |seconds| format!(" + denoise {seconds:.2}"));
    let total = load + build + plan + rendering + write + denoise.unwrap_or(0.0);
    say(format_args!("scene   {}, {settings}", scene.name()))?;
    say(format_args!(
        "time    {total:.2} s = load {load:.2} + build {build:.2} + plan {plan:.2} + render {rendering:.2}{denoising} + write {write:.2}, {engine} engine, {} threads",
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
    if let Some(noise) = noise {
        say(format_args!("noise   {}, estimated", percent(noise)))?;
    }
    if let Some(hash) = hash {
        say(format_args!("hash    {hash}"))?;
    }
    if let Some(denoised) = denoised {
        say(format_args!("denoised {denoised}"))?;
    }
    say(format_args!("version ptfast {}", env!("CARGO_PKG_VERSION")))?;
    say(format_args!("file    {}", output))
}
