//! Tests that an interrupted bench stops its renders and removes its files.

use std::process::{Command, Stdio};
use std::time::Duration;

use super::*;

/// Sends a signal with the `kill` of the shell. Returns `false` if the process does not exist.
fn kill(signal: &str, pid: &str) -> bool {
    let mut shell = Command::new("sh");
    shell.args(["-c", "kill \"$0\" \"$1\"", signal, pid]).stderr(Stdio::null());
    shell.status().unwrap().success()
}

/// A signal to the bench alone also stops the render that it runs.
#[test]
fn renders_end_with_the_bench() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let sleeper = here.join("sleeper");
    write_program(&sleeper, "#!/bin/sh\necho $$ > pid\nexec sleep 600\n");
    let mut bench = Command::new(env!("CARGO_BIN_EXE_ptfast"))
        .args(["bench", "--quiet", "--scene", "cornell", "--program"])
        .arg(&sleeper)
        .current_dir(here)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let pid = loop {
        assert!(bench.try_wait().unwrap().is_none(), "the bench ended before the signal");
        match fs::read_to_string(here.join("pid")) {
            Ok(pid) if pid.ends_with('\n') => break pid.trim().to_owned(),
            _ => std::thread::sleep(Duration::from_millis(10)),
        }
    };
    assert!(kill("-TERM", &bench.id().to_string()));
    assert_eq!(bench.wait().unwrap().code(), Some(143));
    assert!(!kill("-0", &pid), "the render must have stopped");
}

/// An interrupted bench leaves no file and names the signal.
#[test]
fn an_interrupt_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let endless = ["--blocks", "10000", "--json", "bench.json"];
    let mut child = Command::new(env!("CARGO_BIN_EXE_ptfast"))
        .args([&SMALL[..], &endless].concat())
        .current_dir(here)
        .env("TMPDIR", here)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // Wait until the bench has created its folder.
    let made = |entry: std::io::Result<fs::DirEntry>| {
        entry.unwrap().file_name().to_string_lossy().starts_with("ptfast-bench-")
    };
    while !fs::read_dir(here).unwrap().any(made) {
        assert!(child.try_wait().unwrap().is_none(), "the bench ended before the signal");
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(kill("-TERM", &child.id().to_string()));
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(143), "{}", stderr(&output));
    assert_eq!(stderr(&output), "ptfast: interrupted by SIGTERM\n");
    assert_eq!(fs::read_dir(here).unwrap().count(), 0);
}
