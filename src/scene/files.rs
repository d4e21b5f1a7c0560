//! The files that a scene refers to.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::budget::Budget;
use super::place::Element;
use crate::error::{Error, Result};
use crate::image::{Encoding, Image};
use crate::limits::{Limit, Limits, Refused};

/// The path of `file` in `folder`. Returns an error if the file is outside the folder and the
/// limits do not allow that.
pub(super) fn path(e: &Element<'_>, folder: &Path, file: &str, limits: &Limits) -> Result<PathBuf> {
    let path = folder.join(file);
    let within = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    // Missing files pass here: the reader reports them.
    let real = |path: &Path| path.canonicalize().ok();
    match (real(&path), real(within)) {
        (Some(there), Some(folder)) if !limits.outside_files() && !there.starts_with(&folder) => {
            let advice = limits.advice(Refused::OutsideFile);
            let message = format!("is outside the folder of the scene{advice}");
            Err(e.error(Error::input(path.display().to_string(), "", message)))
        }
        _ => Ok(path),
    }
}

/// Reads the images of a scene, each only once.
pub(crate) struct Images<'a> {
    folder: &'a Path,
    budget: &'a Budget,
    images: HashMap<(PathBuf, Encoding), Arc<Image>>,
}

impl<'a> Images<'a> {
    pub(super) fn new(folder: &'a Path, budget: &'a Budget) -> Self {
        Self { folder, budget, images: HashMap::new() }
    }

    /// Reads the image in `file` and checks that its pixels are in [0, 1], as albedos are.
    pub(super) fn albedo_map(
        &mut self,
        e: &Element<'_>,
        file: &str,
        encoding: Encoding,
    ) -> Result<Arc<Image>> {
        let path = path(e, self.folder, file, &self.budget.limits)?;
        let key = (path, encoding);
        if let Some(image) = self.images.get(&key) {
            return Ok(Arc::clone(image));
        }
        let budget = self.budget;
        let allow = |pixels: u64, memory: u64| {
            let bytes = 12 * pixels;
            let limited = budget.limits.check(Limit::TextureBytes, bytes);
            limited.and_then(|()| budget.check(memory)).and_then(|()| budget.hold(bytes))
        };
        let image =
            Image::read_encoded(&key.0, encoding, &allow).map_err(|error| e.error(error))?;
        let is_albedo = |pixel: &&[f32; 3]| pixel.iter().all(|c| (0.0..=1.0).contains(c));
        if let Some(bad) = image.pixels().iter().find(|pixel| !is_albedo(pixel)) {
            let message =
                format!("{file}: the pixels of a texture must be in [0, 1], but one is {bad:?}");
            return Err(e.error(message));
        }
        let image = Arc::new(image);
        self.images.insert(key, Arc::clone(&image));
        Ok(image)
    }

    /// The paths of all files that were read.
    pub(super) fn files(self) -> impl Iterator<Item = PathBuf> {
        self.images.into_keys().map(|(path, _)| path)
    }
}
