//! What pages and the program tell each other.

use serde::{Deserialize, Serialize};

use crate::live::Move;

/// What a page asks for.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum Ask {
    /// It has shown a picture.
    Shown,
    /// Move the camera.
    Move(Move),
    /// Use the scene's camera of this name, or for an empty name the one that the program began with.
    Camera(String),
    /// Full vertical angle of view in degrees.
    Fov(f32),
    /// Apex angle of the cone from a point in focus to the lens in degrees, and distance of the plane in focus.
    Lens { angle: f32, distance: f32 },
    /// Put the surface at this place of the picture into focus, in shares of its width and height.
    Focus { x: f32, y: f32 },
    /// Width and height of the output in pixels.
    Size(u32, u32),
    /// Exposure in stops.
    Exposure(f32),
    /// Name of the tone map.
    Tonemap(String),
    /// Samples per pixel at which the hash is given.
    Spp(u32),
    /// Show the path of the first sample of the pixel at this place of the picture, in shares of its width and height.
    Path { x: f32, y: f32 },
    /// Show the layer of this name, or for an empty name the colour.
    Layer(String),
    /// Frames per second to aim at while the camera moves, by tracing fewer pixels.
    Rate(f64),
}

/// What comes with a picture, before its bytes.
#[derive(Debug, Default, Serialize)]
pub(super) struct About<'a> {
    /// Width and height of the picture, 0 if there is none.
    pub(super) width: u32,
    pub(super) height: u32,
    /// Width and height of the output.
    pub(super) size: (u32, u32),
    /// Samples per pixel, 0 in motion.
    pub(super) samples: u32,
    /// Share of the output's pixels that the frame traced.
    pub(super) traced: f64,
    pub(super) rays: u64,
    pub(super) seconds: f64,
    pub(super) hash: Option<&'a str>,
    /// The wanted number of samples.
    pub(super) spp: u32,
    /// The command that renders this picture.
    pub(super) command: &'a str,
    pub(super) fov: f32,
    pub(super) lens: (f32, f32),
    pub(super) cameras: Vec<&'a str>,
    pub(super) error: Option<&'a str>,
    pub(super) path: Option<&'a Traced>,
}

/// A path as the page draws it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct Traced {
    /// What `ptfast path` prints.
    pub(super) lines: Vec<String>,
    /// For each ray that is seen, whether it is a shadow ray, and both ends in shares of the picture's width and height.
    pub(super) rays: Vec<(bool, [f32; 4])>,
}

impl About<'_> {
    /// A message of this and the picture's `bytes`: the length of the text, the text and the bytes.
    pub(super) fn with(&self, bytes: &[u8]) -> Vec<u8> {
        let text = serde_json::to_vec(self).expect("all fields have a form in JSON");
        let length = (text.len() as u32).to_le_bytes();
        [&length, &text[..], bytes].concat()
    }
}
