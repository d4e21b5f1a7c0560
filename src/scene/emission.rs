//! The light that surfaces emit.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// The sides of a surface that shine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sides {
    /// Both.
    #[default]
    Both,
    /// The side that the normal points to.
    Front,
}

/// What a surface emits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// Linear RGB.
    pub radiance: Vec3,
    /// The sides that shine.
    pub sides: Sides,
}

impl Emission {
    /// Whether the radiance is not black.
    pub(crate) fn shines(&self) -> bool {
        self.radiance != Vec3::ZERO
    }
}
