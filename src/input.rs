//! Reading files, refusing what is none.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::Path;

use serde::de::DeserializeOwned;

use crate::error::{Error, Result};
use crate::limits::MAX_FILE;

/// The length of a file in bytes.
///
/// # Errors
/// Where there is none, or something else.
pub(crate) fn length(path: &Path) -> Result<u64> {
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
    Ok(kind.len())
}

/// The content of a file.
///
/// # Errors
/// As [`length`], and where it is larger than any file of a scene is.
pub(crate) fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    let length = length(path)?;
    if length > MAX_FILE {
        let message = format!("at most {MAX_FILE} bytes can be read, it has {length}");
        return Err(Error::input(path.display().to_string(), "", message));
    }
    fs::read(path).map_err(Error::io(path, "read"))
}

/// The content of a text file, which is `what`.
///
/// # Errors
/// As [`read_bytes`], and where it is not UTF-8.
pub(crate) fn read_text(path: &Path, what: &str) -> Result<String> {
    let text = String::from_utf8(read_bytes(path)?).map_err(|_| {
        let message = format!("not UTF-8 text, {what} is");
        Error::input(path.display().to_string(), "", message)
    })?;
    // Some editors begin UTF-8 with a byte order mark.
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

/// The content of a JSON file, which is `what`.
///
/// # Errors
/// As [`read_text`], and where it is not such a value: the place says line and column.
pub(crate) fn read_json<T: DeserializeOwned>(path: &Path, what: &str) -> Result<T> {
    serde_json::from_str(&read_text(path, what)?).map_err(|error| {
        let place = format!("{}:{}", error.line(), error.column());
        let message = error.to_string();
        let message = message.split(" at line ").next().unwrap_or_default();
        Error::input(path.display().to_string(), place, message)
    })
}
