//! Reading the files that scenes are made of.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::Path;

use crate::error::{Error, Result};
use crate::limits::MAX_FILE;

/// The content of a file.
///
/// # Errors
/// Where there is none, or something else, or it is larger than any scene is.
pub(super) fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    // Reading a folder says so only on some systems, reading a pipe might never end.
    let kind = fs::metadata(path).map_err(Error::io(path, "read"))?;
    if kind.is_dir() {
        return Err(Error::io(path, "read")(ErrorKind::IsADirectory.into()));
    }
    if !kind.is_file() {
        return Err(Error::io(path, "read")(io::Error::other(
            "it is a device or pipe, not a file",
        )));
    }
    if kind.len() > MAX_FILE {
        let message = format!("at most {MAX_FILE} bytes can be read, it has {}", kind.len());
        return Err(Error::input(path.display().to_string(), "", message));
    }
    fs::read(path).map_err(Error::io(path, "read"))
}

/// The content of a text file.
///
/// # Errors
/// As [`read_bytes`], and where it is not UTF-8.
pub(super) fn read_text(path: &Path) -> Result<String> {
    let text = String::from_utf8(read_bytes(path)?).map_err(|_| {
        Error::input(path.display().to_string(), "", "not UTF-8 text, a scene file is")
    })?;
    // Some editors begin UTF-8 with a byte order mark.
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}
