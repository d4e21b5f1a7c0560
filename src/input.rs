//! Reading files, refusing what is none.

use std::fs;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use serde::de::DeserializeOwned;

use crate::error::{Error, Result};

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

/// The content of a file whose length `check` allows.
///
/// # Errors
/// As [`length`], and where `check` does not allow it.
pub(crate) fn read_bytes(
    path: &Path,
    check: impl Fn(u64) -> Result<(), String>,
) -> Result<Vec<u8>> {
    let length = length(path)?;
    let bad = |message| Error::input(path.display().to_string(), "", message);
    check(length).map_err(bad)?;
    let failed = |error| Error::io(path, "read")(error);
    let (file, mut bytes) = (fs::File::open(path).map_err(failed)?, Vec::new());
    bytes.try_reserve_exact(length as usize).map_err(|error| failed(error.into()))?;
    // Files that grow, and those of /proc, which are longer than they say.
    file.take(length + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > length {
        return Err(bad(format!("it has more than the {length} bytes that it says it has")));
    }
    Ok(bytes)
}

/// The content of a text file, which is `what`.
///
/// # Errors
/// As [`read_bytes`], and where it is not UTF-8.
pub(crate) fn read_text(
    path: &Path,
    what: &str,
    check: impl Fn(u64) -> Result<(), String>,
) -> Result<String> {
    let text = String::from_utf8(read_bytes(path, check)?).map_err(|_| {
        let message = format!("not UTF-8 text, {what} is");
        Error::input(path.display().to_string(), "", message)
    })?;
    // Some editors begin UTF-8 with a byte order mark.
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

/// The content of a JSON file, which is `what`, of at most so many bytes.
///
/// # Errors
/// As [`read_text`], and where it is not such a value: the place says line and column.
pub(crate) fn read_json<T: DeserializeOwned>(path: &Path, what: &str, most: u64) -> Result<T> {
    let check = |length| match length <= most {
        true => Ok(()),
        false => Err(format!("at most {most} bytes can be read, it has {length}")),
    };
    serde_json::from_str(&read_text(path, what, check)?).map_err(|error| {
        let place = format!("{}:{}", error.line(), error.column());
        let message = error.to_string();
        let message = message.split(" at line ").next().unwrap_or_default();
        Error::input(path.display().to_string(), place, message)
    })
}
