//! Exports records as a table with one line per record: `time,commit,metric...`.

use std::fs;
use std::io::Write;
use std::path::Path;

use crate::error::{Error, Result};
use crate::measure::bench::Record;
use crate::output::write_atomically;

/// Appends a line with the Mrays/s of each run to the lines of earlier records.
pub(super) fn write(record: &Record, file: &Path) -> Result<()> {
    let before = before(record.runs.iter().map(|run| super::name_of(&run.work)), file)?;
    let mut line = vec![field(&record.time), field(&record.machine.commit)];
    line.extend(record.runs.iter().map(|run| run.mrays_per_s.median.to_string()));
    let end = if before.ends_with('\n') { "" } else { "\n" };
    write_atomically(file, |out| writeln!(out, "{before}{end}{}", line.join(",")))
}

/// Checks that a line for runs with these names can be appended to `file`.
pub(super) fn check(names: impl Iterator<Item = String>, file: &Path) -> Result<()> {
    before(names, file).map(drop)
}

/// Returns the content of the file, or the line of column names if the file does not exist.
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
    let message = format!("the columns must be `{columns}`, like those of the line to append");
    Err(Error::input(file.display().to_string(), "1", message))
}

/// Quotes a field if necessary (RFC 4180).
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
