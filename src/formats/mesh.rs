//! Meshes that scene files name, in any of their formats.

use std::path::Path;

use glam::DVec3;

use super::{MESHES, imported};
use crate::error::{Error, Result};
use crate::input::{decompress, read_bytes};
use crate::limits::{Budget, Limit};
use crate::scene::IndexedMesh;

/// A format of meshes.
pub(crate) struct Format {
    /// The extension of its files, in lower case.
    pub(crate) extension: &'static str,
    /// Parses the content of the file with this name, and subtracts a point from its positions.
    pub(crate) parse: fn(&str, &[u8], DVec3, &Budget) -> Result<IndexedMesh>,
}

/// Reads the positions, normals, texture coordinates, colours and faces of a `.obj` or `.ply` file, or a `.ply.gz`,
/// the names of materials and groups, and ignores the rest. Polygons become triangles. `origin` is subtracted from
/// positions before they are rounded.
///
/// # Errors
/// If the file cannot be read, exceeds the limits or has invalid content. The message names the
/// file and line.
pub(crate) fn read(path: &Path, origin: DVec3, budget: &Budget) -> Result<IndexedMesh> {
    let extension_of = |path: &Path| path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let mut extension = extension_of(path);
    let compressed = extension.as_deref() == Some("gz");
    if compressed {
        extension = path.file_stem().and_then(|stem| extension_of(Path::new(stem)));
    }
    let name = path.display().to_string();
    let format = MESHES.iter().find(|format| Some(format.extension) == extension.as_deref());
    let Some(Format { parse, .. }) = format else {
        let message = match imported(path) {
            None => "unsupported file extension, meshes are .obj or .ply files".to_owned(),
            Some(_) => format!("parts of glTF and pbrt files have numbers, such as {name}#0"),
        };
        return Err(Error::input(name, "", message));
    };
    let allow = |length| budget.check_file(Limit::MeshBytes, length);
    let mut bytes = read_bytes(path, allow)?;
    if compressed {
        bytes = decompress(&bytes, allow).map_err(|message| Error::input(&*name, "", message))?;
    }
    let within = budget.with(bytes.len() as u64);
    let mut mesh = parse(&name, &bytes, origin, &within)?;
    mesh.decode_colors();
    if mesh.triangles.is_empty() {
        return Err(Error::input(name, "", "the file has no faces, a mesh needs at least one"));
    }
    Ok(mesh.without_stray_vertices())
}
