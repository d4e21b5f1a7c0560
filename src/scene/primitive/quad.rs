//! Parallelograms.

use serde::{Deserialize, Serialize};

use super::{Builder, Expand};
use crate::checks::Location;
use crate::error::Result;

/// The parallelogram q + a u + b v, with a and b in [0, 1]. Its front is the side of u × v.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct QuadFile {
    /// Corner of the parallelogram.
    pub q: [f32; 3],
    /// First edge from the corner.
    pub u: [f32; 3],
    /// Second edge from the corner.
    pub v: [f32; 3],
    /// Name of the material, a key of [`SceneFile::materials`](crate::SceneFile::materials).
    pub material: String,
}

impl Expand for QuadFile {
    fn material(&self) -> Option<&str> {
        Some(&self.material)
    }

    fn expand(&self, e: &Location<'_>, to: &mut Builder<'_>) -> Result<()> {
        to.room(e, 1)?;
        for (name, vector) in [("q", self.q), ("u", self.u), ("v", self.v)] {
            e.point(name, vector)?;
        }
        to.quad(e, [self.q, self.u, self.v])
    }
}
