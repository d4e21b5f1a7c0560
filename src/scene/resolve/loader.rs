//! Images that a scene names, each read once.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::Resolver;
use crate::error::Result;
use crate::image::Image;
use crate::limits::Limit;
use crate::scene::place::Element;

/// Reads the images of a scene.
pub(crate) struct Loader<'a> {
    resolver: &'a Resolver<'a>,
    folder: &'a Path,
    images: HashMap<PathBuf, Arc<Image>>,
}

impl<'a> Loader<'a> {
    pub(super) fn new(resolver: &'a Resolver<'a>, folder: &'a Path) -> Self {
        Self { resolver, folder, images: HashMap::new() }
    }

    /// The image in `file`, whose pixels are albedos: in [0, 1].
    pub(in crate::scene) fn albedo_map(
        &mut self,
        e: &Element<'_>,
        file: &str,
    ) -> Result<Arc<Image>> {
        let path = self.resolver.path(e, self.folder, file)?;
        if let Some(image) = self.images.get(&path) {
            return Ok(Arc::clone(image));
        }
        let budget = &self.resolver.budget;
        let allow = |pixels: u64, memory: u64| {
            let bytes = 12 * pixels;
            let limited = budget.limits.check(Limit::TextureBytes, bytes);
            limited.and_then(|()| budget.check(memory)).and_then(|()| budget.hold(bytes))
        };
        let image = Image::read_where(&path, &allow).map_err(|error| e.error(error))?;
        let is_albedo = |pixel: &&[f32; 3]| pixel.iter().all(|c| (0.0..=1.0).contains(c));
        if let Some(bad) = image.pixels().iter().find(|pixel| !is_albedo(pixel)) {
            let message = format!("{file}: an albedo must be in [0, 1], a pixel is {bad:?}");
            return Err(e.error(message));
        }
        let image = Arc::new(image);
        self.images.insert(path, Arc::clone(&image));
        Ok(image)
    }

    /// The files that were read.
    pub(super) fn finish(self) -> impl Iterator<Item = PathBuf> {
        self.images.into_keys()
    }
}
