//! Lights of scene files that are not primitives.

use glam::Vec3;

use super::tree::LightBounds;
use super::{Entry, LightFile, LightTables};
use crate::checks::Location;
use crate::error::Result;
use crate::geometry::Bounds;

/// The description of a light that is not a primitive.
pub(super) trait FreeLightModel {
    /// Checks the parameters.
    fn check(&self, e: &Location<'_>) -> Result<()>;

    /// Returns the radiance. For lights without a surface, this is the number that gives the
    /// irradiance when it is divided by the density of samples.
    fn radiance(&self) -> Vec3;

    /// Returns the place and the power of the light, or `None` for light from outside the scene.
    /// Powers are luminances divided by π.
    fn inside(&self) -> Option<LightBounds>;

    /// Adds the light to the table of its kind.
    fn add_to(&self, tables: &mut LightTables) -> Entry;
}

impl LightFile {
    pub(crate) fn check(&self, e: &Location<'_>) -> Result<()> {
        self.model().check(e)
    }

    /// The place of the light, if it is inside the scene.
    pub(crate) fn place(&self) -> Option<Bounds> {
        self.model().inside().map(|light| light.bounds)
    }

    /// Whether the light is not black.
    pub(crate) fn emits(&self) -> bool {
        self.model().radiance() != Vec3::ZERO
    }
}
