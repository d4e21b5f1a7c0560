//! Holes in the surfaces of materials, by an alpha texture.

use serde::{Deserialize, Serialize};

use super::{Number, TextureRef};
use crate::checks::Location;
use crate::error::Result;

/// Where a surface of triangles has holes. Light passes through them as if nothing were there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
#[non_exhaustive]
pub enum Opacity {
    /// A hole is where the opacity is below a threshold.
    Mask {
        /// The opacity, 0 to 1, or a texture.
        alpha: Number,
        /// The threshold, 0 to 1.
        #[serde(default = "half")]
        threshold: f32,
    },
    /// The opacity is the probability that a ray hits the surface.
    Blend {
        /// The opacity, 0 to 1, or a texture.
        alpha: Number,
    },
}

fn half() -> f32 {
    0.5
}

impl Opacity {
    pub(crate) fn alpha(&self) -> &Number {
        match self {
            Self::Mask { alpha, .. } | Self::Blend { alpha } => alpha,
        }
    }

    /// The reference to the texture, if there is one.
    pub(crate) fn reference(&mut self) -> Option<&mut TextureRef> {
        match self {
            Self::Mask { alpha, .. } | Self::Blend { alpha } => alpha.reference(),
        }
    }

    pub(crate) fn check(&self, e: &Location<'_>) -> Result<()> {
        self.alpha().check(e, "alpha", 0.0..=1.0)?;
        match *self {
            Self::Mask { threshold, .. } => {
                e.check((0.0..=1.0).contains(&threshold), "threshold", "in [0, 1]", threshold)
            }
            Self::Blend { .. } => Ok(()),
        }
    }
}
