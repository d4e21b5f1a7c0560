//! Lights that are not primitives: how their descriptions become lights.

use glam::Vec3;

use super::LightModel;
use super::tree::LightBounds;
use crate::checks::Location;
use crate::error::Result;

/// The description of a light that is not a primitive.
pub(super) trait FreeLightModel {
    /// Its entry in the table of its kind.
    type Light: LightModel;

    /// Checks the parameters.
    fn check(&self, e: &Location<'_>) -> Result<()>;

    /// Returns the entry and its radiance.
    fn light(&self) -> (Self::Light, FreeLight);
}

/// The radiance of a light, and its place.
pub(super) struct FreeLight {
    /// Radiance. For lights without a surface, the number that gives the irradiance when it is divided by
    /// the density of samples.
    pub(super) radiance: Vec3,
    /// The place and the power of the light, or `None` for light from outside the scene. Powers are
    /// luminances divided by π.
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
