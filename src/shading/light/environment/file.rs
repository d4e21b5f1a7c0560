//! Environment maps as scene files describe them.

use std::path::Path;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

use super::mapping::Mapping;
use crate::checks::{Location, MAX_RADIANCE};
use crate::error::Result;
use crate::image::{Encoding, Texels};
use crate::math::precise::{rotate, sin_cos_degrees, unit};
use crate::shading::{ImageFile, Images};

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
    /// An orthogonal matrix in three rows, which may mirror the map. It is applied after the rotations.
    #[serde(default, skip_serializing_if = "is_default")]
    pub matrix: Option<[[f32; 3]; 3]>,
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

/// Bytes of memory per texel while the tables for sampling are made.
const TABLE_BYTES: u64 = 12;

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
            matrix: None,
            scale: 1.0,
            compensated: false,
            outside: false,
            texels: None,
        }
    }

    /// Creates a latitude-longitude map from the image at `path`, which may be in any folder and is
    /// relative to the current one.
    pub(crate) fn from_path(path: &Path) -> Self {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        Self { outside: true, ..Self::from_file(path.to_string_lossy()) }
    }

    /// The matrix.
    fn columns(&self) -> DMat3 {
        let rows = self.matrix.map(|rows| rows.map(|row| DVec3::from(row.map(f64::from))));
        rows.map_or(DMat3::IDENTITY, |[x, y, z]| DMat3::from_cols(x, y, z).transpose())
    }

    /// The directions of the map's axes x, y and z: orthogonal, and unit vectors.
    pub(super) fn axes(&self) -> [DVec3; 3] {
        let turns = self.rotation.map(|degrees| sin_cos_degrees(degrees.into()));
        let columns = self.columns();
        let turned = |axis: DVec3| columns * DVec3::from(rotate(axis.into(), turns));
        if self.matrix.is_none() {
            return DVec3::AXES.map(|axis| rotate(axis.into(), turns).into());
        }
        // A matrix of a file is orthogonal only up to its digits (Gram-Schmidt).
        let [x, y, z] = DVec3::AXES.map(turned);
        let x = unit(x);
        let y = unit(y - x * x.dot(y));
        let right = x.cross(y);
        [x, y, if right.dot(z) < 0.0 { -right } else { right }]
    }

    /// The image.
    ///
    /// # Panics
    /// If it is not loaded.
    pub(crate) fn texels(&self) -> &Arc<Texels> {
        self.texels.as_ref().expect("`load` reads the image before it is used")
    }

    /// Replaces the image.
    #[cfg(test)]
    pub(super) fn set_texels(&mut self, texels: Texels) {
        self.texels = Some(Arc::new(texels));
    }

    pub(crate) fn load(&mut self, e: &Location<'_>, images: &mut Images<'_>) -> Result<()> {
        e.rotation(self.rotation)?;
        let columns = self.columns();
        let product = columns.transpose() * columns;
        let ok = product.abs_diff_eq(DMat3::IDENTITY, 1e-4);
        e.check(ok, "matrix", "orthogonal", self.matrix)?;
        let scale = self.scale;
        e.check((0.0..=MAX_RADIANCE).contains(&scale), "scale", "in [0, 1e30]", scale)?;
        let image = ImageFile { file: &self.file, index: None, encoding: Encoding::Auto };
        let texels = images.texels(e, image, self.outside)?;
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
        // The grid of patches has a row and a column more than the image.
        let [width, height] = [texels.width(), texels.height()].map(|side| u64::from(side) + 1);
        images.hold(e, TABLE_BYTES * (width * height))?;
        self.texels = Some(texels);
        Ok(())
    }

    /// The map with its content instead of its file, for the hash of the scene.
    pub(crate) fn identity(&self) -> Self {
        Self { file: self.texels().hash(), ..self.clone() }
    }

    /// Whether no light comes from the map.
    pub(crate) fn is_black(&self) -> bool {
        self.scale == 0.0 || !self.texels().emits()
    }
}
