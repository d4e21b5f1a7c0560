//! Helpers that run the program and read its output.

use std::path::Path;
use std::process::{Command, Output};

/// Runs the program in `folder` and waits for it.
pub(crate) fn ptfast(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_ptfast"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the program must start")
}

pub(crate) fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("standard output must be UTF-8")
}

pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("standard error must be UTF-8")
}
