//! Records in the formats of other programs.

mod bmf;
mod criterion;
mod csv;
mod gha;

use std::fs;
use std::path::{Path, PathBuf};

use super::record::Record;
use super::run::Workload;
use crate::engine::Engine;
use crate::error::{Error, Result};
use crate::output::{check_folder, check_writable};

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

/// What [`export`] writes in `folder`: a file, or the folder of several.
pub(crate) fn export_file(format: Format, folder: &Path) -> PathBuf {
    folder.join(match format {
        Format::Criterion => "criterion",
        Format::Gha => "benchmark.json",
        Format::Bmf => "bmf.json",
        Format::Csv => "bench.csv",
    })
}

/// Finds out whether a record of these `runs`, scene, engine and threads told, can be exported into
/// `folder`.
///
/// # Errors
/// Where it cannot: what [`export`] says, as far as that is known before.
pub(crate) fn check_export(
    runs: &[(&str, Engine, usize)],
    format: Format,
    folder: &Path,
) -> Result<()> {
    check_folder(folder)?;
    let file = export_file(format, folder);
    if format == Format::Criterion {
        check_folder(&file)?;
    } else if folder.is_dir() {
        check_writable(&file)?;
    }
    match format {
        Format::Csv => {
            let names =
                runs.iter().map(|&(scene, engine, threads)| name(scene, engine.name(), threads));
            csv::check(names, &file)
        }
        Format::Criterion | Format::Gha | Format::Bmf => Ok(()),
    }
}

/// Writes `record` into `folder`, which is made if missing. What of other runs is there stays, where
/// the format has room for it.
///
/// # Errors
/// Where that cannot be written, or a file of other runs is none of this format.
pub(crate) fn export(record: &Record, format: Format, folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).map_err(Error::io(folder, "make the folder"))?;
    let file = export_file(format, folder);
    match format {
        Format::Criterion => criterion::write(record, &file),
        Format::Gha => gha::write(record, &file),
        Format::Bmf => bmf::write(record, &file),
        Format::Csv => csv::write(record, &file),
    }
}

/// `spheres/wavefront`, and the number of threads where that is not one.
fn name(scene: &str, engine: &str, threads: usize) -> String {
    match threads {
        1 => format!("{scene}/{engine}"),
        _ => format!("{scene}/{engine}/{threads}"),
    }
}

fn name_of(Workload { scene, engine, threads, .. }: &Workload) -> String {
    name(scene, engine, *threads)
}
