//! What the program prints: results on standard output, notices and errors on standard error.

use std::fmt;
use std::io::{self, ErrorKind, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::json;

use crate::error::{Error, Result};
use crate::isa::{Isa, compiled_isa, detected_isa};

/// Longest message in characters. Input files can contain words of any length.
const MAX_MESSAGE: usize = 2000;

/// Prints a line on standard output. Control characters, including line breaks, are escaped, so
/// that the name of a file or scene cannot forge a line of output.
pub(crate) fn say(line: fmt::Arguments<'_>) -> Result<()> {
    print(&escaped(&line.to_string(), |c| c.is_control()))
}

/// Prints text of several lines on standard output. Control characters other than line breaks are escaped.
pub(crate) fn say_lines(text: &str) -> Result<()> {
    print(&escaped(text, |c| c.is_control() && c != '\n'))
}

fn print(text: &str) -> Result<()> {
    let mut stdout = io::stdout().lock();
    match writeln!(stdout, "{text}").and_then(|()| stdout.flush()) {
        // The reader, such as `head`, has seen enough. The command still does its work.
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        written => written.map_err(Error::io(Path::new("standard output"), "write")),
    }
}

/// `text` with escapes for the control characters that `is_escaped` selects.
fn escaped(text: &str, is_escaped: impl Fn(char) -> bool) -> String {
    let mut printable = String::with_capacity(text.len());
    for c in text.chars() {
        match is_escaped(c) {
            true => printable.extend(c.escape_default()),
            false => printable.push(c),
        }
    }
    printable
}

/// The whole message on one line, shortened in the middle if it is longer than [`MAX_MESSAGE`].
pub(crate) fn one_line(text: &str) -> String {
    let count = text.chars().count();
    let cut: String = match count > MAX_MESSAGE {
        true => {
            let start = text.chars().take(MAX_MESSAGE / 2);
            start.chain(" ... ".chars()).chain(text.chars().skip(count - MAX_MESSAGE / 2)).collect()
        }
        false => text.to_owned(),
    };
    escaped(&cut, |c| c.is_control())
}

/// Whether notices are suppressed.
static QUIET: AtomicBool = AtomicBool::new(false);
/// Whether each line on standard error is a JSON object.
static JSON: AtomicBool = AtomicBool::new(false);

/// Suppresses all notices from now on.
pub(crate) fn suppress_notices() {
    QUIET.store(true, Ordering::Relaxed);
}

/// From now on, writes JSON objects to standard error if `on`, plain lines otherwise.
pub(crate) fn write_json(on: bool) {
    JSON.store(on, Ordering::Relaxed);
}

/// Prints a notice on standard error.
pub(crate) fn notice(line: fmt::Arguments<'_>) {
    if !QUIET.load(Ordering::Relaxed) {
        report("notice", &line.to_string(), None);
    }
}

/// Prints the error with which the program ends, and its exit code.
pub(crate) fn complain(message: &str, code: u8) {
    report("error", message, Some(code));
}

fn report(event: &str, message: &str, code: Option<u8>) {
    let mut line = format!("ptfast: {}", one_line(message));
    if JSON.load(Ordering::Relaxed) {
        let mut object = json!({"schema": 1, "event": event, "message": message});
        if let Some(code) = code {
            object["code"] = code.into();
        }
        line = object.to_string();
    }
    // If standard error is closed, nobody can be informed.
    let _ = writeln!(io::stderr(), "{line}");
}

/// Prints a notice if a build for this CPU would be faster. Instruction sets above `best` are not
/// worth a notice for this command.
pub(crate) fn advise_on_build(best: Isa) {
    let (built, available) = (compiled_isa(), detected_isa());
    if built != Isa::Portable && built < available.min(best) {
        notice(format_args!(
            "built for {built} on a CPU with {available}: rebuild for speed with \
             RUSTFLAGS=\"-C target-cpu=native\" cargo build --release"
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_one_printable_line_of_limited_length() {
        assert_eq!(one_line("a\nhash 1\u{1b}[2J é"), "a\\nhash 1\\u{1b}[2J é");
        assert_eq!(one_line(&"x".repeat(MAX_MESSAGE)).len(), MAX_MESSAGE);
        assert_eq!(one_line(&"x".repeat(5 * MAX_MESSAGE)).len(), MAX_MESSAGE + 5);
    }
}
