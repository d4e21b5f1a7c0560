//! Faults of the machine while the program runs: a non-zero exit, one line, and nothing half-written.

mod files;
mod threads;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::common::stderr;

const RENDER: &str = "render --scene cornell --width 64 --spp 2 --quiet";

/// Runs a line of the shell in which `$P` is the program.
fn shell(folder: &Path, line: &str) -> Output {
    Command::new("bash")
        .args(["-c", line])
        .env("P", env!("CARGO_BIN_EXE_ptfast"))
        .current_dir(folder)
        .output()
        .unwrap()
}

/// That `line` ends with `code` and one line that holds `says`, and leaves nothing but the files `left`.
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

/// The names of the files in a folder, in order.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}
