//! Reads the files that scenes name.

use std::borrow::Cow;
use std::path::Path;

use glam::DVec3;

use super::gltf::Gltf;
use super::{builtin, mesh, reference};
use crate::error::Result;
use crate::limits::Budget;
use crate::scene::{Assets, IndexedMesh};
use crate::shading::{ImageContainer, ImageFiles};

/// The reader of all formats.
pub(crate) struct Files;

impl ImageFiles for Files {
    fn embedded(&self, path: &Path) -> Option<&'static [u8]> {
        builtin::image(path)
    }

    fn open<'b>(&self, path: &Path, budget: &'b Budget) -> Result<Box<dyn ImageContainer + 'b>> {
        Ok(Box::new(Gltf::read(path, budget)?))
    }
}

impl ImageContainer for Gltf<'_> {
    fn image(&self, index: usize) -> Result<Cow<'_, [u8]>, String> {
        Gltf::image(self, index)
    }
}

impl Assets for Files {
    fn mesh(&self, path: &Path, origin: DVec3, budget: &Budget) -> Result<IndexedMesh> {
        mesh::read(path, origin, budget)
    }

    fn lists(&self, path: &Path, origin: DVec3, budget: &Budget) -> Result<Vec<IndexedMesh>> {
        reference::read(path, origin, budget)
    }
}
