//! Helpers that all engine tests share: small renders and their statistics.

use ptfast::{ComputeSettings, Image, ImageSettings, Renderer, Sampling, Scene};

pub(crate) const SAMPLINGS: [Sampling; 3] = [Sampling::Bsdf, Sampling::Light, Sampling::Mis];

/// Renders `scene` and checks that every sample is finite.
pub(crate) fn render(scene: &Scene, settings: ImageSettings) -> Image {
    render_by(scene, settings, ComputeSettings::default())
}

/// As [`render`], with settings of the computation.
pub(crate) fn render_by(
    scene: &Scene,
    settings: ImageSettings,
    compute: impl Into<ComputeSettings>,
) -> Image {
    let render = Renderer::new(scene, settings, compute).unwrap().render().unwrap();
    assert_eq!(render.tally.non_finite.count, 0, "{:?}", render.tally.non_finite);
    render.image
}

/// Settings for `scene` at 1 × 1 pixels.
pub(crate) fn settings(scene: &Scene, sampling: Sampling, spp: u32, seed: u64) -> ImageSettings {
    ImageSettings { width: 1, height: 1, spp, seed, sampling, ..ImageSettings::of(scene) }
}

/// The mean of independent estimates and its standard error.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimate {
    pub(crate) mean: f64,
    pub(crate) error: f64,
}

impl Estimate {
    pub(crate) fn of(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0);
        Self { mean, error: (variance / n).sqrt() }
    }
}
