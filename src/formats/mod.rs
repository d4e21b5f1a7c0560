//! The formats of scenes and meshes, one folder for each, and the loading of scenes by name or path.

mod assets;
mod builtin;
mod description;
mod edit;
mod generated;
mod gltf;
mod import;
mod load;
mod mesh;
mod mesh_scene;
mod obj;
mod origin;
mod pbrt;
mod ply;
mod polygons;
mod reference;
mod relocate;
mod ron;
mod source;
mod view;

pub use builtin::BUILTIN_NAMES;
use std::path::Path;

pub use description::SceneDescription;
pub use import::{ImportOptions, LightUnits, Missing};
pub use source::Source;

/// The formats of scenes of other programs.
static SCENES: [&import::Format; 2] = [&gltf::FORMAT, &pbrt::FORMAT];

/// The formats of meshes.
static MESHES: [&mesh::Format; 2] = [&obj::FORMAT, &ply::FORMAT];

/// The extension of a path in lower case.
fn extension(path: &Path) -> Option<String> {
    path.extension().map(|extension| extension.to_string_lossy().to_lowercase())
}

/// The format of the file at `path`, if it is that of scenes of other programs.
fn imported(path: &Path) -> Option<&'static import::Format> {
    let extension = extension(path)?;
    SCENES.iter().copied().find(|format| format.extensions.contains(&&*extension))
}
