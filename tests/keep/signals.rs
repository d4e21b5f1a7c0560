//! Renders that are interrupted.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use serde_json::Value;

use super::{hash, with};

/// Seconds on two cores.
const LONG: [&str; 11] = [
    "render",
    "--scene",
    "cornell",
    "--width",
    "60",
    "--spp",
    "4000",
    "--progress",
    "json",
    "-o",
    "a.pfm",
];

/// A render, and the lines of its progress.
struct Started {
    child: Child,
    lines: std::io::Lines<BufReader<std::process::ChildStderr>>,
}

impl Started {
    fn new(folder: &Path, words: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_ptfast"))
            .args(words)
            .current_dir(folder)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stderr.take().unwrap()).lines();
        Self { child, lines }
    }

    /// Waits for an event, and returns its line.
    fn wait_for(&mut self, event: &str) -> Value {
        let lines = self.lines.by_ref().map(|line| serde_json::from_str::<Value>(&line.unwrap()));
        let found = lines.flatten().find(|line| line["event"] == event);
        found.unwrap_or_else(|| panic!("there is no {event}"))
    }

    fn signal(&self, signal: &str) {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).status().unwrap().success());
    }

    /// Its exit code, and what else it said.
    fn end(mut self) -> (Option<i32>, String) {
        let rest: Vec<String> = self.lines.map(Result::unwrap).collect();
        (self.child.wait().unwrap().code(), rest.join("\n"))
    }
}

/// By either signal, twice one after the other, and continued.
#[test]
fn signals_keep_the_render() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let mut resume = Vec::new();
    for (signal, code, name) in [("-INT", 130, "SIGINT"), ("-TERM", 143, "SIGTERM")] {
        let mut render = Started::new(here, &with(&LONG, &resume));
        render.wait_for("start");
        render.signal(signal);
        let (ended, said) = render.end();
        assert_eq!(ended, Some(code), "{said}");
        assert!(said.contains(&format!("ptfast: interrupted by {name} after ")), "{said}");
        assert!(
            said.contains("go on with --resume a.partial.film, a.partial.pfm shows it"),
            "{said}"
        );
        assert!(here.join("a.partial.pfm").exists() && !here.join("a.pfm").exists());
        resume = vec!["--resume", "a.partial.film"];
    }
    assert_eq!(fs::read_dir(here).unwrap().count(), 2, "nothing else is left");
    let resumed = hash(here, &with(&LONG, &resume));
    assert_eq!(resumed, hash(here, &with(&LONG[..9], &["-o", "whole.pfm"])));
    assert!(fs::read(here.join("a.pfm")).unwrap() == fs::read(here.join("whole.pfm")).unwrap());
}

/// A second SIGINT does not wait for a checkpoint, which takes a while for so many pixels.
#[test]
fn a_second_interrupt_leaves_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let words = "render --scene cornell --width 3000 --spp 4000 --progress json -o a.pfm";
    let mut render = Started::new(here, &words.split(' ').collect::<Vec<_>>());
    render.wait_for("start");
    let id = render.child.id();
    // Not both at once: they would be one.
    let twice = format!("kill -INT {id}; sleep 0.01; kill -INT {id}");
    assert!(Command::new("sh").args(["-c", &twice]).status().unwrap().success());
    let (ended, said) = render.end();
    assert_eq!(ended, Some(130), "{said}");
    assert!(!said.contains("interrupted by"), "{said}");
    assert_eq!(fs::read_dir(here).unwrap().count(), 0, "nothing is kept, and nothing half-written");
}

/// A checkpoint where one asks for it, and the render goes on; a kill then loses no more than what came later.
#[test]
fn checkpoints_are_made_on_request_and_now_and_then() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for (more, asks) in [(&["--checkpoint-every", "1ms"][..], false), (&[], true)] {
        let mut render =
            Started::new(here, &with(&with(&LONG, &["--checkpoint", "kept.film"]), more));
        render.wait_for("start");
        if asks {
            render.signal("-USR1");
        }
        let event = render.wait_for("checkpoint");
        assert_eq!(event["file"], "kept.film");
        assert!(event["done"].as_u64() < event["total"].as_u64());
        render.signal("-KILL");
        assert_eq!(render.end().0, None);
        let resumed = hash(here, &with(&LONG, &["--resume", "kept.film"]));
        assert_eq!(resumed, hash(here, &with(&LONG[..9], &["-o", "whole.pfm"])));
        // What is kept is not begun anew.
        fs::remove_file(here.join("kept.film")).unwrap();
        fs::remove_file(here.join("a.pfm")).unwrap();
    }
}
