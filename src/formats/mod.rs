//! The formats of scenes and meshes, one folder for each, and the loading of scenes by name or path.

mod assets;
mod builtin;
mod edit;
mod generated;
mod gltf;
mod import;
mod load;
mod mesh;
mod mesh_scene;
mod obj;
mod origin;
mod parsed;
mod pbrt;
mod ply;
mod polygons;
mod ron;
mod source;
mod view;

pub use builtin::BUILTIN_NAMES;
pub(crate) use import::{ImportOptions, LightUnits, Missing};
pub(crate) use parsed::Parsed;
pub use source::Source;

/// The formats of scenes of other programs.
static SCENES: [&import::Format; 2] = [&gltf::FORMAT, &pbrt::FORMAT];

/// The formats of meshes.
static MESHES: [&mesh::Format; 2] = [&obj::FORMAT, &ply::FORMAT];
