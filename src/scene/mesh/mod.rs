//! Readers of the triangle meshes that scene files name. Each format has its own module.

mod indexed;
mod normals;
mod obj;
mod ply;
mod tangents;

use std::path::Path;

use super::budget::Budget;
use crate::error::{Error, Result};
use crate::input::{decompress, read_bytes};
use crate::limits::Limit;
pub use indexed::Smooth;
pub(super) use indexed::{Mesh, Transform, Transformed};
pub(super) use normals::{add_normals, unit};
pub(super) use tangents::{add_tangents, lacks_tangents};

/// Reads the positions, normals, texture coordinates, colours and faces of a `.obj` or `.ply` file, or a `.ply.gz`,
/// the names of materials and groups, and ignores the rest. Polygons become fans of triangles.
///
/// # Errors
/// If the file cannot be read, exceeds the limits or has invalid content. The message names the
/// file and line.
pub(super) fn read(path: &Path, budget: &Budget) -> Result<Mesh> {
    let extension_of = |path: &Path| path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let mut extension = extension_of(path);
    let compressed = extension.as_deref() == Some("gz");
    if compressed {
        extension = path.file_stem().and_then(|stem| extension_of(Path::new(stem)));
    }
    let parse = match extension.as_deref() {
        Some("obj") => obj::parse,
        Some("ply") => ply::parse,
        _ => {
            let message = "unsupported file extension, meshes are .obj or .ply files";
            return Err(Error::input(path.display().to_string(), "", message));
        }
    };
    let name = path.display().to_string();
    let allow = |length| budget.check_file(Limit::MeshBytes, length);
    let mut bytes = read_bytes(path, allow)?;
    if compressed {
        bytes = decompress(&bytes, allow).map_err(|message| Error::input(&*name, "", message))?;
    }
    let within = budget.with(bytes.len() as u64);
    let mut mesh = parse(&name, &bytes, &within)?;
    mesh.decode_colors();
    if mesh.triangles.is_empty() {
        return Err(Error::input(name, "", "the file has no faces, a mesh needs at least one"));
    }
    Ok(mesh.without_stray_vertices())
}
