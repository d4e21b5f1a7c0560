//! Reads a folder of bench records, one JSON file per record.

use std::fs;
use std::path::Path;

use jiff::Timestamp;

use crate::error::{Error, Result};
use crate::measure::bench::Record;

/// Bench records in chronological order.
#[derive(Debug)]
pub(crate) struct History {
    /// The records, with the names of their files.
    pub(crate) records: Vec<(String, Record)>,
}

impl History {
    /// Reads all `.json` files of `folder`.
    ///
    /// # Errors
    /// If the folder has no `.json` file, if the folder or a file cannot be read, or if a file is
    /// not a bench record.
    pub(crate) fn read(folder: &Path) -> Result<Self> {
        let mut records = Vec::new();
        for entry in fs::read_dir(folder).map_err(Error::io(folder, "read"))? {
            let path = entry.map_err(Error::io(folder, "read"))?.path();
            if path.extension().is_some_and(|extension| extension == "json") {
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let record = Record::read(&path)?;
                records.push((time(&record, &path)?, name, record));
            }
        }
        if records.is_empty() {
            let message = "the folder has no bench records: `ptfast bench --json FILE` writes one";
            return Err(Error::input(folder.display().to_string(), "", message));
        }
        // Records without a time come first; records of the same second are sorted by file name.
        records.sort_by(|(first, a, _), (second, b, _)| (first, a).cmp(&(second, b)));
        Ok(Self { records: records.into_iter().map(|(_, name, record)| (name, record)).collect() })
    }
}

/// Start time of a record; `None` if the record has none.
fn time(record: &Record, path: &Path) -> Result<Option<Timestamp>> {
    if record.time.is_empty() {
        return Ok(None);
    }
    let time = record.time.parse();
    time.map(Some).map_err(|_| {
        let message = "must be a time like 2026-11-22T20:15:30Z (RFC 3339)";
        Error::input(path.display().to_string(), "time", message)
    })
}
