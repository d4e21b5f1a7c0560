//! A folder of bench records, one JSON a run.

use std::fs;
use std::path::Path;

use crate::bench::Record;
use crate::error::{Error, Result};

/// Records in the order of time.
#[derive(Debug)]
pub(crate) struct History {
    /// With the names of their files.
    pub(crate) records: Vec<(String, Record)>,
}

impl History {
    /// All `.json` files of `folder`.
    ///
    /// # Errors
    /// Where one of them, or the folder, cannot be read or is no record of a bench.
    pub(crate) fn read(folder: &Path) -> Result<Self> {
        let mut records = Vec::new();
        for entry in fs::read_dir(folder).map_err(Error::io(folder, "read"))? {
            let path = entry.map_err(Error::io(folder, "read"))?.path();
            if path.extension().is_some_and(|extension| extension == "json") {
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                records.push((name, Record::read(&path)?));
            }
        }
        if records.is_empty() {
            let message = "no record is there: `ptfast bench --json FILE` writes one";
            return Err(Error::input(folder.display().to_string(), "", message));
        }
        // RFC 3339 in UTC sorts as text; records of one second by their names.
        records.sort_by(|(a, first), (b, second)| (&first.time, a).cmp(&(&second.time, b)));
        Ok(Self { records })
    }
}
