//! Cameras as scene files describe them.

use serde::{Deserialize, Serialize};

use super::PixelFilter;

/// A thin-lens camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct CameraFile {
    /// Centre of the lens.
    pub look_from: [f32; 3],
    /// Point that appears in the middle of the image.
    pub look_at: [f32; 3],
    /// Direction that points up in the image.
    #[serde(default = "CameraFile::default_up")]
    pub up: [f32; 3],
    /// Full vertical angle of view, in (0, 180). Parallel projections need none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub vfov: f32,
    /// Height of the view of a parallel projection, above 0 and at most 1e9. Without it, the
    /// projection is a perspective.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parallel: Option<f32>,
    /// Whether left and right are exchanged.
    #[serde(default, skip_serializing_if = "is_false")]
    pub mirrored: bool,
    /// Apex angle of the cone from a point in focus to the lens, in [0, 180). 0 is a pinhole.
    #[serde(default)]
    pub defocus_angle: f32,
    /// Distance from the lens to the plane in focus.
    #[serde(default = "CameraFile::default_focus_distance")]
    pub focus_distance: f32,
    /// Times at which the shutter opens and closes, within [0, 1].
    #[serde(default)]
    pub shutter: (f32, f32),
    /// The filter of the pixels.
    #[serde(default, skip_serializing_if = "PixelFilter::is_box")]
    pub filter: PixelFilter,
}

fn is_zero(value: &f32) -> bool {
    *value == 0.0
}

fn is_false(value: &bool) -> bool {
    !value
}

impl CameraFile {
    /// Creates a pinhole camera at `look_from`, with the y-axis up and a full vertical angle of
    /// view of `vfov` degrees, in (0, 180).
    pub fn new(look_from: [f32; 3], look_at: [f32; 3], vfov: f32) -> Self {
        Self {
            look_from,
            look_at,
            up: Self::default_up(),
            vfov,
            parallel: None,
            mirrored: false,
            defocus_angle: 0.0,
            focus_distance: Self::default_focus_distance(),
            shutter: (0.0, 0.0),
            filter: PixelFilter::Box,
        }
    }

    fn default_up() -> [f32; 3] {
        [0.0, 1.0, 0.0]
    }

    fn default_focus_distance() -> f32 {
        10.0
    }
}
