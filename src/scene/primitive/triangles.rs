//! Lists of triangles.

use glam::{DVec3, Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::mesh::{is_yes, yes};
use super::{Builder, Expand, IndexedMesh};
use crate::checks::Location;
use crate::error::Result;
use crate::geometry::{Triangle, Vertices};
use crate::scene::mesh::{add_normals, unit};

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
    /// Texture coordinates of the second set, or none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub second_uvs: Vec<[f32; 2]>,
    /// Colours of the vertices in linear RGB, each channel in [0, 1], or none. The texture
    /// `vertex_color` uses them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub colors: Vec<[f32; 3]>,
    /// Tangents of the vertices for normal maps, of any length, or none. Smooth triangles without
    /// tangents get those of MikkTSpace.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tangents: Vec<[f32; 3]>,
    /// Whether shadows on smooth triangles fade out towards the terminator, which hides the edges of
    /// the triangles (Chiang, Li, Burley 2019, "Taming the Shadow Terminator").
    #[serde(default = "yes", skip_serializing_if = "is_yes")]
    pub soft_terminator: bool,
    /// Name of the material, a key of [`SceneFile::materials`](crate::SceneFile::materials).
    pub material: String,
    /// Its number in the file of another program, by which scene files refer to it.
    #[serde(skip)]
    pub(crate) number: Option<usize>,
}

impl TrianglesFile {
    /// Creates triangles of three indices into `vertices` each, with the material named `material`.
    pub fn new(
        vertices: Vec<[f32; 3]>,
        indices: Vec<[u32; 3]>,
        material: impl Into<String>,
    ) -> Self {
        Self {
            vertices,
            indices,
            normals: Vec::new(),
            uvs: Vec::new(),
            second_uvs: Vec::new(),
            colors: Vec::new(),
            tangents: Vec::new(),
            soft_terminator: true,
            material: material.into(),
            number: None,
        }
    }
}

impl TrianglesFile {
    /// Checks everything, and returns the vertices and the triangles that have an area.
    fn checked(&self, e: &Location<'_>) -> Result<(Vertices, Vec<[u32; 3]>)> {
        let Self { vertices, indices, normals, uvs, second_uvs, colors, tangents, .. } = self;
        for (i, vertex) in vertices.iter().enumerate() {
            e.point(&format!("vertices[{i}]"), *vertex)?;
        }
        for (name, count, numbers) in [
            ("normals", normals.len(), normals.as_flattened()),
            ("uvs", uvs.len(), uvs.as_flattened()),
            ("second_uvs", second_uvs.len(), second_uvs.as_flattened()),
            ("colors", colors.len(), colors.as_flattened()),
            ("tangents", tangents.len(), tangents.as_flattened()),
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
        for (i, color) in colors.iter().enumerate() {
            e.color(&format!("colors[{i}]"), *color, 1.0)?;
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
        let units = |list: &[[f32; 3]]| {
            list.iter().map(|v| unit(DVec3::from(v.map(f64::from)))).collect::<Vec<_>>()
        };
        let pairs =
            |list: &[[f32; 2]]| list.iter().map(|uv| Vec2::from_array(*uv)).collect::<Vec<_>>();
        let vertices = Vertices {
            positions: vectors(vertices),
            normals: units(normals),
            uvs: pairs(uvs),
            second_uvs: pairs(second_uvs),
            colors: vectors(colors),
            tangents: units(tangents),
        };
        Ok((vertices, faces))
    }

    /// The list as a mesh that has not been transformed. The error messages of `e` are about the list.
    pub(crate) fn mesh(&self, e: &Location<'_>) -> Result<IndexedMesh> {
        let (mut vertices, triangles) = self.checked(e)?;
        // The transform gives them unit length, which would round them twice.
        vertices.normals = vectors(&self.normals);
        vertices.tangents = vectors(&self.tangents);
        Ok(IndexedMesh { vertices, triangles, ..IndexedMesh::default() })
    }
}

fn vectors(list: &[[f32; 3]]) -> Vec<Vec3> {
    list.iter().map(|v| Vec3::from_array(*v)).collect()
}

impl Expand for TrianglesFile {
    fn material(&self) -> Option<&str> {
        Some(&self.material)
    }

    fn expand(&self, e: &Location<'_>, to: &mut Builder<'_>) -> Result<()> {
        to.room(e, self.indices.len())?;
        to.budget.hold_vertices(self.vertices.len()).map_err(|message| e.error(message))?;
        let (mut vertices, faces) = self.checked(e)?;
        if vertices.normals.contains(&Vec3::ZERO) {
            add_normals(&mut vertices, &faces);
        }
        to.triangles(e, vertices, faces, self.soft_terminator)
    }
}
