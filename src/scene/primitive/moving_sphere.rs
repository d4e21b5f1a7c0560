//! Spheres that move linearly.

use serde::{Deserialize, Serialize};

use super::{Builder, Expand, radius};
use crate::checks::Location;
use crate::error::Result;
use crate::geometry::Sphere;

/// A sphere that moves linearly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MovingSphereFile {
    /// Centre at time 0.
    pub center: [f32; 3],
    /// Centre at time 1.
    pub center1: [f32; 3],
    /// Radius, above 0.
    pub radius: f32,
    /// Name of the material, a key of [`SceneFile::materials`](crate::SceneFile::materials).
    pub material: String,
}

impl Expand for MovingSphereFile {
    fn material(&self) -> Option<&str> {
        Some(&self.material)
    }

    fn expand(&self, e: &Location<'_>, to: &mut Builder<'_>) -> Result<()> {
        let center = e.point("center", self.center)?;
        let center1 = e.point("center1", self.center1)?;
        to.room(e, 1)?;
        to.geometry.spheres.push(Sphere { center, center1, radius: radius(e, self.radius)? });
        Ok(())
    }
}
