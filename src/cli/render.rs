//! `ptfast render`.

use std::io::Write;
use std::path::Path;
use std::time::Instant;

use super::args::RenderArgs;
use super::place::Place;
use super::progress::{self, ProgressReport, Telling};
use super::record::{self, Run, StepSeconds};
use super::share::Share;
use super::summary::summarize;
use super::target::Target;
use super::{advise_on_build, files, for_programs, keep, notice, plan, say, timeline};
use crate::checkpoint::{Checkpoint, Identity};
use crate::engine::{Engine, MOST_EVENTS, RenderSettings, Renderer, Rendering};
use crate::error::{Error, Result};
use crate::film::Film;
use crate::interrupt;
use crate::isa::Isa;
use crate::limits::Limits;
use crate::machine::Interference;
use crate::output::{same_file, write_atomically};
use crate::scene::Scene;

pub(super) fn run(args: &RenderArgs) -> Result<()> {
    let start = Instant::now();
    for_programs(args.telling() == Telling::Json);
    interrupt::leave_at_once(true);
    interrupt::watch()?;
    // Whatever can fail fails before the work is done.
    args.output.clone().map(Target::of_path).transpose()?;
    let scene = args.sample.limits.load(&args.sample.scene)?;
    let load = start.elapsed().as_secs_f64();
    let settings = settings(args, &scene)?;
    settings.check()?;
    let share = args.share.share(&settings)?;
    settings.check_memory(&scene, Film::memory(share.area, share.samples.clone()))?;
    let identity = Identity::new(&scene, &settings, share.area);
    let output = Target::new(args.output.clone(), &args.sample.scene, &share, &identity)?;
    let beside = [&args.json, &args.trace].into_iter().flatten().all(|file| file.exists());
    if args.skip_complete
        && output.is_complete(&identity, &share, args.gamma, scene.limits())?
        && beside
    {
        say(format_args!("{} is complete", output.path().display()))?;
        if args.telling() == Telling::Json {
            progress::tell_complete(share.film(&identity)?.samples_to_do());
        }
        return Ok(());
    }
    let mut keeping = args.keep.keeping(output.path(), output.transfer(args.gamma), start)?;
    check_files(args, &scene, &output, None, None)?;
    // Where the render is kept depends on what is resumed.
    let mut place = args.keep.place(output.path());
    let (rendering, is_of_more) = begin(args, &place, &identity, &share, scene.limits())?;
    if is_of_more {
        args.keep.spare_resumed(&mut keeping, &mut place)?;
    }
    let partial = keeping.transfer.map(|_| place.image());
    check_files(args, &scene, &output, Some(place.file()), partial.as_deref())?;

    let mut checkpoint =
        Checkpoint { scene: scene.name().to_owned(), identity, shard: share.shard, rendering };
    let film = &checkpoint.rendering.film;
    let left = film.samples_to_do() - film.samples_done();
    let renderer = Renderer::for_paths(&scene, settings.clone(), left)?;
    let quiet = args.telling() != Telling::Auto;
    if !quiet {
        advise_on_build(Isa::Avx2);
    }
    if let Some(plan) = renderer.plan().filter(|_| !quiet) {
        notice(format_args!("{}", plan::describe(plan)));
    }
    let before = Interference::so_far();
    // From here on there is something to be kept.
    interrupt::leave_at_once(false);
    let progress =
        ProgressReport::new(&renderer, scene.name(), &checkpoint.rendering, args.telling());
    let not_kept = keep::render(&renderer, &mut checkpoint, &keeping, &mut place, &progress)?;
    let interference = Interference::so_far().since(before);

    let writing = Instant::now();
    let render = renderer.finish(&mut checkpoint.rendering)?;
    // A part has no image, and so no hash of one.
    let part = share.is_part(&checkpoint.identity);
    let hash = (!part).then(|| render.image.hash());
    let written = match &output {
        Target::Film(path) => checkpoint.write(path),
        Target::Image(path) => {
            let metadata = checkpoint.identity.metadata(hash.as_deref().unwrap_or_default());
            render.image.write(path, args.gamma, &metadata)
        }
    };
    written.map_err(|error| keep::instead(&checkpoint, &mut place, error))?;
    let seconds = StepSeconds {
        load,
        build: render.seconds.build,
        plan: render.seconds.plan,
        render: render.seconds.render,
        write: writing.elapsed().as_secs_f64(),
    };
    let (settings, hash) = (&settings, hash.as_deref());
    let run = Run { scene: &scene, settings, renderer: &renderer, render: &render, hash, seconds };
    if let Some(path) = &args.json {
        let record = record::render_record(&run, interference);
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
    summarize(&run, &args.sample.scene, output.path())?;
    if let Some(error) = not_kept {
        return Err(error);
    }
    progress.done(checkpoint.rendering.progress());
    Ok(())
}

/// Refuses files that cannot be written, and files that are the same.
fn check_files(
    args: &RenderArgs,
    scene: &Scene,
    output: &Target,
    checkpoint: Option<&Path>,
    partial: Option<&Path>,
) -> Result<()> {
    let mut read = files::of_scene(&args.sample.scene, scene);
    read.extend(args.plan.as_deref().map(|file| ("the plan", file)));
    let image = [("the image", Some(output.path())), ("the checkpoint", checkpoint)];
    let beside = [
        ("the partial image", partial),
        ("the record", args.json.as_deref()),
        ("the trace", args.trace.as_deref()),
    ];
    let given = |(name, file): (_, Option<_>)| Some((name, file?));
    let beside: Vec<_> = beside.into_iter().filter_map(given).collect();
    let image: Vec<_> = image.into_iter().filter_map(given).collect();
    files::check(&read, &[&*image, &beside].concat())?;
    // What is resumed may be replaced by what has more of it.
    let resumed = args.keep.resume.as_deref().map(|file| ("the checkpoint", file));
    files::check(resumed.as_slice(), &beside)
}

/// What there is of the render already, and whether it is for more samples than that was.
fn begin(
    args: &RenderArgs,
    place: &Place,
    identity: &Identity,
    share: &Share,
    limits: &Limits,
) -> Result<(Rendering, bool)> {
    let resumed = args.keep.resume.as_ref();
    let is_new = resumed.is_none_or(|file| !same_file(file, place.file()));
    // One film at a time is in memory.
    let there = if is_new { place.done(identity, share, limits)? } else { 0 };
    let (rendering, is_of_more) = match resumed {
        None => (share.film(identity).map(Rendering::new)?, false),
        Some(file) => {
            let (there, samples) = (Checkpoint::read(file, limits)?, share.samples.clone());
            let is_of_more = !there.is_of(identity, share.shard, &samples);
            let name = file.display().to_string();
            (there.resume(&name, identity, share.shard, samples)?, is_of_more)
        }
    };
    let film = &rendering.film;
    match there > film.samples_done() {
        true => Err(place.has_more(there * 100 / film.samples_to_do())),
        false => Ok((rendering, is_of_more)),
    }
}

fn settings(args: &RenderArgs, scene: &Scene) -> Result<RenderSettings> {
    if args.plan.is_some() && args.engine == Engine::Scalar {
        return Err(Error::Usage("--plan is for the wavefront engine".to_owned()));
    }
    let quiet = args.telling() != Telling::Auto;
    let plan = args.plan.as_deref().map(|file| plan::read(file, scene, quiet)).transpose()?;
    let of_samples = args.sample.settings(scene);
    Ok(RenderSettings {
        spp: args.spp.unwrap_or(of_samples.spp),
        clamp: args.clamp.unwrap_or(of_samples.clamp),
        engine: args.engine,
        threads: args.threads.unwrap_or(0),
        pin: args.pin,
        wave_size: args.wave_size.unwrap_or(0),
        plan,
        count: args.stats,
        timeline: args.trace.is_some(),
        ..of_samples
    })
}

impl RenderArgs {
    fn telling(&self) -> Telling {
        if self.quiet { Telling::None } else { self.progress }
    }
}
