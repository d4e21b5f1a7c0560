//! The files that a scene refers to.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::budget::Budget;
use super::place::Element;
use crate::error::{Error, Result};
use crate::image::{Encoding, Size, Texels};
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
    images: HashMap<(PathBuf, Encoding), Arc<Texels>>,
}

impl<'a> Images<'a> {
    pub(super) fn new(folder: &'a Path, budget: &'a Budget) -> Self {
        Self { folder, budget, images: HashMap::new() }
    }

    /// Reads the image in `file` and checks that its values are finite and not negative. With
    /// `outside`, it may be outside the folder of the scene.
    pub(super) fn texels(
        &mut self,
        e: &Element<'_>,
        file: &str,
        encoding: Encoding,
        outside: bool,
    ) -> Result<Arc<Texels>> {
        let path = match outside {
            true => self.folder.join(file),
            false => path(e, self.folder, file, &self.budget.limits)?,
        };
        let key = (path, encoding);
        if let Some(image) = self.images.get(&key) {
            return Ok(Arc::clone(image));
        }
        let budget = self.budget;
        let allow = |size: Size| {
            let bytes = Texels::bytes_of(size);
            let limited = budget.limits.check(Limit::TextureBytes, bytes);
            limited.and_then(|()| budget.check(size.memory)).and_then(|()| budget.hold(bytes))
        };
        let texels = Texels::read(&key.0, encoding, &allow).map_err(|error| e.error(error))?;
        if let Some(bad) = texels.unusable() {
            let message = format!(
                "{file}: the pixels of a texture must be finite and not negative, but one is {bad:?}"
            );
            return Err(e.error(message));
        }
        let texels = Arc::new(texels);
        self.images.insert(key, Arc::clone(&texels));
        Ok(texels)
    }

    /// Holds memory for tables that belong to an image, unless it exceeds the limit.
    pub(super) fn hold(&self, e: &Element<'_>, bytes: u64) -> Result<()> {
        self.budget.hold(bytes).map_err(|message| e.error(message))
    }

    /// The paths of all files that were read.
    pub(super) fn files(self) -> impl Iterator<Item = PathBuf> {
        self.images.into_keys().map(|(path, _)| path)
    }
}
