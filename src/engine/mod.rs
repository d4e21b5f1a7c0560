//! Engines turn a scene into an image. Every engine returns the same bits.

mod dimension;
mod recording;
mod renderer;
mod scalar;
mod settings;

pub use recording::{PathRecorder, RayKind, TracedRay};
pub use renderer::{NonFinite, Observer, Progress, RayCounts, Render, Renderer, Seconds};
pub use settings::{Engine, RenderSettings};
