//! Nothing is lost: renders that are stopped go on to the same bits, and so do their parts.

mod merge;
mod resume;
mod signals;

use std::path::Path;

use crate::common::{ptfast, stderr, stdout};

/// Runs the program, which succeeds, and returns the hash it tells.
#[track_caller]
fn hash(folder: &Path, arguments: &[&str]) -> String {
    let output = ptfast(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    let text = stdout(&output);
    let hash = text.lines().find_map(|line| line.strip_prefix("hash ")).map(str::trim);
    hash.unwrap_or_else(|| panic!("{arguments:?} tells no hash: {text}")).to_owned()
}

/// Runs the program, which fails with the exit code, and returns the one line it says.
#[track_caller]
fn refusal(folder: &Path, arguments: &[&str], code: i32) -> String {
    let output = ptfast(folder, arguments);
    let says = stderr(&output);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {says}");
    assert_eq!(says.lines().count(), 1, "{arguments:?}: {says}");
    says
}

/// `words` and `more`.
fn with<'a>(words: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    [words, more].concat()
}
