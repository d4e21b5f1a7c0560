//! Settings that decide the image.

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::layers::{FirstHits, Layer, Layers};
use crate::error::{Error, Result};
use crate::film::Tile;
use crate::limits::{self, Limit, Limits};
use crate::sampler::Sampler;
use crate::scene::{Named, RenderDefaults, Roulette, Sampling, Scene};
use crate::shading::Camera;

/// What decides the bits of an image, besides its scene.
///
/// This is the only list of these settings: the identity of films, the metadata of images, records and the
/// dashboard contain all fields by their names. A field with a default is missing in older records, whose renders
/// used it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageSettings {
    /// The camera; `None` for that of the scene. Hashes of the scene include it.
    #[serde(skip)]
    pub camera: Option<Camera>,
    /// Image width in pixels, 1 to 65 536.
    pub width: u32,
    /// Image height in pixels, 1 to 65 536.
    pub height: u32,
    /// Samples per pixel, 1 to 16 777 216.
    pub spp: u32,
    /// Largest number of segments of a path, 1 to 65 536.
    pub depth: u32,
    /// Seed of all random numbers.
    pub seed: u64,
    /// How paths find light: by scattering, by sampling lights, or by both.
    pub sampling: Sampling,
    /// The source of random numbers.
    #[serde(default = "before_sobol")]
    pub sampler: Sampler,
    /// Which paths Russian roulette may end.
    #[serde(default = "before_roulette")]
    pub roulette: Roulette,
    /// Maximum component of a sample, above 0; `None` for no limit. Brighter samples are scaled down, which
    /// hides fireflies and loses energy.
    #[serde(default)]
    pub clamp: Option<f32>,
    /// Whether the camera sees black instead of the background.
    #[serde(default)]
    pub transparent: bool,
    /// The layers that the film has besides colour.
    #[serde(default)]
    pub layers: Layers,
    /// Which hit layers of the first hit hold.
    #[serde(default)]
    pub first_hit: FirstHits,
}

fn before_sobol() -> Sampler {
    Sampler::Independent
}

/// Before it was a setting, it applied from segment 5 on.
fn before_roulette() -> Roulette {
    Roulette::From(5)
}

impl ImageSettings {
    /// The camera and default settings of `scene`, with seed 1.
    pub fn of(scene: &Scene) -> Self {
        Self { sampling: scene.default_sampling(), ..Self::with_defaults(scene.defaults()) }
    }

    fn with_defaults(defaults: &RenderDefaults) -> Self {
        Self {
            camera: None,
            width: defaults.width,
            height: defaults.height,
            spp: defaults.spp,
            depth: defaults.depth,
            seed: 1,
            sampling: defaults.sampling.unwrap_or(Sampling::Mis),
            sampler: Sampler::default(),
            roulette: defaults.roulette,
            clamp: None,
            transparent: false,
            layers: Layers::default(),
            first_hit: FirstHits::default(),
        }
    }

    /// Sets the width and height. If only one is given, the other is scaled in proportion and
    /// rounded.
    #[must_use]
    pub fn with_size(self, width: Option<u32>, height: Option<u32>) -> Self {
        let scale = |side: u32, by: u32, of: u32| {
            let of = u64::from(of.max(1));
            let scaled = (u64::from(side) * u64::from(by) + of / 2) / of;
            u32::try_from(scaled.max(1)).unwrap_or(u32::MAX)
        };
        let (width, height) = match (width, height) {
            (Some(width), Some(height)) => (width, height),
            (Some(width), None) => (width, scale(width, self.height, self.width)),
            (None, Some(height)) => (scale(height, self.width, self.height), height),
            (None, None) => (self.width, self.height),
        };
        Self { width, height, ..self }
    }

    /// The camera: that of `scene`, unless the settings have another one.
    pub fn camera<'a>(&'a self, scene: &'a Scene) -> &'a Camera {
        self.camera.as_ref().unwrap_or(scene.camera())
    }

    /// Checks that all settings are in range, and that the image is within `limits`.
    ///
    /// # Errors
    /// If a setting is out of range, returns [`Error::Usage`], which names the first such setting.
    pub fn check(&self, limits: &Limits) -> Result<()> {
        self.check_ranges()
            .and_then(|()| limits.check(Limit::Pixels, self.image().pixels()))
            .map_err(Error::Usage)
    }

    /// Checks that all settings are in range. The error names the first that is not.
    pub(crate) fn check_ranges(&self) -> Result<(), String> {
        limits::check_image(self.width, self.height)?;
        limits::check("spp", self.spp, limits::MAX_SPP)?;
        limits::check("depth", self.depth, limits::MAX_DEPTH)?;
        self.roulette.check()?;
        match self.clamp {
            Some(clamp) if !(clamp > 0.0 && clamp.is_finite()) => {
                Err(format!("clamp must be above 0 and finite, is {clamp}"))
            }
            _ => Ok(()),
        }
    }

    /// Whether samples rendered with `self` and with `other` belong to the same image. The numbers
    /// of samples may differ.
    pub(super) fn same_image(&self, other: &Self) -> bool {
        Self { spp: other.spp, ..self.clone() } == *other
    }

    /// The names and values of all settings but the camera, in their order.
    pub(crate) fn by_name(&self) -> Vec<(String, Value)> {
        let text = serde_json::to_string(self).expect("settings are numbers and words");
        let Named(fields) = serde_json::from_str(&text).expect("settings are written as a map");
        fields
    }

    /// The names of all settings but the camera, in their order.
    pub(crate) fn names() -> impl Iterator<Item = String> {
        Self::with_defaults(&RenderDefaults::default()).by_name().into_iter().map(|(name, _)| name)
    }

    /// The tile of all pixels.
    #[doc(hidden)]
    pub fn image(&self) -> Tile {
        Tile { x: 0, y: 0, width: self.width, height: self.height }
    }

    /// Number of paths of the image.
    pub fn paths(&self) -> u64 {
        self.image().pixels() * u64::from(self.spp)
    }

    /// The layers that a film has besides colour.
    pub(crate) fn stored_layers(&self) -> Layers {
        let alpha = self.transparent.then_some(Layer::Alpha);
        Layers::new(self.layers.iter().chain(alpha)).stored()
    }

    /// Whether paths sample the lights of `scene`.
    pub(super) fn samples_lights(&self, scene: &Scene) -> bool {
        self.sampling != Sampling::Bsdf && scene.lights() > 0
    }
}
