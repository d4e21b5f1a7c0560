//! `ptfast converge`.

use std::io::{IsTerminal, Write, stderr};
use std::path::PathBuf;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};

use super::arguments::camera::CameraArgs;
use super::arguments::limits::SceneLimitArgs;
use super::arguments::named::named;
use super::arguments::scene::SceneArg;
use super::console::{notice, say, say_lines};
use super::files;
use crate::engine::{ComputeSettings, ImageSettings, Pin};
use crate::error::{Error, Result};
use crate::limits::{MAX_SIDE, MAX_SPP, MAX_THREADS};
use crate::measure::converge::{Curve, Options, Slope, Way, at_seconds, measure, plot};
use crate::measure::machine::Machine;
use crate::output::write_atomically;
use crate::sampler::Sampler;
use crate::scene::{Sampling, Scene};

#[derive(Debug, Args)]
pub(crate) struct ConvergeArgs {
    #[command(flatten)]
    scene: SceneArg,
    #[command(flatten)]
    camera: CameraArgs,
    /// Sampling of light; may be repeated [default: all, or only bsdf if the scene has no lights]
    #[arg(long = "sampling", value_name = "SAMPLING", value_parser = named(&Sampling::ALL, Sampling::name))]
    samplings: Vec<Sampling>,
    /// Source of random numbers; may be repeated [default: all]
    #[arg(long = "sampler", value_name = "SAMPLER", value_parser = named(&Sampler::ALL, Sampler::name))]
    samplers: Vec<Sampler>,
    /// Samples per pixel of the longest renders; the others have 1, 2, 4, ... samples
    #[arg(long, alias = "samples", value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(2..=i64::from(MAX_SPP)))]
    spp: u32,
    /// Number of renders for each number of samples
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=1000))]
    rounds: u32,
    /// Samples per pixel of the reference, in two independent halves [default: 32 times --spp]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=i64::from(MAX_SPP)))]
    reference: Option<u32>,
    /// Width in pixels; the height is in proportion
    #[arg(long, value_name = "PIXELS", default_value_t = 320, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_SIDE)))]
    width: u32,
    /// Worker threads [default: one per available core]
    #[arg(short = 'j', long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_THREADS)))]
    threads: Option<u32>,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Render time in seconds at which errors are compared [default: the shortest time of the renders with --spp
    /// samples]
    #[arg(long, value_name = "SECONDS")]
    compare_at: Option<f64>,
    /// Write the measurements as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a plot as .svg
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
    /// No progress and no notices
    #[arg(short, long)]
    quiet: bool,
    #[command(flatten)]
    limits: SceneLimitArgs,
}

pub(crate) fn run(args: &ConvergeArgs) -> Result<()> {
    if args.compare_at.is_some_and(|seconds| !(seconds > 0.0 && seconds.is_finite())) {
        return Err(Error::Usage("--compare-at must be above 0 seconds".to_owned()));
    }
    if let Some(plot) =
        args.plot.as_ref().filter(|plot| plot.extension().is_none_or(|e| e != "svg"))
    {
        return Err(Error::Usage(format!(
            "{}: the name of a plot must end with .svg",
            plot.display()
        )));
    }
    let scene = args.limits.read(&args.scene)?.resolve()?;
    let options = options(args, &scene)?;
    let written = [("the record", &args.json), ("the plot", &args.plot)];
    let written: Vec<_> =
        written.into_iter().filter_map(|(name, file)| Some((name, file.as_deref()?))).collect();
    files::check(&files::of_scene(args.scene.name(), &scene), &written)?;

    let bar = (!args.quiet && stderr().is_terminal()).then(|| {
        let style = "{prefix} {wide_bar} {percent:>3}%  {eta}";
        let style = ProgressStyle::with_template(style).expect("the template is valid");
        ProgressBar::new(1).with_style(style).with_prefix(scene.name().to_owned())
    });
    let curves = measure(&scene, &options, &mut |done, all| {
        if let Some(bar) = &bar {
            bar.set_length(all);
            bar.set_position(done);
        }
    });
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
    let curves = curves?;

    let seconds = args.compare_at.unwrap_or_else(|| common_seconds(&curves));
    if let Some(path) = &args.json {
        let record = record(&scene, &options, &curves, seconds);
        write_atomically(path, |file| writeln!(file, "{record:#}"))?;
    }
    if let Some(path) = &args.plot {
        let ImageSettings { width, height, .. } = options.settings;
        let svg = plot(&format!("{}, {width} x {height} pixels", scene.name()), &curves)?;
        write_atomically(path, |file| file.write_all(svg.as_bytes()))?;
    }
    print(&scene, &options, &curves, seconds)
}

fn options(args: &ConvergeArgs, scene: &Scene) -> Result<Options> {
    let or = |given: &[Sampling], all: &[Sampling]| {
        if given.is_empty() { all.to_vec() } else { given.to_vec() }
    };
    // Paths cannot find all lights by scattering alone.
    let has: &[Sampling] = match scene.lights() {
        0 => &[Sampling::Bsdf],
        _ if scene.has_unseen_lights() => &[Sampling::Light, Sampling::Mis],
        _ => &Sampling::ALL,
    };
    let samplings = or(&args.samplings, has);
    let samplers = if args.samplers.is_empty() { &Sampler::ALL } else { &*args.samplers };
    let mut ways: Vec<Way> = Vec::new();
    for &sampling in &samplings {
        for &sampler in samplers {
            let way = Way { sampling, sampler };
            if !ways.contains(&way) {
                ways.push(way);
            }
        }
    }
    let camera = args.camera.camera(scene)?;
    let settings =
        ImageSettings { camera: Some(camera), seed: args.seed, ..ImageSettings::of(scene) };
    Ok(Options {
        settings: settings.with_size(Some(args.width), None),
        compute: ComputeSettings {
            threads: args.threads.unwrap_or(0),
            pin: Pin::Auto,
            ..ComputeSettings::default()
        },
        ways,
        most: args.spp,
        rounds: args.rounds,
        reference: args.reference.unwrap_or(args.spp.saturating_mul(32).min(MAX_SPP)).div_ceil(2),
    })
}

/// The longest time that all curves reach.
fn common_seconds(curves: &[Curve]) -> f64 {
    let ends = curves.iter().filter_map(|curve| Some(curve.points.last()?.seconds));
    ends.fold(f64::INFINITY, f64::min)
}

fn record(scene: &Scene, options: &Options, curves: &[Curve], seconds: f64) -> Value {
    let curve = |curve: &Curve| {
        let slope = Slope::of_samples(&curve.points);
        json!({
            "sampling": curve.way.sampling.name(),
            "sampler": curve.way.sampler.name(),
            "slope": slope.map(|slope| slope.slope),
            "slope_error": slope.map(|slope| slope.error),
            "slope_over_seconds": Slope::of_seconds(&curve.points).map(|slope| slope.slope),
            "mse_at_seconds": at_seconds(&curve.points, seconds),
            "points": curve.points,
        })
    };
    let mut record = json!({
        "schema": 1,
        "machine": Machine::this(),
        "scene": scene.name(),
        "scene_hash": scene.hash_with(options.settings.camera(scene)),
        "threads": options.compute.threads,
        "rounds": options.rounds,
        "reference_spp": 2 * u64::from(options.reference),
        "seconds": seconds,
        "curves": curves.iter().map(curve).collect::<Vec<_>>(),
    });
    // Each curve has its own values of the others.
    let common = options.settings.by_name().into_iter();
    let common = common.filter(|(name, _)| !["spp", "sampling", "sampler"].contains(&&**name));
    record.as_object_mut().expect("a record is an object").extend(common);
    record
}

fn print(scene: &Scene, options: &Options, curves: &[Curve], seconds: f64) -> Result<()> {
    let ImageSettings { width, height, .. } = options.settings;
    let Some(first) = curves.first() else { return Ok(()) };
    say(format_args!(
        "{}, {width} x {height} pixels, mean squared error of {} renders against a reference of {} samples per pixel",
        scene.name(),
        options.rounds,
        2 * options.reference
    ))?;
    say(format_args!(""))?;
    // Show every other number of samples, including the largest.
    let shown: Vec<usize> = (0..first.points.len()).rev().step_by(2).collect();
    let shown: Vec<usize> = shown.into_iter().rev().collect();
    let spp = |&i: &usize| format!("{:>11}", format!("{} spp", first.points[i].spp));
    let head: String = shown.iter().map(spp).collect();
    say(format_args!(
        "sampling sampler    {head}       slope  over time  seconds{:>11}         x",
        format!("in {} s", brief(seconds))
    ))?;
    let base = at_seconds(&first.points, seconds);
    let mut unknown = false;
    for Curve { way, points } in curves {
        let errors: String = shown.iter().map(|&i| format!("{:>11.2e}", points[i].mse)).collect();
        let over_samples = Slope::of_samples(points)
            .map(|Slope { slope, error }| format!("{slope:.2} ± {error:.2}"));
        let over_time = Slope::of_seconds(points).map(|slope| format!("{:.2}", slope.slope));
        let error = at_seconds(points, seconds);
        unknown |= error.is_none();
        let gain = base.zip(error).map(|(base, error)| times(base / error));
        say(format_args!(
            "{:<8} {:<12}{errors}{:>14}{:>9}{:>9.3}{:>11}{:>10}",
            way.sampling.name(),
            way.sampler.name(),
            or_none(over_samples),
            or_none(over_time),
            points.last().map_or(0.0, |point| point.seconds),
            or_none(error.map(|error| format!("{error:.2e}"))),
            or_none(gain)
        ))?;
    }
    if curves.iter().flat_map(|curve| &curve.points).any(|point| point.mse <= 0.0) {
        notice(format_args!(
            "some errors are below the noise of the reference: increase --reference"
        ));
    } else if unknown {
        notice(format_args!(
            "some renders have no error at {} s, which is outside the range of their times: increase --spp, or choose another --compare-at",
            brief(seconds)
        ));
    }
    say_lines(
        "\nslope: slope of the error over samples, with its standard error; over time: slope of the error over seconds\n\
         x: how many times smaller the error is than in the first line, at equal seconds",
    )
}

fn or_none(text: Option<String>) -> String {
    text.unwrap_or_else(|| "–".to_owned())
}

/// `x` with two decimals, or none from 100 on.
fn times(x: f64) -> String {
    let digits = if x < 100.0 { 2 } else { 0 };
    format!("{x:.digits$}")
}

/// Seconds with two or three decimals.
fn brief(seconds: f64) -> String {
    let digits = if seconds < 1.0 { 3 } else { 2 };
    format!("{seconds:.digits$}")
}
