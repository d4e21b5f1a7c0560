//! The identity of an image: the scene and settings that decide its bits.
//!
//! Checkpoints store it, and PNG and EXR images store it in their metadata.

use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Value, json};

use crate::engine::{BITS, Backdrop, RenderSettings};
use crate::film::Tile;
use crate::image::Metadata;
use crate::scene::Scene;

/// Scene and settings that decide an image. Renders of equal identity have equal bits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Identity {
    /// Version of the arithmetic, [`BITS`].
    pub bits: u32,
    /// Hash of the scene.
    pub scene_hash: String,
    /// Width of the whole image.
    pub width: u32,
    /// Height of the whole image.
    pub height: u32,
    /// Rendered part of the image: left, upper, right and lower edge.
    pub crop: [u32; 4],
    /// Samples per pixel.
    pub spp: u32,
    /// Maximum number of segments of a path.
    pub depth: u32,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Name of the sampling strategy for light.
    pub sampling: String,
    /// Name of the sampler, which provides the random numbers.
    pub sampler: String,
    /// First segment that a path reaches only if it survives Russian roulette; `None` for no roulette.
    #[serde(deserialize_with = "roulette")]
    pub roulette: Option<u32>,
    /// Limit for the components of a sample; `None` for no limit.
    pub clamp: Option<f32>,
    /// What the camera sees behind the scene. Checkpoints of earlier versions lack it.
    #[serde(default)]
    pub backdrop: Backdrop,
}

/// Reads the first segment of Russian roulette. Checkpoints of earlier versions have `true` for segment
/// 5 and `false` for no roulette.
fn roulette<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<u32>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged, expecting = "roulette must be a number or null")]
    enum Roulette {
        Switch(bool),
        First(Option<u32>),
    }
    Ok(match Roulette::deserialize(deserializer)? {
        Roulette::Switch(on) => on.then_some(5),
        Roulette::First(first) => first,
    })
}

impl Identity {
    /// Identity of a render of `crop`, a part of the image.
    pub fn new(scene: &Scene, settings: &RenderSettings, crop: Tile) -> Self {
        let Tile { x, y, width, height } = crop;
        Self {
            bits: BITS,
            scene_hash: scene.hash_with(&settings.camera),
            width: settings.width,
            height: settings.height,
            crop: [x, y, x + width, y + height],
            spp: settings.spp,
            depth: settings.depth,
            seed: settings.seed,
            sampling: settings.sampling.name().to_owned(),
            sampler: settings.sampler.name().to_owned(),
            roulette: settings.roulette,
            // JSON has no infinity.
            clamp: Some(settings.clamp).filter(|clamp| clamp.is_finite()),
            backdrop: settings.backdrop,
        }
    }

    /// The rendered part of the image.
    pub fn area(&self) -> Tile {
        let [x, y, right, lower] = self.crop;
        Tile { x, y, width: right - x, height: lower - y }
    }

    /// The first field that differs, with its values in `self` and in `other`.
    pub fn difference(&self, other: &Self) -> Option<(&'static str, Value, Value)> {
        let pairs = self.fields().into_iter().zip(other.fields());
        let mut differ = pairs.filter(|((_, here), (_, there))| here != there);
        differ.next().map(|((name, here), (_, there))| (name, here, there))
    }

    fn fields(&self) -> [(&'static str, Value); 13] {
        [
            ("bits", json!(self.bits)),
            ("scene_hash", json!(self.scene_hash)),
            ("width", json!(self.width)),
            ("height", json!(self.height)),
            ("crop", json!(self.crop)),
            ("spp", json!(self.spp)),
            ("depth", json!(self.depth)),
            ("seed", json!(self.seed)),
            ("sampling", json!(self.sampling)),
            ("sampler", json!(self.sampler)),
            ("roulette", json!(self.roulette)),
            ("clamp", json!(self.clamp)),
            ("backdrop", json!(self.backdrop)),
        ]
    }

    /// Metadata of an image file whose pixels have this `hash`. Equal renders have equal metadata,
    /// even if their engines, numbers of threads or machines differ.
    pub fn metadata(&self, hash: &str) -> Metadata {
        let mut settings = json!({
            "bits": self.bits,
            "width": self.width,
            "height": self.height,
            "spp": self.spp,
            "depth": self.depth,
            "sampling": self.sampling,
            "sampler": self.sampler,
            "roulette": self.roulette,
        });
        if let Some(clamp) = self.clamp {
            settings["clamp"] = json!(clamp);
        }
        if self.backdrop != Backdrop::default() {
            settings["backdrop"] = json!(self.backdrop);
        }
        if self.crop != [0, 0, self.width, self.height] {
            settings["crop"] = json!(self.crop);
        }
        Metadata::of_program()
            .with("ptfast:hash", hash)
            .with("ptfast:scene", &self.scene_hash)
            .with("ptfast:seed", self.seed)
            .with("ptfast:settings", settings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roulette_of_all_versions() {
        #[derive(Deserialize)]
        struct Header {
            #[serde(deserialize_with = "roulette")]
            roulette: Option<u32>,
        }
        let read = |value: &str| {
            serde_json::from_str(&format!(r#"{{"roulette": {value}}}"#))
                .map(|header: Header| header.roulette)
                .map_err(|error| error.to_string())
        };
        for (value, first) in [("true", Some(5)), ("false", None), ("null", None), ("7", Some(7))] {
            assert_eq!(read(value), Ok(first), "{value}");
        }
        let error = read("-1").unwrap_err();
        assert!(error.starts_with("roulette must be a number or null"), "{error}");
    }
}
