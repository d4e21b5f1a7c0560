//! Lights of scene files that are not primitives.

use serde::{Deserialize, Serialize};

use super::distant::Distant;
use super::free::FreeLightModel;
use super::point::Point;
use super::spot::Spot;
use crate::checks::Location;
use crate::error::Result;

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

impl LightFile {
    /// The name of the light's kind in scene files.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::Point(_) => "point",
            Self::Spot(_) => "spot",
            Self::Distant(_) => "distant",
        }
    }

    pub(crate) fn check(&self, e: &Location<'_>) -> Result<()> {
        match self {
            Self::Point(light) => light.check(e),
            Self::Spot(light) => light.check(e),
            Self::Distant(light) => light.check(e),
        }
    }

    /// Whether the light is not black.
    pub(crate) fn emits(&self) -> bool {
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
