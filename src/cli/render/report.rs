//! What a render reports when it is complete.

use std::io::Write;

use super::RenderJob;
use super::goal::{Goal, percent};
use super::record::{self, Run};
use super::target::Target;
use super::{stats, summary, timeline};
use crate::cli::console::{notice, say};
use crate::cli::path;
use crate::engine::{MOST_EVENTS, Session};
use crate::error::Result;
use crate::image::Exposure;
use crate::measure::machine::Interference;
use crate::output::write_atomically;

/// Share of clipped pixels, among those that are not black, above which a notice says so.
const MOST_CLIPPED: f64 = 0.2;
/// Relative error that a denoiser could hardly make smaller.
const CLEAN: f64 = 0.03;
/// Number of samples below which most pictures are noisy.
const FEW: u32 = 256;

impl RenderJob<'_> {
    /// Says which goal the render has missed, and how far it came.
    pub(super) fn say_what_goal_missed(&self, run: &Run<'_>) {
        let Some(Goal { time, noise, most, .. }) = self.goal else { return };
        let samples = run.renderer.image_settings().spp;
        let took = self.start.elapsed();
        if let Some(time) = time.filter(|time| samples == 1 && took > *time) {
            notice(format_args!(
                "--time {} s: the scene needs longer, so the picture took {:.1} s and has one sample per pixel",
                time.as_secs_f64(),
                took.as_secs_f64()
            ));
        }
        let missed = |noise: f64| run.noise.is_none_or(|estimate| estimate > noise);
        if let Some(noise) = noise.filter(|noise| samples == most && missed(*noise)) {
            let estimate = run.noise.map_or("unknown".to_owned(), percent);
            notice(format_args!(
                "--noise {}: after {most} samples per pixel, the relative error is {estimate}; --max-spp allows more",
                percent(noise)
            ));
        }
    }

    /// Names `--denoise` after a render with a goal whose picture would be better with it.
    pub(super) fn say_what_would_help(&self, run: &Run<'_>, session: &Session) {
        let is_film = matches!(self.output, Target::Film(_));
        if self.goal.is_none() || self.args.denoise.denoise.is_some() || is_film {
            return;
        }
        match run.noise.or_else(|| session.noise().ok().flatten()) {
            Some(noise) if noise > CLEAN => notice(format_args!(
                "the relative error is about {}: --denoise would lower it",
                percent(noise)
            )),
            None if session.samples() < FEW => {
                notice(format_args!("with few samples, --denoise gives a better picture"));
            }
            _ => {}
        }
    }

    /// Writes the reports, and prints the summary.
    pub(super) fn report(&self, run: &Run<'_>, interference: Interference) -> Result<()> {
        let Run { scene, renderer, render, .. } = *run;
        let settings = &self.settings;
        let args = self.args;
        if let Some(path) = &args.json {
            let record = record::render_record(run, interference);
            write_atomically(path, |file| writeln!(file, "{record:#}"))?;
        }
        if let Some(path) = &args.trace {
            timeline::write(path, scene.name(), renderer.threads(), render)?;
            if render.timeline.len() == MOST_EVENTS {
                notice(format_args!("{}: ends after {MOST_EVENTS} events", path.display()));
            }
        }
        let (non_finite, clamped) = (&render.tally.non_finite, render.tally.clamped);
        if let Some((x, y, sample)) = non_finite.first {
            notice(format_args!(
                "{} samples were not finite and count as black; to trace the first again: {}",
                non_finite.count,
                path::command(&args.sample.scene, &args.sample.camera, settings, (x, y), sample)
            ));
        }
        if let Some(clamp) = settings.clamp {
            notice(format_args!("{clamped} samples were clamped to {clamp}"));
        }
        let exposure = self.display().exposure;
        if exposure == Exposure::Auto && self.output.has_8_bits() {
            let stops = exposure.stops(render.image.pixels());
            notice(format_args!("--exposure auto is --exposure {stops} for this picture"));
        }
        let clipped = render.image.clipped(&self.display());
        if clipped > MOST_CLIPPED && self.output.has_8_bits() {
            let percent = (100.0 * clipped).round();
            let units = match self.maybe_blender {
                true => {
                    ", and `--light-units blender` divides lamps by 683, by which Blender exports them too strong"
                }
                false => "",
            };
            notice(format_args!(
                "{percent}% of the pixels that are not black are too bright for {}: `--exposure auto` darkens it{units}",
                self.output
            ));
        }
        if self.output == Target::StandardOutput {
            return Ok(());
        }
        if args.print.as_deref() == Some("hashes") {
            let layers = render.image.layers().iter();
            let layers = layers.map(|l| (l.name(), render.image.layer_image(l).hash()));
            let Some(hash) = run.hash else { return Ok(()) };
            let denoised = run.denoised.map(|hash| ("denoised", hash.to_owned()));
            return std::iter::once(("color", hash.to_owned()))
                .chain(denoised)
                .chain(layers)
                .try_for_each(|(name, hash)| say(format_args!("{name} {hash}")));
        }
        if args.print.is_some() {
            return run.hash.map_or(Ok(()), |hash| say(format_args!("{hash}")));
        }
        if args.quiet {
            return Ok(());
        }
        if args.stats {
            stats::print(render, renderer.plan())?;
        }
        summary::print(run, &self.output)
    }
}
