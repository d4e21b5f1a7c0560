//! The identity of an image: the scene and settings that decide its bits.
//!
//! Checkpoints store it, and PNG and EXR images store it in their metadata.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use crate::engine::{BITS, ImageSettings};
use crate::film::Tile;
use crate::image::Metadata;
use crate::scene::Scene;

/// Scene and settings that decide an image. Renders of equal identity have equal bits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Identity {
    /// Version of the arithmetic, [`BITS`].
    pub bits: u32,
    /// Hash of the scene as seen by the camera.
    pub scene_hash: String,
    /// Rendered part of the image: left, upper, right and lower edge.
    pub crop: [u32; 4],
    /// The settings of the whole image, without a camera.
    pub settings: ImageSettings,
}

impl Identity {
    /// Identity of a render of `crop`, a part of the image.
    pub fn new(scene: &Scene, settings: &ImageSettings, crop: Tile) -> Self {
        let scene_hash = scene.hash_with(settings.camera(scene));
        Self { scene_hash, ..Self::without_scene(settings, crop) }
    }

    /// As [`new`](Self::new), with an empty hash of the scene.
    pub(crate) fn without_scene(settings: &ImageSettings, crop: Tile) -> Self {
        let Tile { x, y, width, height } = crop;
        Self {
            bits: BITS,
            scene_hash: String::new(),
            crop: [x, y, x + width, y + height],
            settings: ImageSettings { camera: None, ..settings.clone() },
        }
    }

    /// The rendered part of the image.
    pub fn area(&self) -> Tile {
        let [x, y, right, lower] = self.crop;
        Tile { x, y, width: right - x, height: lower - y }
    }

    /// Whether the whole image is rendered.
    pub fn is_whole(&self) -> bool {
        self.area() == self.settings.image()
    }

    /// The first field that differs, with its values in `self` and in `other`.
    pub fn difference(&self, other: &Self) -> Option<(String, Value, Value)> {
        let pairs = self.fields().zip(other.fields());
        let mut differ = pairs.filter(|((_, here), (_, there))| here != there);
        differ.next().map(|((name, here), (_, there))| (name, here, there))
    }

    fn fields(&self) -> impl Iterator<Item = (String, Value)> {
        let own = |name: &str, value| (name.to_owned(), value);
        let scene =
            [own("bits", json!(self.bits)), own("scene_hash", json!(self.scene_hash))].into_iter();
        scene.chain(self.settings.by_name()).chain([own("crop", json!(self.crop))])
    }

    /// Metadata of an image file whose pixels have this `hash`. Equal renders have equal metadata,
    /// even if their engines, numbers of threads or machines differ.
    pub fn metadata(&self, hash: &str) -> Metadata {
        let mut settings: Map<_, _> = self.settings.by_name().into_iter().collect();
        settings.insert("bits".to_owned(), json!(self.bits));
        if !self.is_whole() {
            settings.insert("crop".to_owned(), json!(self.crop));
        }
        Metadata::of_program()
            .with("ptfast:hash", hash)
            .with("ptfast:scene", &self.scene_hash)
            .with("ptfast:seed", self.settings.seed)
            .with("ptfast:settings", Value::Object(settings))
    }
}
