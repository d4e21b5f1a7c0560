//! What scenes need from the files that they name.

use std::path::Path;

use glam::DVec3;

use super::IndexedMesh;
use crate::error::Result;
use crate::limits::Budget;
use crate::shading::ImageFiles;

/// Reads the files that scenes name. The module of formats implements it, so that the resolution of a scene knows
/// no format.
pub(crate) trait Assets: ImageFiles {
    /// Reads the mesh in the file at `path`. `origin` is subtracted from its positions before they are rounded.
    ///
    /// # Errors
    /// If the file cannot be read, has invalid content, or exceeds a limit.
    fn mesh(&self, path: &Path, origin: DVec3, budget: &Budget) -> Result<IndexedMesh>;

    /// Reads all lists of triangles in the scene of another program at `path`, with their numbers, as for
    /// [`mesh`](Self::mesh).
    ///
    /// # Errors
    /// As for [`mesh`](Self::mesh), and if the file contains no scene.
    fn lists(
        &self,
        path: &Path,
        origin: DVec3,
        budget: &Budget,
    ) -> Result<Vec<(usize, IndexedMesh)>>;
}
