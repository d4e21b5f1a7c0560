//! Statistical tests that images are right.
//!
//! Scenes of known radiance are rendered in every sampling mode by both engines, sampling modes are
//! compared tile by tile, and images are compared with another program's.
//!
//! `cargo test --test engine proof -- --nocapture --test-threads 1` prints the tables. The environment
//! variable `PTFAST_PROOF_SEED` sets another seed.
#![allow(clippy::disallowed_methods)] // expected values are computed in f64 with libm

mod absorption;
mod emission;
mod exact;
mod filters;
mod furnace;
mod instances;
mod lamps;
mod leaks;
mod media;
mod mitsuba;
mod normal_maps;
mod opacity;
mod panes;
mod sky;
mod smooth;
mod tiles;

use ptfast::{Engine, ImageSettings, Renderer, Sampler, Sampling, Scene};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// The probability of a false alarm of one test, over all its comparisons.
const ALARM: f64 = 1e-4;

/// The relative error that comparisons find. Half of the error takes four times the samples.
const FINDS: f64 = if cfg!(feature = "slow-tests") { 0.005 } else { 0.0075 };

/// The first seed of a comparison, far from the seeds of all other comparisons.
fn first_seed(name: &str) -> u64 {
    let seed = std::env::var("PTFAST_PROOF_SEED").map_or(1, |seed| seed.parse().expect("a number"));
    name.bytes().fold(seed, |hash: u64, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3).rotate_left(29)
    })
}

/// The probability of a false alarm for each of `comparisons`, by Šidák's correction.
fn alarm(comparisons: usize) -> f64 {
    1.0 - (1.0 - ALARM).powf(1.0 / comparisons as f64)
}

/// The two-sided limit on the deviate of each of `comparisons`.
fn farthest(comparisons: usize, of: &impl ContinuousCDF<f64, f64>) -> f64 {
    of.inverse_cdf(1.0 - 0.5 * alarm(comparisons))
}

/// A scene whose pixels all have the same expected radiance, which is known.
struct Known {
    name: String,
    scene: Scene,
    want: f64,
}

impl Known {
    fn new(name: &str, text: &str, want: f64) -> Self {
        let scene = Scene::from_ron(text).unwrap_or_else(|error| panic!("{name}: {error}"));
        Self { name: name.to_owned(), scene, want }
    }
}

/// Compares scenes with their known radiance, in each sampling mode, with both engines and both
/// samplers.
///
/// The number of samples is chosen so that the test detects an error of [`FINDS`] with a probability of 95%: in each scene
/// for the first combination of engine and sampler, and in all scenes together for the others.
fn compare(what: &str, known: &[Known]) {
    compare_in(&crate::common::SAMPLINGS, what, known);
}

/// As [`compare`], in these sampling modes.
fn compare_in(modes: &[Sampling], what: &str, known: &[Known]) {
    let n = known.len() as f64;
    let ways = [
        (Engine::Wavefront, Sampler::Sobol, FINDS),
        (Engine::Wavefront, Sampler::Independent, FINDS * n.sqrt()),
        (Engine::Scalar, Sampler::Sobol, FINDS * n.sqrt()),
    ];
    let ways: Vec<_> = modes.iter().flat_map(|&mode| ways.map(|way| (mode, way))).collect();
    let student = StudentsT::new(0.0, 1.0, PICTURES as f64 - 1.0).expect("degrees above 0");
    // Each scene is one comparison, and all scenes together are another.
    let limit = farthest((known.len() + 1) * ways.len(), &student);
    println!(
        "\n{what:<44}{:>7}{:>11}{:>13}{:>9}{:>9}{:>8}",
        "mode", "engine", "sampler", "want", "mean", "t"
    );
    let mut wrong = Vec::new();
    for &(mode, (engine, sampler, finds)) in &ways {
        let way = format!("{:>7}{:>11}{:>13}", mode.name(), engine.name(), sampler.name());
        let mut pooled = 0.0;
        for Known { name, scene, want } in known {
            let settings = ImageSettings { sampler, ..crate::common::settings(scene, mode, 0, 0) };
            let precise = finds * want / (limit + 1.65);
            let (crate::common::Estimate { mean, error }, samples) =
                estimate(name, scene, (&settings, engine), precise);
            // If all samples are equal, rounding errors remain.
            let t = (mean - want) / (error + 2e-5 * want);
            println!("{name:<44}{way}{want:>9.5}{mean:>9.5}{t:>8.2}  {samples} samples");
            if !(t.abs() <= limit) {
                wrong.push(format!("{name} {way}: {mean}, not {want}: t {t}"));
            }
            pooled += t / n.sqrt();
        }
        println!("{:<44}{way}{:>26.2}", "all together", pooled);
        // The scaled sum of several t values is closer to normal, so the limit for a single one is
        // conservative.
        if !(pooled.abs() <= limit) {
            wrong.push(format!("all together {way}: {pooled}"));
        }
    }
    assert!(
        wrong.is_empty(),
        "these deviate by more than chance allows (|t| up to {limit:.2}): {wrong:#?}"
    );
}

/// Number of independent pictures per estimate.
const PICTURES: usize = 48;

/// Estimates the mean of the green channel with a standard error of about `precise`. Also returns the
/// number of samples used, which a pilot run with other seeds determines.
fn estimate(
    name: &str,
    scene: &Scene,
    (base, engine): (&ImageSettings, Engine),
    precise: f64,
) -> (crate::common::Estimate, u64) {
    let seeds = format!("{name}{:?}{:?}{:?}", base.sampling, engine, base.sampler);
    let of = |spp: u32, what: &str| {
        let first = first_seed(&format!("{seeds} {what} {spp}"));
        let mean = |number: u64| {
            let seed = first.wrapping_add(number);
            let settings = ImageSettings { width: 8, height: 8, spp, seed, ..base.clone() };
            let render = Renderer::new(scene, settings, engine).unwrap().render().unwrap();
            assert_eq!(render.tally.non_finite.count, 0, "{name}");
            render.image.mean()[1]
        };
        crate::common::Estimate::of(&(0..PICTURES as u64).map(mean).collect::<Vec<f64>>())
    };
    // The standard error falls at least with the square root of the number of samples.
    let more = |error: f64| (error / precise) * (error / precise) * 1.2;
    let mut spp = 32;
    let mut needs = more(of(spp, "pilot").error);
    while needs > 16.0 {
        assert!(spp < 1 << 16, "{name}: {spp} samples per pixel are too few");
        spp *= 8;
        needs = more(of(spp, "pilot").error);
    }
    spp = (f64::from(spp) * needs).max(32.0) as u32;
    (of(spp, "picture"), (PICTURES * 64) as u64 * u64::from(spp))
}
