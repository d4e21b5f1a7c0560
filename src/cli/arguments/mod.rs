//! Arguments that several commands share.

pub(super) mod camera;
pub(super) mod display;
pub(super) mod limits;
pub(super) mod named;
pub(super) mod sample;
pub(super) mod scene;

/// Heading in the help.
pub(super) const IMAGE: &str = "Image";
