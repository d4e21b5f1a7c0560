//! Lights of scene files that are not primitives.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::LightModel;
use super::distant::Distant;
use super::point::Point;
use super::spot::Spot;
use super::tree::LightBounds;
use crate::error::Result;
use crate::scene::place::Element;

/// A light that is not a primitive. Paths cannot hit it, so that only light samples find it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum LightFile {
    /// A point.
    Point(Point),
    /// A point that shines into a cone.
    Spot(Spot),
    /// Parallel light, such as that of the sun.
    Distant(Distant),
}

/// The description of a light that is not a primitive.
pub(super) trait FreeLightModel {
    /// Its entry in the table of its kind.
    type Light: LightModel;

    /// Checks the parameters.
    fn check(&self, e: &Element<'_>) -> Result<()>;

    /// Returns the entry and its radiance.
    fn light(&self) -> (Self::Light, FreeLight);
}

/// The radiance of a light, and its place.
pub(super) struct FreeLight {
    /// Radiance, or whatever is divided by the density of samples.
    pub(super) radiance: Vec3,
    /// Where the light is. Its power is the luminance, divided by π. `None` for light from outside
    /// the scene.
    pub(super) inside: Option<LightBounds>,
}

/// Adds `light` to the table of its kind, and returns its index there.
pub(super) fn push<K, F: FreeLightModel>(
    light: &F,
    kind: K,
    table: &mut Vec<F::Light>,
) -> (K, usize, FreeLight) {
    let (entry, free) = light.light();
    table.push(entry);
    (kind, table.len() - 1, free)
}

impl LightFile {
    /// The name of the light's kind in scene files.
    pub(in crate::scene) fn name(&self) -> &'static str {
        match self {
            Self::Point(_) => "point",
            Self::Spot(_) => "spot",
            Self::Distant(_) => "distant",
        }
    }

    pub(in crate::scene) fn check(&self, e: &Element<'_>) -> Result<()> {
        match self {
            Self::Point(light) => light.check(e),
            Self::Spot(light) => light.check(e),
            Self::Distant(light) => light.check(e),
        }
    }

    /// Whether the light is not black.
    pub(in crate::scene) fn shines(&self) -> bool {
        let (Self::Point(Point { intensity: light, .. })
        | Self::Spot(Spot { intensity: light, .. })
        | Self::Distant(Distant { irradiance: light, .. })) = self;
        *light != [0.0; 3]
    }
}

impl From<Point> for LightFile {
    fn from(light: Point) -> Self {
        Self::Point(light)
    }
}

impl From<Spot> for LightFile {
    fn from(light: Spot) -> Self {
        Self::Spot(light)
    }
}

impl From<Distant> for LightFile {
    fn from(light: Distant) -> Self {
        Self::Distant(light)
    }
}
