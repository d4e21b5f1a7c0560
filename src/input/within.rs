//! Paths of files within the folder of a scene.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::limits::{Limits, Refused};

/// The path of `file` in `folder`. Returns an error if the file is outside the folder and the limits do
/// not allow that.
pub(crate) fn path_within(folder: &Path, file: &str, limits: &Limits) -> Result<PathBuf> {
    let path = folder.join(file);
    let within = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    // Missing files pass here: the reader reports them.
    let real = |path: &Path| path.canonicalize().ok();
    match (real(&path), real(within)) {
        (Some(there), Some(folder)) if !limits.outside_files() && !there.starts_with(&folder) => {
            let advice = limits.advice(Refused::OutsideFile);
            let message = format!("is outside the folder of the scene{advice}");
            Err(Error::input(path.display().to_string(), "", message))
        }
        _ => Ok(path),
    }
}
