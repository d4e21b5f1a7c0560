//! Triangle meshes with indices, as the readers of all formats give them.

mod indexed;
mod normals;
mod tangents;

pub use indexed::Smooth;
pub(crate) use indexed::{IndexedMesh, Labels, Transform, Transformed, fan, in_range};
pub(crate) use normals::{add_normals, unit};
pub(crate) use tangents::{add_tangents, lacks_tangents};
