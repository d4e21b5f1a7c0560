//! Tests of machine faults while the program runs.
//!
//! The program must exit with an error code, print one line and leave no partial file.

mod files;
mod threads;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::common::stderr;

const RENDER: &str = "render --scene cornell --width 64 --spp 2 --quiet";

/// Runs a shell command in `folder`, with the path of the program in `$P`.
fn shell(folder: &Path, line: &str) -> Output {
    Command::new("bash")
        .args(["-c", line])
        .env("P", env!("CARGO_BIN_EXE_ptfast"))
        .current_dir(folder)
        .output()
        .unwrap()
}

/// Checks that the command `line` exits with `code`, prints one line that contains `says`, and leaves
/// exactly the files `left`.
#[track_caller]
fn fails(line: &str, code: i32, says: &str, left: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let output = shell(folder.path(), line);
    let message = stderr(&output);
    println!("{code:>4} {}   # {line}", message.trim_end());
    assert_eq!(output.status.code(), Some(code), "{line}: {message}");
    assert_eq!(message.lines().count(), 1, "{line}: {message}");
    assert!(message.starts_with("ptfast: ") && message.contains(says), "{line}: {message}");
    assert_eq!(names(folder.path()), left, "{line}");
}

/// The names of the files in a folder, sorted.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}
