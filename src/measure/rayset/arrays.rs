//! Files of raw little-endian arrays.

use std::fs;
use std::io::Write;
use std::path::Path;

use crate::error::{Error, Result};
use crate::input;
use crate::output::write_atomically;

/// The file that lists all arrays. It is written last, so a folder that has one is complete.
pub(super) const MANIFEST: &str = "manifest.json";

pub(super) fn write_floats(path: &Path, values: impl Iterator<Item = f32>) -> Result<()> {
    write_words(path, values.map(f32::to_bits))
}

pub(super) fn write_words(path: &Path, mut words: impl Iterator<Item = u32>) -> Result<()> {
    write_atomically(path, |file| words.try_for_each(|word| file.write_all(&word.to_le_bytes())))
}

/// Reads `count` records of `N` little-endian f32.
pub(super) fn read_records<const N: usize>(
    folder: &Path,
    file: &str,
    count: usize,
) -> Result<Vec<[f32; N]>> {
    let path = folder.join(file);
    // The length is checked first, so that a file of the wrong length is not read at all.
    let found = input::length(&path)?;
    if Some(found) != (count as u64).checked_mul(4 * N as u64) {
        let record = 4 * N;
        let message =
            format!("has {found} bytes, but {MANIFEST} lists {count} records of {record} bytes");
        return Err(Error::input(path.display().to_string(), "", message));
    }
    let bytes = fs::read(&path).map_err(Error::io(&path, "read"))?;
    let (words, _) = bytes.as_chunks::<4>();
    let (records, _) = words.as_chunks::<N>();
    Ok(records.iter().map(|record| record.map(f32::from_le_bytes)).collect())
}
