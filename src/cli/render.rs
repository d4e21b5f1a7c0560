//! `ptfast render`.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::args::{RenderArgs, SampleArgs, Switch};
use super::record::{self, StepSeconds, metadata};
use super::{advise_on_build, files, notice, path, plan, progress, say, timeline};
use crate::engine::{Engine, MOST_EVENTS, Render, RenderSettings, Renderer};
use crate::error::{Error, Result};
use crate::image::Format;
use crate::isa::Isa;
use crate::machine::Interference;
use crate::output::write_atomically;
use crate::scene::Scene;

pub(super) fn run(args: &RenderArgs) -> Result<()> {
    let start = Instant::now();
    // Whatever can fail fails before the work is done.
    args.output.as_deref().map(Format::of_path).transpose()?;
    let scene = Scene::load(&args.sample.scene)?;
    let load = start.elapsed().as_secs_f64();
    let output = args.output.clone().unwrap_or_else(|| default_output(&args.sample.scene));
    let settings = settings(args, &scene)?;
    settings.check()?;
    let more = [("the record", &args.json), ("the trace", &args.trace)];
    let mut written = vec![("the image", &*output)];
    written.extend(more.into_iter().filter_map(|(name, file)| Some((name, file.as_deref()?))));
    files::check(&[("the scene", Path::new(&args.sample.scene))], &written)?;
    let renderer = Renderer::new(&scene, settings.clone())?;
    if !args.quiet {
        advise_on_build(Isa::Avx2);
    }

    if let Some(plan) = renderer.plan().filter(|_| !args.quiet) {
        notice(format_args!("{}", plan::describe(plan)));
    }
    let before = Interference::so_far();
    let render = progress::render(&renderer, scene.name(), &settings, args.quiet)?;
    let interference = Interference::so_far().since(before);

    let hash = render.image.hash();
    let writing = Instant::now();
    render.image.write(&output, args.gamma, &metadata(&scene, &settings, &hash))?;
    let seconds = StepSeconds {
        load,
        build: render.seconds.build,
        plan: render.seconds.plan,
        render: render.seconds.render,
        write: writing.elapsed().as_secs_f64(),
    };
    if let Some(path) = &args.json {
        let record = record::render_record(
            &scene,
            &settings,
            &renderer,
            &render,
            &hash,
            seconds,
            interference,
        );
        write_atomically(path, |file| writeln!(file, "{record:#}"))?;
    }
    if let Some(path) = &args.trace {
        timeline::write(path, scene.name(), renderer.threads(), &render)?;
        if render.timeline.len() == MOST_EVENTS {
            notice(format_args!("{}: ends after {MOST_EVENTS} events", path.display()));
        }
    }
    if args.stats {
        super::stats::print(&render, renderer.plan())?;
    }
    summarize(&args.sample.scene, &scene, &settings, &renderer, &render, &hash, seconds, &output)
}

/// `spheres.png` for `spheres` and for `folder/spheres.ron`, in the current folder.
fn default_output(scene: &str) -> PathBuf {
    let stem = Path::new(scene).file_stem().unwrap_or_default().to_string_lossy();
    // `cloud:1000` is no name for a file everywhere.
    PathBuf::from(stem.replace(':', "-")).with_added_extension("png")
}

fn settings(args: &RenderArgs, scene: &Scene) -> Result<RenderSettings> {
    if args.plan.is_some() && args.engine == Engine::Scalar {
        return Err(Error::Usage("--plan is for the wavefront engine".to_owned()));
    }
    let plan = args.plan.as_deref().map(|file| plan::read(file, scene, args.quiet)).transpose()?;
    let of_samples = args.sample.settings(scene);
    Ok(RenderSettings {
        spp: args.spp.unwrap_or(of_samples.spp),
        clamp: args.clamp.unwrap_or(of_samples.clamp),
        engine: args.engine,
        threads: args.threads.unwrap_or(0),
        pin: args.pin,
        tile_size: args.tile_size.unwrap_or(0),
        wave_size: args.wave_size.unwrap_or(0),
        plan,
        count: args.stats,
        timeline: args.trace.is_some(),
        ..of_samples
    })
}

impl SampleArgs {
    /// The scene's settings where these say nothing.
    pub(super) fn settings(&self, scene: &Scene) -> RenderSettings {
        let defaults = RenderSettings::of(scene).with_size(self.width, self.height);
        RenderSettings {
            depth: self.depth.unwrap_or(defaults.depth),
            seed: self.seed,
            sampling: self.sampling.unwrap_or(defaults.sampling),
            sampler: self.sampler,
            roulette: self.roulette == Switch::On,
            ..defaults
        }
    }
}

#[expect(clippy::too_many_arguments, reason = "what a run consists of")]
fn summarize(
    given: &str,
    scene: &Scene,
    settings: &RenderSettings,
    renderer: &Renderer<'_>,
    render: &Render,
    hash: &str,
    seconds: StepSeconds,
    output: &Path,
) -> Result<()> {
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
    say(format_args!("hash    {hash}"))?;
    say(format_args!("version ptfast {}", env!("CARGO_PKG_VERSION")))?;
    say(format_args!("file    {}", output.display()))
}
