//! Builds a mesh from the rows of a PLY file.

use glam::Vec3;
use ply_rs_bw::ply::Header;

use super::row::{COLOR, NORMAL, Row, UVS};
use crate::geometry::Vertices;
use crate::scene::mesh::{IndexedMesh, fan, in_range};

/// The data that vertices have besides their positions.
#[derive(Clone, Copy)]
pub(super) struct Attributes {
    normals: bool,
    /// The index in [`UVS`] of the names of the texture coordinates.
    uvs: Option<usize>,
    colors: bool,
}

impl Attributes {
    pub(super) fn new(header: &Header) -> Self {
        Self {
            normals: has(header, &NORMAL),
            uvs: UVS.iter().position(|names| has(header, names)),
            colors: has(header, &COLOR),
        }
    }

    /// Bytes of memory for each vertex.
    pub(super) fn bytes(self) -> usize {
        let with = |bytes: usize, is_there: bool| if is_there { bytes } else { 0 };
        12 + with(12, self.normals) + with(8, self.uvs.is_some()) + with(12, self.colors)
    }
}

/// Whether all of these properties are in the header of the vertices.
fn has(header: &Header, names: &[&str]) -> bool {
    let vertex = header.elements.get("vertex");
    vertex.is_some_and(|vertex| names.iter().all(|name| vertex.properties.contains_key(*name)))
}

/// Adds vertices to the mesh. `Err` holds the index of the invalid row and the reason.
pub(super) fn add_vertices(
    mesh: &mut IndexedMesh,
    rows: &[Row],
    attributes: Attributes,
) -> Result<(), (usize, String)> {
    if let Some(row) = rows.iter().position(|row| !in_range(row.position)) {
        return Err((row, "a vertex needs x, y and z, finite and within ±1e9".to_owned()));
    }
    let Vertices { positions, normals, uvs, colors, .. } = &mut mesh.vertices;
    positions.extend(rows.iter().map(|row| row.position));
    if attributes.normals {
        // A vertex without a usable normal gets the mean of its triangles.
        let usable = |row: &Row| if row.normal.is_finite() { row.normal } else { Vec3::ZERO };
        normals.extend(rows.iter().map(usable));
    }
    if let Some(names) = attributes.uvs {
        if let Some(row) = rows.iter().position(|row| !row.uvs[names].is_finite()) {
            return Err((row, "texture coordinates must be finite".to_owned()));
        }
        uvs.extend(rows.iter().map(|row| row.uvs[names]));
    }
    if attributes.colors {
        colors.extend(rows.iter().map(|row| row.color));
    }
    Ok(())
}

/// Adds faces to the mesh. Their vertex indices must be below `count`, the number of vertices in
/// the whole file. Faces may precede vertices, so the number of vertices read so far would not do.
/// `Err` is the same as for [`add_vertices`].
pub(super) fn add_faces(
    mesh: &mut IndexedMesh,
    rows: &[Row],
    count: usize,
) -> Result<(), (usize, String)> {
    for (number, Row { corners, .. }) in rows.iter().enumerate() {
        if corners.len() < 3 {
            let message = "a face needs a list `vertex_indices` of three or more";
            return Err((number, message.to_owned()));
        }
        let is_known = |&corner: &i32| usize::try_from(corner).is_ok_and(|index| index < count);
        if !corners.iter().all(is_known) {
            let message =
                format!("the face refers to a missing vertex, the file has {count} vertices");
            return Err((number, message));
        }
        mesh.triangles.extend(fan(corners).map(|corners| corners.map(|index| index as u32)));
    }
    Ok(())
}
