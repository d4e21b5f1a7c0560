//! Textures of a constant colour.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{Rgba, TextureModel, TextureParameters, TexturePoint};
use crate::checks::Location;
use crate::error::Result;
use crate::math::{Real, Vector};
use crate::shading::Images;

/// A constant colour.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Solid {
    /// The colour in linear RGB, each channel in [0, 1].
    pub color: [f32; 3],
}

impl TextureParameters for Solid {
    fn load(&mut self, e: &Location<'_>, _: &mut Images<'_>) -> Result<()> {
        e.color("color", self.color, 1.0).map(|_| ())
    }

    /// Returns the colour, in the JSON form of a plain colour.
    fn identity(&self) -> Value {
        json!(self.color)
    }

    fn constant(&self) -> Option<[f32; 3]> {
        Some(self.color)
    }
}

impl TextureModel for Solid {
    type Entry = ();

    const CONSTANT: bool = true;

    fn entry(&self) {}

    /// Never called, because the material's row holds the colour.
    fn value<R: Real>(_: &[()], _: R::Word, _: &impl TexturePoint<R>) -> Rgba<R> {
        (R::Vec3::zero(), R::ZERO)
    }
}
