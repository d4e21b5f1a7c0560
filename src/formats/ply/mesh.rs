//! Builds a mesh from the rows of a PLY file.

use glam::Vec3;
use ply_rs_bw::ply::Header;

use super::corners::Corners;
use super::row::{COLOR, NORMAL, Row, UVS, has};
use crate::formats::polygons::Polygon;
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
            normals: has(header, "vertex", &NORMAL),
            uvs: UVS.iter().position(|names| has(header, "vertex", names)),
            colors: has(header, "vertex", &COLOR),
        }
    }

    /// Bytes of memory for each vertex.
    pub(super) fn bytes(self) -> usize {
        let with = |bytes: usize, is_there: bool| if is_there { bytes } else { 0 };
        12 + with(12, self.normals) + with(8, self.uvs.is_some()) + with(12, self.colors)
    }
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

/// Adds faces to the mesh, as fans, and their data to `corners`. Their vertex indices must be below `count`,
/// the number of vertices in the whole file. Faces may precede vertices, so the number of vertices read so
/// far would not do. `Err` is the same as for [`add_vertices`].
pub(super) fn add_faces(
    mesh: &mut IndexedMesh,
    polygons: &mut Vec<Polygon>,
    data: &mut Corners,
    rows: &[Row],
    count: usize,
) -> Result<(), (usize, String)> {
    for (number, row) in rows.iter().enumerate() {
        let corners = &row.corners;
        if corners.len() < 3 {
            let message = "a face needs a list `vertex_indices` of three or more";
            return Err((number, message.to_owned()));
        }
        if !corners.iter().all(|corner| is_known(*corner, count)) {
            return Err((number, unknown("face", count)));
        }
        if corners.len() > 3 {
            let first = mesh.triangles.len() as u32;
            polygons.push(Polygon { first, corners: corners.len() as u32 });
        }
        mesh.triangles.extend(fan(corners).map(|corners| corners.map(|index| index as u32)));
        data.add(row).map_err(|message| (number, message.to_owned()))?;
    }
    Ok(())
}

/// Adds triangle strips to the mesh: each corner makes a triangle with the two before it, every other one
/// with the opposite order. A corner of -1 begins another strip. `Err` is the same as for [`add_vertices`].
pub(super) fn add_strips(
    mesh: &mut IndexedMesh,
    rows: &[Row],
    count: usize,
) -> Result<(), (usize, String)> {
    for (number, row) in rows.iter().enumerate() {
        for strip in row.corners.split(|corner| *corner == -1) {
            if !strip.iter().all(|corner| is_known(*corner, count)) {
                return Err((number, unknown("strip", count)));
            }
            for (i, corners) in strip.windows(3).enumerate() {
                let [a, b, c] = [corners[0], corners[1], corners[2]].map(|index| index as u32);
                // Equal corners join strips.
                if a != b && b != c && c != a {
                    mesh.triangles.push(if i % 2 == 0 { [a, b, c] } else { [b, a, c] });
                }
            }
        }
    }
    Ok(())
}

fn is_known(corner: i32, count: usize) -> bool {
    usize::try_from(corner).is_ok_and(|index| index < count)
}

fn unknown(what: &str, count: usize) -> String {
    format!("the {what} refers to a missing vertex, the file has {count} vertices")
}
