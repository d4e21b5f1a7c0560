//! Proof that pictures are right: scenes whose radiance is known, in every sampling mode, by both
//! engines; modes that must agree in every tile; pictures of another program.
//!
//! `cargo test --test proof -- --nocapture --test-threads 1` prints the tables. Another seed is
//! `PTFAST_PROOF_SEED`.
#![allow(clippy::disallowed_methods)] // the yardstick is libm's f64

#[path = "../common/mod.rs"]
mod common;

mod exact;
mod furnace;
mod lamps;
mod media;
mod mitsuba;
mod tiles;

use ptfast::{Engine, RenderSettings, Renderer, Sampling, Scene};
use statrs::distribution::{ContinuousCDF, Normal};

/// The chance of a false alarm of a test with all that it compares.
const ALARM: f64 = 1e-4;

/// Seeds apart from those of any other comparison.
fn first_seed(name: &str) -> u64 {
    let seed = std::env::var("PTFAST_PROOF_SEED").map_or(1, |seed| seed.parse().expect("a number"));
    name.bytes().fold(seed, |hash: u64, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3).rotate_left(29)
    })
}

/// How far a standard normal deviate goes by chance in one of `comparisons`.
fn alarm(comparisons: usize) -> f64 {
    let each = 1.0 - (1.0 - ALARM).powf(1.0 / comparisons as f64);
    Normal::standard().inverse_cdf(1.0 - 0.5 * each)
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

/// Compares scenes with what is known, in each sampling mode and engine. As many samples are taken as
/// it needs to find, with a probability of 95%, an error of half a percent in a scene; of the slow
/// engine three times as much, and half a percent in nine scenes together.
fn compare(what: &str, known: &[Known]) {
    let modes = common::SAMPLINGS.into_iter();
    let ways: Vec<_> = modes.flat_map(|mode| Engine::ALL.map(|engine| (mode, engine))).collect();
    // Each scene, and all together.
    let limit = alarm((known.len() + 1) * ways.len());
    println!("\n{what:<44}{:>7}{:>11}{:>9}{:>9}{:>8}", "mode", "engine", "want", "mean", "z");
    let mut wrong = Vec::new();
    for &(mode, engine) in &ways {
        let way = format!("{:>7}{:>11}", mode.name(), engine.name());
        let finds = if engine == Engine::Scalar { 0.015 } else { 0.005 };
        let mut pooled = 0.0;
        for Known { name, scene, want } in known {
            let precise = finds * want / (limit + 1.65);
            let (mean, error, samples) = estimate(name, scene, mode, engine, precise);
            // Where all samples are equal there is rounding left.
            let z = (mean - want) / (error + 2e-5 * want);
            println!("{name:<44}{way}{want:>9.5}{mean:>9.5}{z:>8.2}  {samples} samples");
            if z.abs() > limit {
                wrong.push(format!("{name} {way}: {mean}, not {want}: z {z}"));
            }
            pooled += z / (known.len() as f64).sqrt();
        }
        println!("{:<44}{way}{:>26.2}", "all together", pooled);
        if pooled.abs() > limit {
            wrong.push(format!("all together {way}: z {pooled}"));
        }
    }
    assert!(wrong.is_empty(), "chance goes to {limit:.2}: {wrong:#?}");
}

/// The mean of the picture's green channel, its standard error, at most `precise`, and the samples that
/// this took.
fn estimate(
    name: &str,
    scene: &Scene,
    mode: Sampling,
    engine: Engine,
    precise: f64,
) -> (f64, f64, u64) {
    let first = first_seed(&format!("{name}{mode:?}"));
    let mut spp = 64;
    loop {
        let settings = RenderSettings {
            width: 8,
            height: 8,
            spp,
            engine,
            ..common::settings(scene, mode, spp, 0)
        };
        let mean = |seed: u64| {
            let settings = RenderSettings { seed: first.wrapping_add(seed), ..settings.clone() };
            let render = Renderer::new(scene, settings).unwrap().render().unwrap();
            assert_eq!(render.tally.non_finite.count, 0, "{name}");
            render.image.mean()[1]
        };
        let means: Vec<f64> = (0..24).map(mean).collect();
        let common::Estimate { mean, error } = common::Estimate::of(&means);
        let samples = 24 * 64 * u64::from(spp);
        if error <= precise {
            return (mean, error, samples);
        }
        assert!(samples < 1 << 28, "{name} {mode:?}: {mean} ± {error} after {samples} samples");
        // Noise falls at least with the root of the samples.
        let more = (error / precise) * (error / precise) * 1.2;
        spp = (f64::from(spp) * more.clamp(1.5, 8.0)) as u32;
    }
}
