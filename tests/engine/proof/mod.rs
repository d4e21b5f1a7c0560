//! Proof that pictures are right: scenes whose radiance is known, in every sampling mode, by both
//! engines; modes that must agree in every tile; pictures of another program.
//!
//! `cargo test --test engine proof -- --nocapture --test-threads 1` prints the tables. Another seed is
//! `PTFAST_PROOF_SEED`.
#![allow(clippy::disallowed_methods)] // the yardstick is libm's f64

mod exact;
mod furnace;
mod lamps;
mod media;
mod mitsuba;
mod tiles;

use ptfast::{Engine, RenderSettings, Renderer, Sampler, Scene};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// The chance of a false alarm of a test with all that it compares.
const ALARM: f64 = 1e-4;

/// Seeds apart from those of any other comparison.
fn first_seed(name: &str) -> u64 {
    let seed = std::env::var("PTFAST_PROOF_SEED").map_or(1, |seed| seed.parse().expect("a number"));
    name.bytes().fold(seed, |hash: u64, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3).rotate_left(29)
    })
}

/// The chance of a false alarm of one of `comparisons` (Šidák).
fn alarm(comparisons: usize) -> f64 {
    1.0 - (1.0 - ALARM).powf(1.0 / comparisons as f64)
}

/// How far a deviate goes by chance in one of `comparisons`, to either side.
fn farthest(comparisons: usize, of: &impl ContinuousCDF<f64, f64>) -> f64 {
    of.inverse_cdf(1.0 - 0.5 * alarm(comparisons))
}

/// A picture of one radiance, known in closed form.
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

/// Compares scenes with what is known, in each sampling mode, by both engines and both samplers. As many
/// samples are taken as it needs to find, with a probability of 95%, an error of half a percent: in each
/// scene by the first way, in all scenes together by the others.
fn compare(what: &str, known: &[Known]) {
    let n = known.len() as f64;
    let ways = [
        (Engine::Wavefront, Sampler::Sobol, 0.005),
        (Engine::Wavefront, Sampler::Independent, 0.005 * n.sqrt()),
        (Engine::Scalar, Sampler::Sobol, 0.005 * n.sqrt()),
    ];
    let modes = crate::common::SAMPLINGS.into_iter();
    let ways: Vec<_> = modes.flat_map(|mode| ways.map(|way| (mode, way))).collect();
    let student = StudentsT::new(0.0, 1.0, PICTURES as f64 - 1.0).expect("degrees above 0");
    // Each scene, and all together.
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
            let settings =
                RenderSettings { engine, sampler, ..crate::common::settings(scene, mode, 0, 0) };
            let precise = finds * want / (limit + 1.65);
            let (crate::common::Estimate { mean, error }, samples) =
                estimate(name, scene, &settings, precise);
            // Where all samples are equal there is rounding left.
            let t = (mean - want) / (error + 2e-5 * want);
            println!("{name:<44}{way}{want:>9.5}{mean:>9.5}{t:>8.2}  {samples} samples");
            if !(t.abs() <= limit) {
                wrong.push(format!("{name} {way}: {mean}, not {want}: t {t}"));
            }
            pooled += t / n.sqrt();
        }
        println!("{:<44}{way}{:>26.2}", "all together", pooled);
        // A mean of Student's t is nearer to normal than one: the limit of one is on the safe side.
        if !(pooled.abs() <= limit) {
            wrong.push(format!("all together {way}: {pooled}"));
        }
    }
    assert!(wrong.is_empty(), "chance goes to {limit:.2}: {wrong:#?}");
}

/// Independent pictures of an estimate.
const PICTURES: usize = 48;

/// The mean of the picture's green channel and its standard error, about `precise`, and the samples that
/// this took: as many as pictures of other seeds say are needed.
fn estimate(
    name: &str,
    scene: &Scene,
    base: &RenderSettings,
    precise: f64,
) -> (crate::common::Estimate, u64) {
    let seeds = format!("{name}{:?}{:?}{:?}", base.sampling, base.engine, base.sampler);
    let of = |spp: u32, what: &str| {
        let first = first_seed(&format!("{seeds} {what} {spp}"));
        let mean = |number: u64| {
            let seed = first.wrapping_add(number);
            let settings = RenderSettings { width: 8, height: 8, spp, seed, ..base.clone() };
            let render = Renderer::new(scene, settings).unwrap().render().unwrap();
            assert_eq!(render.tally.non_finite.count, 0, "{name}");
            render.image.mean()[1]
        };
        crate::common::Estimate::of(&(0..PICTURES as u64).map(mean).collect::<Vec<f64>>())
    };
    // Noise falls at least with the root of the samples.
    let more = |error: f64| (error / precise) * (error / precise) * 1.2;
    let mut spp = 32;
    let mut needs = more(of(spp, "pilot").error);
    while needs > 16.0 {
        assert!(spp < 1 << 16, "{name}: {spp} samples a pixel are too few");
        spp *= 8;
        needs = more(of(spp, "pilot").error);
    }
    spp = (f64::from(spp) * needs).max(32.0) as u32;
    (of(spp, "picture"), (PICTURES * 64) as u64 * u64::from(spp))
}
