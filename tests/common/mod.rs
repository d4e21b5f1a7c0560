//! Helpers of the integration tests.
#![allow(dead_code, unreachable_pub)] // each test file uses some of them

pub mod random_scene;

use std::path::Path;
use std::process::{Command, Output};

use ptfast::{Image, RenderSettings, Renderer, Sampling, Scene};

pub const SAMPLINGS: [Sampling; 3] = [Sampling::Bsdf, Sampling::Light, Sampling::Mis];

/// Runs the program in `folder`.
pub fn ptfast(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_ptfast"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the program starts")
}

pub fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("standard output is UTF-8")
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("standard error is UTF-8")
}

/// Renders `scene`.
pub fn render(scene: &Scene, settings: RenderSettings) -> Image {
    let render = Renderer::new(scene, settings).unwrap().render().unwrap();
    assert_eq!(render.tally.non_finite.count, 0, "{:?}", render.tally.non_finite);
    render.image
}

/// Small settings for `scene`: 1 × 1 pixels unless changed.
pub fn settings(scene: &Scene, sampling: Sampling, spp: u32, seed: u64) -> RenderSettings {
    RenderSettings { width: 1, height: 1, spp, seed, sampling, ..RenderSettings::of(scene) }
}

/// A mean over independent estimates and its standard error.
#[derive(Clone, Copy, Debug)]
pub struct Estimate {
    pub mean: f64,
    pub error: f64,
}

impl Estimate {
    pub fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0);
        Self { mean, error: (variance / n).sqrt() }
    }

    /// The mean must be `want` within 5 standard errors, and those within `precision` of it:
    /// a wrong program is found, a right one fails once in 1.7 million seeds.
    #[track_caller]
    pub fn assert_is(self, want: f64, precision: f64, what: &str) {
        let Self { mean, error } = self;
        assert!(5.0 * error <= precision * want, "{what}: {mean} ± {error} is not precise enough");
        // Where all samples are equal, rounding and the offset of spawned rays are left.
        let bound = 5.0 * error + 1e-4 * want;
        assert!((mean - want).abs() <= bound, "{what}: {mean} ± {error}, not {want}");
    }
}

/// Renders `scene` with 64 seeds; the estimate of the green mean.
pub fn estimate(scene: &Scene, base: &RenderSettings) -> Estimate {
    let means: Vec<f64> = (0..64)
        .map(|seed| render(scene, RenderSettings { seed, ..base.clone() }).mean()[1])
        .collect();
    Estimate::of(&means)
}
