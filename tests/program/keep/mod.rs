//! Tests that continued renders and merged parts give the same bits as uninterrupted renders.

mod goals;
mod merge;
mod resume;
mod signals;

use std::path::Path;

use crate::common::{ptfast, stderr, stdout};

/// Runs the program, checks that it succeeds, and returns the hash that it prints.
#[track_caller]
fn hash(folder: &Path, arguments: &[&str]) -> String {
    let output = ptfast(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    let text = stdout(&output);
    // `--print hash` prints only the hash, and a summary has it in a line.
    let hash = text.lines().find_map(|line| line.strip_prefix("hash ")).unwrap_or(&text).trim();
    assert_eq!(hash.len(), 64, "{arguments:?} printed no hash: {text}");
    hash.to_owned()
}

/// Runs the program, checks that it fails with the exit code, and returns its one-line error.
#[track_caller]
fn refusal(folder: &Path, arguments: &[&str], code: i32) -> String {
    let output = ptfast(folder, arguments);
    let says = stderr(&output);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {says}");
    assert_eq!(says.lines().count(), 1, "{arguments:?}: {says}");
    says
}

/// Concatenates `words` and `more`.
fn with<'a>(words: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    [words, more].concat()
}
