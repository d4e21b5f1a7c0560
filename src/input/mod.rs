//! Reads input files, and rejects folders, devices and pipes.

mod within;

use std::fs;
use std::io::{self, ErrorKind, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;
use serde::de::DeserializeOwned;
pub(crate) use within::path_within;

use crate::error::{Error, Result};

/// Bytes that are decompressed before the limit is checked again.
const STEP: u64 = 1 << 20;

/// Length of a file in bytes.
///
/// # Errors
/// If the file cannot be found, or is a folder, device or pipe.
pub(crate) fn length(path: &Path) -> Result<u64> {
    // Reading a folder fails only on some systems, and reading a pipe might never end.
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

/// Reads a file whose length `check` accepts.
///
/// # Errors
/// As [`length`]; also if `check` rejects the length, or the file is longer than reported.
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
    // Reading one more byte detects files that grow, and files in /proc, which are longer than
    // reported.
    file.take(length + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > length {
        return Err(bad(format!("it is longer than its reported length of {length} bytes")));
    }
    Ok(bytes)
}

/// Decompresses the gzip file with this content.
///
/// # Errors
/// If the content is damaged, or decompresses to more bytes than `allow` accepts.
pub(crate) fn decompress(
    bytes: &[u8],
    allow: impl Fn(u64) -> Result<(), String>,
) -> Result<Vec<u8>, String> {
    let (mut decoder, mut content) = (MultiGzDecoder::new(bytes), Vec::new());
    loop {
        let mut step = decoder.by_ref().take(STEP);
        let read = step.read_to_end(&mut content);
        let read = read.map_err(|error| format!("cannot decompress: {error}"))?;
        if read == 0 {
            return Ok(content);
        }
        // The next step can double the list while it grows.
        allow(2 * content.len() as u64 + STEP)?;
    }
}

/// Reads a text file. `what` names the kind of file in the error message, such as "a plan".
///
/// # Errors
/// As [`read_bytes`]; also if the file is not UTF-8.
pub(crate) fn read_text(
    path: &Path,
    what: &str,
    check: impl Fn(u64) -> Result<(), String>,
) -> Result<String> {
    let text = String::from_utf8(read_bytes(path, check)?).map_err(|_| {
        let message = format!("not UTF-8 text, which {what} must be");
        Error::input(path.display().to_string(), "", message)
    })?;
    // Some editors begin UTF-8 with a byte order mark.
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

/// Reads a JSON file of at most `most` bytes. `what` names the kind of file, as for [`read_text`].
///
/// # Errors
/// As [`read_text`]; also if the content is not a valid `T`. The error gives line and column.
pub(crate) fn read_json<T: DeserializeOwned>(path: &Path, what: &str, most: u64) -> Result<T> {
    let check = |length| match length <= most {
        true => Ok(()),
        false => Err(format!("it has {length} bytes, at most {most} are allowed")),
    };
    serde_json::from_str(&read_text(path, what, check)?).map_err(|error| {
        let place = format!("{}:{}", error.line(), error.column());
        let message = error.to_string();
        let message = message.split(" at line ").next().unwrap_or_default();
        Error::input(path.display().to_string(), place, message)
    })
}
