//! Output folders: files of other programs in them are never overwritten.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Number of bytes at the start of a file that [`contains`] searches.
const START: u64 = 4096;

/// Checks that each of `files` is missing, or belongs to an earlier output of the same command,
/// which may be overwritten.
///
/// # Errors
/// [`Error::Usage`] names the first file that must not be overwritten.
pub(crate) fn check_unrelated(files: &[PathBuf], is_own: impl Fn(&Path) -> bool) -> Result<()> {
    match files.iter().find(|file| file.symlink_metadata().is_ok() && !is_own(file)) {
        Some(file) => Err(Error::Usage(format!(
            "{}: this file exists and is not an earlier output of this command: choose another folder, or delete the file",
            file.display()
        ))),
        None => Ok(()),
    }
}

/// Whether a file contains `text` near its start.
pub(crate) fn contains(file: &Path, text: &str) -> bool {
    let mut start = Vec::new();
    let read = File::open(file).and_then(|file| file.take(START).read_to_end(&mut start));
    read.is_ok() && start.windows(text.len()).any(|window| window == text.as_bytes())
}
