//! Records in the formats of other programs.

mod bmf;
mod criterion;
mod csv;
mod gha;

use std::fs;
use std::path::{Path, PathBuf};

use super::record::{Record, Run};
use crate::error::{Error, Result};

/// A format that another program reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// The folders of criterion, as critcmp reads them.
    Criterion,
    /// `customBiggerIsBetter` of github-action-benchmark.
    Gha,
    /// The Bencher Metric Format.
    Bmf,
    /// A line a run, as Apache Otava reads it.
    Csv,
}

impl Format {
    /// All formats.
    pub(crate) const ALL: [Self; 4] = [Self::Criterion, Self::Gha, Self::Bmf, Self::Csv];

    /// The name on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Criterion => "criterion",
            Self::Gha => "gha",
            Self::Bmf => "bmf",
            Self::Csv => "csv",
        }
    }
}

/// Writes `record` into `folder`, which is made if missing. What of other runs is there stays, where
/// the format has room for it. The file, or the folder of several.
///
/// # Errors
/// Where that cannot be written, or a file of other runs is none of this format.
pub(crate) fn export(record: &Record, format: Format, folder: &Path) -> Result<PathBuf> {
    fs::create_dir_all(folder).map_err(Error::io(folder, "make the folder"))?;
    match format {
        Format::Criterion => criterion::write(record, folder),
        Format::Gha => gha::write(record, folder),
        Format::Bmf => bmf::write(record, folder),
        Format::Csv => csv::write(record, folder),
    }
}

/// `spheres/wavefront`, and the number of threads where that is not one.
fn name(run: &Run) -> String {
    match run.threads {
        1 => format!("{}/{}", run.scene, run.engine),
        threads => format!("{}/{}/{threads}", run.scene, run.engine),
    }
}
