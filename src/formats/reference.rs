//! References of scene files to lists of triangles in scenes of other programs: `mesh(file: "helmet.glb#3")`.
//!
//! In glTF files the number counts the parts of meshes that are shown, in pbrt files the shapes.

use std::path::Path;

use glam::DVec3;

use super::import::{ImportOptions, Missing, read_from};
use super::imported;
use crate::checks::Location;
use crate::error::{Error, Result};
use crate::limits::Budget;
use crate::scene::{IndexedMesh, MeshFile, NamedMesh, PrimitiveFile, SceneFile};

/// Lists of more triangles become references. Shorter ones, such as walls, can be edited.
const LONG: usize = 100;

/// The lists of triangles of the scene at `path`, whose origin becomes `origin`.
pub(crate) fn read(
    path: &Path,
    origin: DVec3,
    budget: &Budget,
) -> Result<Vec<(usize, IndexedMesh)>> {
    let Some(format) = imported(path) else {
        let message = "only parts of glTF and pbrt files have numbers";
        return Err(Error::input(path.display().to_string(), "", message));
    };
    // The scene that refers to the lists has textures of its own.
    let options = ImportOptions { missing: Missing::Grey, ..ImportOptions::default() };
    let mut file = read_from(path, format, &options, origin, budget)?;
    let (name, mut lists) = (path.display().to_string(), Vec::new());
    visit(&mut file, |part| {
        if let PrimitiveFile::Triangles(list) = part
            && let Some(number) = list.number
        {
            let place = format!("#{number}");
            let mesh = list.mesh(&Location { file: &name, place, kind: "triangles" });
            lists.push(mesh.map(|mesh| (number, mesh)));
        }
    });
    lists.into_iter().collect()
}

/// Replaces long lists of triangles in `scene`, an import of `file` with the usual pose, by references.
pub(crate) fn shorten(scene: &mut SceneFile, file: &str) {
    let origin = scene.origin;
    visit(scene, |part| {
        if let PrimitiveFile::Triangles(list) = part
            && let Some(number) = list.number
            && list.indices.len() > LONG
        {
            let mut mesh = MeshFile::new(format!("{file}#{number}"), &*list.material);
            (mesh.origin, mesh.soft_terminator) = (origin, list.soft_terminator);
            *part = mesh.into();
        }
    });
}

/// Visits all primitives, also those in named meshes.
fn visit(scene: &mut SceneFile, mut visitor: impl FnMut(&mut PrimitiveFile)) {
    for (_, mesh) in &mut scene.meshes.0 {
        if let NamedMesh::Parts(parts) = mesh {
            parts.iter_mut().for_each(&mut visitor);
        }
    }
    scene.primitives.iter_mut().for_each(visitor);
}
