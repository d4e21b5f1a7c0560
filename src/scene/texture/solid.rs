//! One colour.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{TextureModel, TexturePoint};
use crate::error::Result;
use crate::math::{Real, Vector};
use crate::scene::files::Images;
use crate::scene::place::Element;

/// One colour.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Solid {
    /// Linear RGB, each channel in [0, 1].
    pub color: [f32; 3],
}

impl TextureModel for Solid {
    type Entry = ();

    const CONSTANT: bool = true;

    fn load(&mut self, e: &Element<'_>, _: &mut Images<'_>) -> Result<()> {
        e.color("color", self.color, 1.0).map(|_| ())
    }

    /// The same as that of a colour without a texture.
    fn identity(&self) -> Value {
        json!(self.color)
    }

    fn constant(&self) -> Option<[f32; 3]> {
        Some(self.color)
    }

    fn entry(&self) {}

    /// Its colour is in the row of the material.
    fn color<R: Real>(_: &[()], _: R::Word, _: &impl TexturePoint<R>) -> R::Vec3 {
        R::Vec3::zero()
    }
}
