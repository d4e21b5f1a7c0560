//! A table with a line a run: `time,commit,metric...`.

use std::fs;
use std::io::Write;
use std::path::Path;

use crate::bench::record::Record;
use crate::error::{Error, Result};
use crate::output::write_atomically;

/// Adds a line of Mrays/s to those of other runs.
pub(super) fn write(record: &Record, file: &Path) -> Result<()> {
    let before = before(record.runs.iter().map(|run| super::name_of(&run.work)), file)?;
    let mut line = vec![field(&record.time), field(&record.machine.commit)];
    line.extend(record.runs.iter().map(|run| run.mrays_per_s.median.to_string()));
    let end = if before.ends_with('\n') { "" } else { "\n" };
    write_atomically(file, |out| writeln!(out, "{before}{end}{}", line.join(",")))
}

/// Finds out whether a line of runs of these names fits to what is there.
pub(super) fn check(names: impl Iterator<Item = String>, file: &Path) -> Result<()> {
    before(names, file).map(drop)
}

/// What the file holds, or the line of names where there is none.
fn before(names: impl Iterator<Item = String>, file: &Path) -> Result<String> {
    let mut columns = vec!["time".to_owned(), "commit".to_owned()];
    columns.extend(names.map(|name| field(&name)));
    let columns = columns.join(",");
    let text = match fs::read_to_string(file) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Ok(format!("{columns}\n"));
        }
        Err(error) => return Err(Error::io(file, "read")(error)),
    };
    if text.lines().next() == Some(&columns) {
        return Ok(text);
    }
    let message = format!("a line of other columns cannot be added, these are `{columns}`");
    Err(Error::input(file.display().to_string(), "1", message))
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
