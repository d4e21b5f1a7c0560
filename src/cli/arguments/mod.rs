//! Arguments that several commands share.

pub(super) mod camera;
pub(super) mod denoise;
pub(super) mod display;
pub(super) mod limits;
pub(super) mod named;
pub(super) mod sample;
pub(super) mod scene;

pub(super) use camera::CameraArgs;
pub(super) use denoise::DenoiseArgs;
pub(super) use display::DisplayArgs;
pub(super) use limits::{LimitArgs, SceneLimitArgs};
pub(super) use named::named;
pub(super) use sample::SampleArgs;
pub(super) use scene::SceneArg;

/// Heading in the help.
pub(super) const IMAGE: &str = "Image";
