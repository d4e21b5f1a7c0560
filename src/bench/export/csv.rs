//! A table with a line a run: `time,commit,metric...`.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::bench::record::Record;
use crate::error::{Error, Result};
use crate::output::write_atomically;

/// `bench.csv`: Mrays/s. A line is added to those of other runs.
pub(super) fn write(record: &Record, folder: &Path) -> Result<PathBuf> {
    let file = folder.join("bench.csv");
    let mut header = vec!["time".to_owned(), "commit".to_owned()];
    header.extend(record.runs.iter().map(|run| field(&super::name(run))));
    let mut line = vec![field(&record.time), field(&record.machine.commit)];
    line.extend(record.runs.iter().map(|run| run.mrays_per_s.median.to_string()));
    let (header, line) = (header.join(","), line.join(","));

    let before = match fs::read_to_string(&file) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => format!("{header}\n"),
        Err(error) => return Err(Error::io(&file, "read")(error)),
    };
    if before.lines().next() != Some(&header) {
        let message = format!("a line of other columns cannot be added, these are `{header}`");
        return Err(Error::input(file.display().to_string(), "1", message));
    }
    let end = if before.ends_with('\n') { "" } else { "\n" };
    write_atomically(&file, |out| writeln!(out, "{before}{end}{line}"))?;
    Ok(file)
}

/// Quoted where it must be (RFC 4180).
fn field(text: &str) -> String {
    if text.contains(['"', ',', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_quoted_where_they_must_be() {
        assert_eq!(field("spheres/scalar"), "spheres/scalar");
        assert_eq!(field("a,\"b\".ron"), "\"a,\"\"b\"\".ron\"");
    }
}
