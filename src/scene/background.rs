//! The light that reaches a scene from outside.

use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::files::Images;
use super::light::Mapping;
use super::place::{Element, MAX_RADIANCE};
use crate::error::Result;
use crate::image::{Encoding, Texels};
use crate::math::{Real, Vector};

/// Radiance from outside the scene, in linear RGB with each channel in 0 to 1e30.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
#[non_exhaustive]
pub enum Background {
    /// The same in all directions.
    Constant {
        /// Linear RGB.
        radiance: [f32; 3],
    },
    /// A blend from `bottom`, seen straight down, to `top`, seen straight up. It is linear in the
    /// y-component of the unit direction.
    Gradient {
        /// Linear RGB in direction −y.
        bottom: [f32; 3],
        /// Linear RGB in direction +y.
        top: [f32; 3],
    },
    /// An image of all directions, which is also sampled as a light.
    Image(EnvironmentMap),
}

/// An image of the light from all directions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct EnvironmentMap {
    /// Path of the image, relative to the scene file.
    pub file: String,
    /// How the image shows all directions.
    #[serde(default, skip_serializing_if = "is_default")]
    pub mapping: Mapping,
    /// Rotations about the axes x, y and z in degrees, in this order, within ±1e6.
    #[serde(default, skip_serializing_if = "is_default")]
    pub rotation: [f32; 3],
    /// Factor of the image's values, 0 or more.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub scale: f32,
    /// Whether light samples leave directions darker than the mean to samples of materials, which
    /// then weigh more (Karlík et al. 2019, "MIS Compensation").
    #[serde(default, skip_serializing_if = "is_default")]
    pub compensated: bool,
    /// Whether the file may be outside the folder of the scene, because the user named it.
    #[serde(skip)]
    outside: bool,
    /// The image, once it is read.
    #[serde(skip)]
    texels: Option<Arc<Texels>>,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

fn one() -> f32 {
    1.0
}

fn is_one(scale: &f32) -> bool {
    *scale == 1.0
}

impl EnvironmentMap {
    /// Creates a latitude-longitude map from the image in `file`, which is read when the scene is
    /// resolved.
    pub fn from_file(file: impl Into<String>) -> Self {
        Self {
            file: file.into(),
            mapping: Mapping::default(),
            rotation: [0.0; 3],
            scale: 1.0,
            compensated: false,
            outside: false,
            texels: None,
        }
    }

    /// Creates a latitude-longitude map from the image at `path`, which may be in any folder and is
    /// relative to the current one.
    pub(super) fn from_path(path: &Path) -> Self {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        Self { outside: true, ..Self::from_file(path.to_string_lossy()) }
    }

    /// The image.
    ///
    /// # Panics
    /// If it is not loaded.
    pub(super) fn texels(&self) -> &Arc<Texels> {
        self.texels.as_ref().expect("`load` reads the image before it is used")
    }

    /// Replaces the image.
    #[cfg(test)]
    pub(super) fn set_texels(&mut self, texels: Texels) {
        self.texels = Some(Arc::new(texels));
    }

    fn load(&mut self, e: &Element<'_>, images: &mut Images<'_>) -> Result<()> {
        e.rotation(self.rotation)?;
        let scale = self.scale;
        e.check((0.0..=MAX_RADIANCE).contains(&scale), "scale", "in [0, 1e30]", scale)?;
        let texels = images.texels(e, &self.file, Encoding::Auto, self.outside)?;
        let ok = scale * texels.largest() <= MAX_RADIANCE;
        e.check(ok, "scale", "so small that all radiances are at most 1e30", scale)?;
        let square = texels.width() == texels.height();
        if self.mapping == Mapping::EqualArea && !square {
            let (width, height) = (texels.width(), texels.height());
            let message = format!(
                "{}: an equal-area map must be square, this one has {width} × {height} pixels",
                self.file
            );
            return Err(e.error(message));
        }
        self.texels = Some(texels);
        Ok(())
    }
}

impl Default for Background {
    /// Black.
    fn default() -> Self {
        Self::Constant { radiance: [0.0; 3] }
    }
}

impl Background {
    /// Checks the numbers and reads the image.
    pub(super) fn load(&mut self, e: &Element<'_>, images: &mut Images<'_>) -> Result<()> {
        match self {
            Self::Constant { radiance } => e.color("radiance", *radiance, MAX_RADIANCE)?,
            Self::Gradient { bottom, top } => {
                e.color("bottom", *bottom, MAX_RADIANCE)?;
                e.color("top", *top, MAX_RADIANCE)?
            }
            Self::Image(map) => return map.load(e, images),
        };
        Ok(())
    }

    /// Everything that determines the radiance, for the hash of the scene.
    pub(super) fn identity(&self) -> Value {
        match self {
            Self::Image(map) => {
                json!(Self::Image(EnvironmentMap { file: map.texels().hash(), ..map.clone() }))
            }
            _ => json!(self),
        }
    }

    /// Whether no light comes from outside.
    pub(super) fn is_black(&self) -> bool {
        match self {
            Self::Constant { radiance } => *radiance == [0.0; 3],
            Self::Gradient { bottom, top } => *bottom == [0.0; 3] && *top == [0.0; 3],
            Self::Image(map) => map.scale == 0.0 || !map.texels().shines(),
        }
    }

    /// Radiance seen along the unit vector that `direction` returns. A constant background never
    /// calls `direction`. An image is a light, and gives black here.
    #[inline(always)]
    pub(crate) fn radiance<V: Vector>(&self, direction: impl FnOnce() -> V) -> V {
        match self {
            Self::Constant { radiance } => V::splat(Vec3::from(*radiance)),
            Self::Gradient { bottom, top } => {
                let t = (direction()[1] + V::Real::ONE) * 0.5;
                let (bottom, top) = (V::splat(Vec3::from(*bottom)), V::splat(Vec3::from(*top)));
                bottom * (V::Real::ONE - t) + top * t
            }
            Self::Image(_) => V::zero(),
        }
    }
}
