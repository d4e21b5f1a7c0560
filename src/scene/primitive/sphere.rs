//! Spheres that do not move.

use serde::{Deserialize, Serialize};

use super::{Builder, Expand, radius};
use crate::checks::Location;
use crate::error::Result;
use crate::geometry::Sphere;

/// A sphere that does not move.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SphereFile {
    /// Centre.
    pub center: [f32; 3],
    /// Radius, above 0.
    pub radius: f32,
    /// Name of the material, a key of [`SceneFile::materials`](crate::SceneFile::materials).
    pub material: String,
}

impl Expand for SphereFile {
    fn material(&self) -> Option<&str> {
        Some(&self.material)
    }

    fn expand(&self, e: &Location<'_>, to: &mut Builder<'_>) -> Result<()> {
        let center = e.point("center", self.center)?;
        to.room(e, 1)?;
        to.geometry.spheres.push(Sphere::still(center, radius(e, self.radius)?));
        Ok(())
    }
}
