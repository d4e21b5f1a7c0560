//! The JSON record of a render.

use serde::Serialize;
use serde_json::{Value, json};

use crate::engine::{Planning, Render, Renderer, SegmentWork, Stage, StageWork};
use crate::measure::machine::{Interference, Machine, peak_rss_bytes};
use crate::scene::Scene;

/// Wall-clock seconds of the steps of a run.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct StepSeconds {
    pub(crate) load: f64,
    pub(crate) build: f64,
    pub(crate) plan: f64,
    pub(crate) render: f64,
    pub(crate) write: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) denoise: Option<f64>,
}

/// A finished run of `ptfast render`, for the record and the summary.
pub(crate) struct Run<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) renderer: &'a Renderer,
    pub(crate) render: &'a Render,
    pub(crate) scene_hash: &'a str,
    /// The mean of the noisy image.
    pub(crate) mean: [f64; 3],
    /// The hash of the noisy image; `None` for a part of an image.
    pub(crate) hash: Option<&'a str>,
    /// Of the denoised image.
    pub(crate) denoised: Option<&'a str>,
    pub(crate) seconds: StepSeconds,
    /// The estimated relative error of the picture, if the render ends by it.
    pub(crate) noise: Option<f64>,
}

/// The record of `render --json`. Field names are fixed; more fields may be added.
pub(crate) fn render_record(run: &Run<'_>, interference: Interference) -> Value {
    let Run { scene, renderer, render, scene_hash, mean, hash, denoised, seconds, noise } = *run;
    let settings = renderer.image_settings();
    let samples = render.tally.rays.primary as f64;
    let mut record = json!({
        "schema": 1,
        "machine": Machine::this(),
        "scene": scene.name(),
        "scene_hash": scene_hash,
        "engine": renderer.compute_settings().engine.name(),
        "threads": renderer.threads(),
        "hash": hash,
        "denoised_hash": denoised,
        "mean": mean,
        "seconds": seconds,
        "rays": render.tally.rays,
        "mrays_per_s": render.tally.rays.total() as f64 / render.seconds.render * 1e-6,
        "msamples_per_s": samples / render.seconds.render * 1e-6,
        "peak_rss_bytes": peak_rss_bytes(),
        "noise": noise,
        "non_finite": render.tally.non_finite.count,
        "non_finite_first": render.tally.non_finite.first,
        "clamped": render.tally.clamped,
        "interference": interference,
        "pinned": renderer.pinned().name(),
        "plan": renderer.plan(),
        "planning": renderer.planning().map(Planning::name),
        "endings": Value::from_iter(render.tally.endings.each()),
        "stages": Value::from_iter(
            Stage::ALL.map(|stage| (stage.name(), render.waves.stage(stage).seconds)),
        ),
        "segments": render.waves.segments.iter().map(segment).collect::<Value>(),
    });
    record.as_object_mut().expect("a record is an object").extend(settings.by_name());
    record
}

/// The work on one segment of the paths.
fn segment(segment: &SegmentWork) -> Value {
    let stage = |stage: Stage| {
        let StageWork { active, issued, seconds, counters } = segment.stage(stage);
        let mut work = json!({ "active": active, "issued": issued, "seconds": seconds });
        if counters.lanes_issued > 0 {
            work["counters"] = json!(counters);
        }
        (stage.name(), work)
    };
    let done = Stage::ALL.into_iter().filter(|&stage| segment.stage(stage).active > 0);
    json!({
        "endings": Value::from_iter(segment.endings.each()),
        "stages": done.map(stage).collect::<Value>(),
    })
}
