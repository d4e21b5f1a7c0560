//! The light that surfaces emit.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// The sides of a surface that emit light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sides {
    /// Both sides.
    #[default]
    Both,
    /// Only the side that the normal points to.
    Front,
}

/// The light that a surface emits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// Radiance in linear RGB.
    pub radiance: Vec3,
    /// The sides that emit light.
    pub sides: Sides,
}

impl Emission {
    /// Whether the radiance is not black.
    pub(crate) fn emits(&self) -> bool {
        self.radiance != Vec3::ZERO
    }
}

/// The parts of red, green and blue in the relative luminance of a linear colour (Rec. 709).
pub(crate) const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Relative luminance of a linear colour.
pub(crate) fn luminance(color: Vec3) -> f64 {
    let [r, g, b] = color.as_dvec3().to_array();
    LUMINANCE[0] * r + LUMINANCE[1] * g + LUMINANCE[2] * b
}
