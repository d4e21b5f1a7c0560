//! Reads the files that scenes name.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;

use super::gltf::Gltf;
use super::{builtin, mesh, reference};
use crate::error::Result;
use crate::limits::Budget;
use crate::scene::{Assets, IndexedMesh};
use crate::shading::{ImageContainer, ImageFiles};

/// A mesh that has been read, with its path and origin.
type Read = (PathBuf, DVec3, IndexedMesh);

/// The reader of all formats.
#[derive(Clone, Debug, Default)]
pub(crate) struct Files {
    /// The first that asks for it takes it.
    read: Arc<Mutex<Option<Read>>>,
}

impl Files {
    /// With a mesh that has been read.
    pub(crate) fn with_mesh(path: &Path, origin: DVec3, mesh: IndexedMesh) -> Self {
        Self { read: Arc::new(Mutex::new(Some((path.to_owned(), origin, mesh)))) }
    }

    /// Bytes of memory that they hold.
    pub(crate) fn memory(&self) -> u64 {
        let read = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        read.as_ref().map_or(0, |(.., mesh)| mesh.memory())
    }
}

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
        let same = |(known, at, _): &mut Read| known == path && *at == origin;
        // Unlocked before another file is read, since threads read several at once.
        let read = self.read.lock().unwrap_or_else(PoisonError::into_inner).take_if(same);
        match read {
            Some((.., mesh)) => {
                budget.release(mesh.memory());
                Ok(mesh)
            }
            None => mesh::read(path, origin, budget),
        }
    }

    fn lists(
        &self,
        path: &Path,
        origin: DVec3,
        budget: &Budget,
    ) -> Result<Vec<(usize, IndexedMesh)>> {
        reference::read(path, origin, budget)
    }
}
