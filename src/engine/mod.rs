//! Engines turn a scene into an image. Every engine returns the same bits.

mod dimension;
mod renderer;
mod scalar;
mod settings;

pub use renderer::{NonFinite, Observer, Progress, RayCounts, Render, Renderer, Seconds};
pub use settings::{Engine, RenderSettings};
