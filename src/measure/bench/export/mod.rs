//! Exports records in the formats of other programs.

mod bmf;
mod criterion;
mod csv;
mod gha;

use std::fs;
use std::path::{Path, PathBuf};

use super::{Record, Workload};
use crate::engine::Engine;
use crate::error::{Error, Result};
use crate::output::{check_folder, check_writable};

/// A format that another program reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    /// Criterion's folders, as critcmp reads them.
    Criterion,
    /// `customBiggerIsBetter` of github-action-benchmark.
    Gha,
    /// The Bencher Metric Format.
    Bmf,
    /// A table with one line per record, as Apache Otava reads it.
    Csv,
}

names! { pub(crate) Format: Criterion = "criterion", Gha = "gha", Bmf = "bmf", Csv = "csv" }

/// Path of the file that [`export`] writes in `folder`, or of the folder for several files.
pub(crate) fn export_file(format: Format, folder: &Path) -> PathBuf {
    folder.join(match format {
        Format::Criterion => "criterion",
        Format::Gha => "benchmark.json",
        Format::Bmf => "bmf.json",
        Format::Csv => "bench.csv",
    })
}

/// Checks that a record of `runs`, given by scene, engine and number of threads, can be exported into
/// `folder`.
///
/// # Errors
/// If [`export`] would fail, as far as that is known in advance.
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

/// Writes `record` into `folder`, which is created if missing. Results of other records are kept if the
/// format can hold several.
///
/// # Errors
/// If a file cannot be written, or an existing file does not have the expected format.
pub(crate) fn export(record: &Record, format: Format, folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).map_err(Error::io(folder, "create the folder"))?;
    let file = export_file(format, folder);
    match format {
        Format::Criterion => criterion::write(record, &file),
        Format::Gha => gha::write(record, &file),
        Format::Bmf => bmf::write(record, &file),
        Format::Csv => csv::write(record, &file),
    }
}

/// Name of a run, such as `spheres/wavefront`, with the number of threads appended unless it is 1.
fn name(scene: &str, engine: &str, threads: usize) -> String {
    match threads {
        1 => format!("{scene}/{engine}"),
        _ => format!("{scene}/{engine}/{threads}"),
    }
}

fn name_of(Workload { scene, engine, threads, .. }: &Workload) -> String {
    name(scene, engine, *threads)
}
