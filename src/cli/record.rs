//! The record of a render, as scripts read it, and the text kept in image files.

use serde::Serialize;
use serde_json::{Value, json};

use crate::engine::{Pinned, Render, RenderSettings, Renderer, Stage};
use crate::image::Metadata;
use crate::machine::{Machine, peak_rss_bytes};
use crate::scene::Scene;

/// Wall-clock seconds of the steps of a run.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct StepSeconds {
    pub(super) load: f64,
    pub(super) build: f64,
    pub(super) render: f64,
    pub(super) write: f64,
}

/// `render --json`: field names are fixed, more may be added.
pub(super) fn render_record(
    scene: &Scene,
    settings: &RenderSettings,
    renderer: &Renderer<'_>,
    render: &Render,
    hash: &str,
    seconds: StepSeconds,
) -> Value {
    let samples = render.tally.rays.primary as f64;
    json!({
        "schema": 1,
        "machine": Machine::this(),
        "scene": scene.name(),
        "scene_hash": scene.hash(),
        "engine": settings.engine.name(),
        "sampling": settings.sampling.name(),
        "sampler": "independent",
        "width": settings.width,
        "height": settings.height,
        "spp": settings.spp,
        "depth": settings.depth,
        "roulette": settings.roulette,
        "seed": settings.seed,
        "threads": render.threads,
        "hash": hash,
        "mean": render.image.mean(),
        "seconds": seconds,
        "rays": {
            "primary": render.tally.rays.primary,
            "bounce": render.tally.rays.bounce,
            "shadow": render.tally.rays.shadow,
        },
        "mrays_per_s": render.tally.rays.total() as f64 / render.seconds.render * 1e-6,
        "msamples_per_s": samples / render.seconds.render * 1e-6,
        "peak_rss_bytes": peak_rss_bytes(),
        "non_finite": render.tally.non_finite.count,
        "pinned": render.pinned == Pinned::Yes,
        "plan": renderer.plan(),
        "endings": Value::from_iter(render.tally.endings.each()),
        "stages": Value::from_iter(
            Stage::ALL.map(|stage| (stage.name(), render.waves.stage(stage).seconds)),
        ),
    })
}

/// What an image file says of itself: the same for equal renders, whatever engine, threads
/// or machine made them.
pub(super) fn metadata(scene: &Scene, settings: &RenderSettings, hash: &str) -> Metadata {
    let decides = json!({
        "width": settings.width,
        "height": settings.height,
        "spp": settings.spp,
        "depth": settings.depth,
        "sampling": settings.sampling.name(),
        "sampler": "independent",
        "roulette": settings.roulette,
    });
    Metadata::default()
        .with("Software", concat!("ptfast ", env!("CARGO_PKG_VERSION")))
        .with("ptfast:hash", hash)
        .with("ptfast:scene", scene.hash())
        .with("ptfast:seed", settings.seed)
        .with("ptfast:settings", decides)
}
