//! Lists of triangles.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::{Builder, Expand};
use crate::error::Result;
use crate::geometry::Triangle;
use crate::scene::place::Element;

/// A list of triangles. The front is the side from which the vertices run counter-clockwise.
///
/// Triangles without area are left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct TrianglesFile {
    /// Positions of the vertices.
    pub vertices: Vec<[f32; 3]>,
    /// Three indices into `vertices` for each triangle, counted from 0.
    pub indices: Vec<[u32; 3]>,
    /// Name of the material, a key of [`SceneFile::materials`](crate::SceneFile::materials).
    pub material: String,
}

impl TrianglesFile {
    /// Creates triangles of three indices into `vertices` each, with the material named `material`.
    pub fn new(
        vertices: Vec<[f32; 3]>,
        indices: Vec<[u32; 3]>,
        material: impl Into<String>,
    ) -> Self {
        Self { vertices, indices, material: material.into() }
    }
}

impl Expand for TrianglesFile {
    fn expand(&self, e: &Element<'_>, to: &mut Builder<'_>) -> Result<()> {
        let Self { vertices, indices, .. } = self;
        to.room(e, indices.len())?;
        for (i, vertex) in vertices.iter().enumerate() {
            e.point(&format!("vertices[{i}]"), *vertex)?;
        }
        let mut faces = Vec::with_capacity(indices.len());
        for (i, corner) in indices.iter().enumerate() {
            let vertex = |k: u32| vertices.get(k as usize).map(|v| Vec3::from_array(*v));
            let [Some(a), Some(b), Some(c)] = corner.map(vertex) else {
                return Err(e.error(format!(
                    "indices[{i}] must be below the number of vertices {}, is {corner:?}",
                    vertices.len()
                )));
            };
            // Real meshes contain degenerate triangles, which have no normal.
            if !(Triangle { vertices: [a, b, c] }).is_degenerate() {
                faces.push(*corner);
            }
        }
        let positions = vertices.iter().map(|vertex| Vec3::from_array(*vertex));
        to.geometry.triangles.add(positions, faces);
        Ok(())
    }
}
