//! Tests of renders that are interrupted by signals.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use serde_json::Value;

use super::{hash, with};

/// A render that takes seconds on two cores.
const LONG: [&str; 11] = [
    "render",
    "--scene",
    "cornell",
    "--width",
    "60",
    "--spp",
    "6000",
    "--progress",
    "json",
    "-o",
    "a.pfm",
];

/// A running render and the lines of its progress.
struct Started {
    child: Child,
    lines: std::io::Lines<BufReader<std::process::ChildStderr>>,
}

impl Started {
    fn new(folder: &Path, words: &[&str]) -> Self {
        // Reset SIGHUP, since the process that runs the tests may ignore it.
        let mut child = Command::new("env")
            .args(["--default-signal=HUP", env!("CARGO_BIN_EXE_ptfast")])
            .args(words)
            .current_dir(folder)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stderr.take().unwrap()).lines();
        Self { child, lines }
    }

    /// Waits for an event and returns its line.
    fn wait_for(&mut self, event: &str) -> Value {
        let lines = self.lines.by_ref().map(|line| serde_json::from_str::<Value>(&line.unwrap()));
        let found = lines.flatten().find(|line| line["event"] == event);
        found.unwrap_or_else(|| panic!("the render ended without the event {event}"))
    }

    fn signal(&self, signal: &str) {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).status().unwrap().success());
    }

    /// Waits for the exit. Returns the exit code and the remaining output.
    fn end(mut self) -> (Option<i32>, String) {
        let rest: Vec<String> = self.lines.map(Result::unwrap).collect();
        (self.child.wait().unwrap().code(), rest.join("\n"))
    }
}

/// Interrupts a render by each signal in turn, and continues it.
#[test]
fn signals_keep_the_render() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for (signal, code, name) in
        [("-INT", 130, "SIGINT"), ("-TERM", 143, "SIGTERM"), ("-HUP", 129, "SIGHUP")]
    {
        let mut render = Started::new(here, &LONG);
        render.wait_for("start");
        render.signal(signal);
        let (ended, said) = render.end();
        assert_eq!(ended, Some(code), "{said}");
        let said: Vec<Value> =
            said.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let [.., stopped, error] = &said[..] else { panic!("{said:?}") };
        assert_eq!(
            (&stopped["event"], &stopped["file"]),
            (&"stopped".into(), &"a.partial.film".into())
        );
        assert_eq!((&error["event"], &error["code"]), (&"error".into(), &code.into()));
        let message = error["message"].as_str().unwrap();
        assert!(message.starts_with(&format!("interrupted by {name} after ")), "{message}");
        let kept = "continue from a.partial.film; a.partial.pfm shows the picture so far";
        assert!(message.ends_with(kept), "{message}");
        assert!(here.join("a.partial.pfm").exists() && !here.join("a.pfm").exists());
    }
    assert_eq!(
        fs::read_dir(here).unwrap().count(),
        2,
        "only the checkpoint and the picture may be left"
    );
    let resumed = hash(here, &LONG);
    assert_eq!(fs::read_dir(here).unwrap().count(), 1, "only the image may be left");
    assert_eq!(resumed, hash(here, &with(&LONG[..9], &["-o", "whole.pfm"])));
    assert!(fs::read(here.join("a.pfm")).unwrap() == fs::read(here.join("whole.pfm")).unwrap());
}

/// A second SIGINT does not wait for the checkpoint, which takes a while for this many pixels. The program is stopped
/// while the time passes after which it is another request.
#[test]
fn a_second_interrupt_exits_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let words = "render --scene cornell --width 4000 --spp 4000 --progress json -o a.pfm";
    let mut render = Started::new(here, &words.split(' ').collect::<Vec<_>>());
    render.wait_for("start");
    let twice = "kill -INT $0; sleep 0.02; kill -STOP $0; sleep 0.6; kill -INT $0; kill -CONT $0";
    let id = render.child.id().to_string();
    assert!(Command::new("sh").args(["-c", twice, &id]).status().unwrap().success());
    let (ended, said) = render.end();
    assert_eq!(ended, Some(130), "{said}");
    assert!(!said.contains("interrupted by"), "{said}");
    assert_eq!(fs::read_dir(here).unwrap().count(), 0, "no file may be left");
}

/// Some terminals, and `timeout -s INT`, send SIGINT to a process and to its group: once more within milliseconds.
#[test]
fn an_interrupt_that_is_repeated_at_once_saves() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for pause in ["0", "0.002", "0.2"] {
        let mut render = Started::new(here, &LONG);
        render.wait_for("start");
        let id = render.child.id();
        let twice = format!("kill -INT {id}; sleep {pause}; kill -INT {id} || true");
        assert!(Command::new("sh").args(["-c", &twice]).status().unwrap().success());
        let (ended, said) = render.end();
        assert_eq!(ended, Some(130), "{pause} s: {said}");
        assert!(said.contains("continue from a.partial.film"), "{pause} s: {said}");
    }
    hash(here, &LONG);
}

/// If two renders have the same output, the second must not overwrite the checkpoint of the first.
#[test]
fn checkpoints_of_another_render_are_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let start = |seed| Started::new(here, &with(&LONG, &["--threads", "1", "--seed", seed]));
    let mut renders = ["1", "2"].map(start);
    let _ = renders.each_mut().map(|render| render.wait_for("start"));
    let [first, second] = renders;
    first.signal("-TERM");
    let (code, said) = first.end();
    assert_eq!(code, Some(143), "{said}");
    let film = fs::read(here.join("a.partial.film")).unwrap();
    second.signal("-TERM");
    let (code, said) = second.end();
    assert_eq!(code, Some(143), "{said}");
    let says = "cannot save it: a.partial.film: belongs to a render with seed 1, not 2";
    assert!(said.contains(says), "{said}");
    assert!(fs::read(here.join("a.partial.film")).unwrap() == film);
}

/// A first SIGINT after SIGTERM still saves a checkpoint.
#[test]
fn an_interrupt_after_sigterm_still_saves() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let mut render = Started::new(here, &LONG);
    render.wait_for("start");
    let id = render.child.id();
    let both = format!("kill -TERM {id}; kill -TERM {id}; kill -INT {id}");
    assert!(Command::new("sh").args(["-c", &both]).status().unwrap().success());
    let (ended, said) = render.end();
    assert!(matches!(ended, Some(130 | 143)), "{said}");
    assert!(said.contains("continue from a.partial.film"), "{said}");
    hash(here, &LONG);
}

/// If SIGHUP is ignored at the start, as under nohup, it stays ignored. SIGINT does not, although shells
/// make background jobs ignore it.
#[test]
fn ignored_hangups_stay_ignored() {
    let folder = tempfile::tempdir().unwrap();
    for (signal, spp, code) in [("HUP", 600, 0), ("INT", 6000, 130)] {
        let line = format!(
            "trap '' {signal}; \"$0\" render --scene cornell --width 60 --spp {spp} --progress json \
             -o a.pfm 2>said & until grep -q start said; do sleep 0.01; done; kill -{signal} $!; wait $!"
        );
        let output = Command::new("bash")
            .args(["-c", &line, env!("CARGO_BIN_EXE_ptfast")])
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(code), "{signal}: {output:?}");
        fs::remove_file(folder.path().join("said")).unwrap();
    }
}

/// While the scene loads, there is nothing to save.
#[test]
fn signals_before_the_render_end_it_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let words = "render --scene cloud:3000000 --spp 1 --quiet -o a.png";
    let mut render = Started::new(folder.path(), &words.split(' ').collect::<Vec<_>>());
    // Wait until the program handles SIGTERM: before that, the signal would kill it.
    let status = format!("/proc/{}/status", render.child.id());
    let watches = || {
        let text = fs::read_to_string(&status).unwrap();
        let caught = text.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
        u64::from_str_radix(caught.trim(), 16).unwrap() & 1 << 14 != 0
    };
    while !watches() {
        assert_eq!(
            render.child.try_wait().unwrap(),
            None,
            "the render ended before it handled SIGTERM"
        );
        std::thread::yield_now();
    }
    render.signal("-TERM");
    let (ended, said) = render.end();
    assert_eq!((ended, &*said), (Some(143), ""));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Checkpoints are written at intervals or on request, and a kill loses only later work.
#[test]
fn checkpoints_are_written_on_request_and_at_intervals() {
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
        fs::copy(here.join("kept.film"), here.join("early.film")).unwrap();
        let done = |event: &Value| event["done"].as_u64().unwrap();
        // On a busy machine, the next one may come before any unit is done.
        let later = loop {
            if asks {
                render.signal("-USR1");
            }
            let later = render.wait_for("checkpoint");
            if done(&later) > done(&event) {
                break later;
            }
        };
        assert!(done(&later) < later["total"].as_u64().unwrap(), "{later}");
        render.signal("-KILL");
        assert_eq!(render.end().0, None);
        let resumed = hash(here, &with(&LONG, &["--checkpoint", "kept.film"]));
        assert_eq!(resumed, hash(here, &with(&LONG[..9], &["-o", "whole.pfm"])));
        let again = ["--checkpoint", "early.film", "--checkpoint-every", "1ms"];
        let mut render = Started::new(here, &with(&LONG, &again));
        assert_eq!(render.wait_for("checkpoint")["file"], "early.film");
        render.signal("-KILL");
        render.end();
        fs::remove_file(here.join("kept.film")).unwrap();
        fs::remove_file(here.join("a.pfm")).unwrap();
    }
}
