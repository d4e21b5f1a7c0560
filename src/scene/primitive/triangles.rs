//! Lists of triangles.

use glam::{DVec3, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::mesh::{is_yes, yes};
use super::{Builder, Expand};
use crate::error::Result;
use crate::geometry::{Triangle, Vertices};
use crate::scene::mesh::unit;
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
    /// Normals of the vertices, of any length, or none for flat triangles. Smooth triangles are
    /// shaded with the interpolated normals of their vertices.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates of the vertices, or none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub uvs: Vec<[f32; 2]>,
    /// Whether shadows on smooth triangles fade out towards the terminator, which hides the edges of
    /// the triangles (Chiang, Li, Burley 2019, "Taming the Shadow Terminator").
    #[serde(default = "yes", skip_serializing_if = "is_yes")]
    pub soft_terminator: bool,
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
        let (normals, uvs, material) = (Vec::new(), Vec::new(), material.into());
        Self { vertices, indices, normals, uvs, soft_terminator: true, material }
    }
}

impl Expand for TrianglesFile {
    fn expand(&self, e: &Element<'_>, to: &mut Builder<'_>) -> Result<()> {
        let &Self { ref vertices, ref indices, ref normals, ref uvs, soft_terminator, .. } = self;
        to.room(e, indices.len())?;
        to.budget.hold_vertices(vertices.len()).map_err(|message| e.error(message))?;
        for (i, vertex) in vertices.iter().enumerate() {
            e.point(&format!("vertices[{i}]"), *vertex)?;
        }
        for (name, count, numbers) in [
            ("normals", normals.len(), normals.as_flattened()),
            ("uvs", uvs.len(), uvs.as_flattened()),
        ] {
            if ![0, vertices.len()].contains(&count) {
                let vertices = vertices.len();
                return Err(e.error(format!(
                    "{name} must be as many as vertices, which are {vertices}, or none, are {count}"
                )));
            }
            if let Some(index) = numbers.iter().position(|number| !number.is_finite()) {
                return Err(
                    e.error(format!("{name}[{}] must be finite", index * count / numbers.len()))
                );
            }
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
        let positions = vertices.iter().map(|vertex| Vec3::from_array(*vertex)).collect();
        let vertices = Vertices {
            positions,
            normals: normals
                .iter()
                .map(|normal| unit(DVec3::from(normal.map(f64::from))))
                .collect(),
            uvs: uvs.iter().map(|uv| Vec2::from_array(*uv)).collect(),
        };
        to.geometry.triangles.add(vertices, faces, soft_terminator);
        Ok(())
    }
}
