//! The light that reaches a scene from outside.

use glam::Vec3;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::Images;
use super::light::EnvironmentMap;
use crate::checks::{Location, MAX_RADIANCE};
use crate::error::Result;
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

impl Default for Background {
    /// Black.
    fn default() -> Self {
        Self::Constant { radiance: [0.0; 3] }
    }
}

impl Background {
    /// Checks the numbers and reads the image.
    pub(crate) fn load(&mut self, e: &Location<'_>, images: &mut Images<'_>) -> Result<()> {
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
    pub(crate) fn identity(&self) -> Value {
        match self {
            Self::Image(map) => json!(Self::Image(map.identity())),
            _ => json!(self),
        }
    }

    /// Whether no light comes from outside.
    pub(crate) fn is_black(&self) -> bool {
        match self {
            Self::Constant { radiance } => *radiance == [0.0; 3],
            Self::Gradient { bottom, top } => *bottom == [0.0; 3] && *top == [0.0; 3],
            Self::Image(map) => map.is_black(),
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
