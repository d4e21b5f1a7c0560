//! Instances of named meshes.

use serde::{Deserialize, Serialize};

use super::{Builder, Expand};
use crate::checks::Location;
use crate::error::Result;

/// A named mesh, placed by an affine map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct InstanceFile {
    /// Name of the mesh, a key of [`SceneFile::meshes`](crate::SceneFile::meshes).
    pub mesh: String,
    /// The map from the mesh to the scene, in three rows. Each has three factors and, last, a
    /// coordinate of the translation. Mirroring and shear are possible. The matrix must not be
    /// singular or nearly so: the largest sum in a row of |A| |A⁻¹| may be up to 10 000.
    pub matrix: [[f32; 4]; 3],
    /// Name of the material of all triangles, a key of
    /// [`SceneFile::materials`](crate::SceneFile::materials). Without it, the parts of the mesh keep
    /// their own materials. The mesh is stored once for each material that instances give it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
}

impl InstanceFile {
    /// Places the mesh named `mesh` by `matrix`. Its parts keep their own materials.
    pub fn new(mesh: impl Into<String>, matrix: [[f32; 4]; 3]) -> Self {
        Self { mesh: mesh.into(), matrix, material: None }
    }
}

impl Expand for InstanceFile {
    fn material(&self) -> Option<&str> {
        self.material.as_deref()
    }

    fn expand(&self, e: &Location<'_>, to: &mut Builder<'_>) -> Result<()> {
        to.place(e, self)
    }
}
