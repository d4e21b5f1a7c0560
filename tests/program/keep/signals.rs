//! Renders that are interrupted.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use ptfast::Limits;
use ptfast::internals::Checkpoint;
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
    "6000",
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
        // Whoever runs the tests may ignore hangups.
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

/// By each signal, one after the other, and continued.
#[test]
fn signals_keep_the_render() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let mut resume = Vec::new();
    for (signal, code, name) in
        [("-INT", 130, "SIGINT"), ("-TERM", 143, "SIGTERM"), ("-HUP", 129, "SIGHUP")]
    {
        let mut render = Started::new(here, &with(&LONG, &resume));
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
        let kept = "go on with --resume a.partial.film, a.partial.pfm shows it";
        assert!(message.ends_with(kept), "{message}");
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

/// Two that would be kept by the same names, as scripts and schedulers stop them.
#[test]
fn renders_stopped_together_are_kept_apart() {
    for _ in 0..4 {
        let folder = tempfile::tempdir().unwrap();
        let here = folder.path();
        let seeds = ["1", "2"];
        let start = |seed| Started::new(here, &with(&LONG, &["--threads", "1", "--seed", seed]));
        let mut renders = seeds.map(start);
        let _ = renders.each_mut().map(|render| render.wait_for("start"));
        let ids = renders.each_ref().map(|render| render.child.id().to_string());
        assert!(Command::new("kill").arg("-TERM").args(&ids).status().unwrap().success());
        let files = renders.each_mut().map(|render| render.wait_for("stopped")["file"].clone());
        let ended = renders.map(|render| render.end().0);
        assert_eq!(ended, [Some(143); 2]);
        for (seed, file) in seeds.into_iter().zip(files) {
            let film = here.join(file.as_str().unwrap());
            let kept = Checkpoint::read(&film, &Limits::default()).unwrap();
            assert_eq!(kept.identity.seed.to_string(), seed, "{}", film.display());
        }
        assert_eq!(fs::read_dir(here).unwrap().count(), 4, "two films and two images");
    }
}

/// An interrupt after another signal is the first of its kind.
#[test]
fn other_signals_do_not_insist() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let mut render = Started::new(here, &LONG);
    render.wait_for("start");
    let id = render.child.id();
    let both = format!("kill -TERM {id}; kill -TERM {id}; kill -INT {id}");
    assert!(Command::new("sh").args(["-c", &both]).status().unwrap().success());
    let (ended, said) = render.end();
    assert!(matches!(ended, Some(130 | 143)), "{said}");
    assert!(said.contains("go on with --resume a.partial.film"), "{said}");
    hash(here, &with(&LONG, &["--resume", "a.partial.film"]));
}

/// Those that nohup ignores; but not those that a shell ignores for what runs in the background.
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

/// While the scene is read there is nothing to be kept.
#[test]
fn signals_before_the_render_end_it_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let words = "render --scene cloud:3000000 --spp 1 --quiet -o a.png";
    let mut render = Started::new(folder.path(), &words.split(' ').collect::<Vec<_>>());
    // Not before it watches: then the signal itself would end it.
    let status = format!("/proc/{}/status", render.child.id());
    let watches = || {
        let text = fs::read_to_string(&status).unwrap();
        let caught = text.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
        u64::from_str_radix(caught.trim(), 16).unwrap() & 1 << 14 != 0
    };
    while !watches() {
        assert_eq!(render.child.try_wait().unwrap(), None, "it ended before");
        std::thread::yield_now();
    }
    render.signal("-TERM");
    let (ended, said) = render.end();
    assert_eq!((ended, &*said), (Some(143), ""));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
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
        fs::copy(here.join("kept.film"), here.join("early.film")).unwrap();
        if asks {
            render.signal("-USR1");
        }
        let later = render.wait_for("checkpoint");
        let done = [&event, &later].map(|event| event["done"].as_u64().unwrap());
        assert!(done[0] < done[1] && done[1] < event["total"].as_u64().unwrap(), "{done:?}");
        render.signal("-KILL");
        assert_eq!(render.end().0, None);
        let resumed = hash(here, &with(&LONG, &["--resume", "kept.film"]));
        assert_eq!(resumed, hash(here, &with(&LONG[..9], &["-o", "whole.pfm"])));
        let again = ["--resume", "early.film", "--checkpoint-every", "1ms"];
        let mut render = Started::new(here, &with(&LONG, &again));
        assert_eq!(render.wait_for("checkpoint")["file"], "early.film");
        render.signal("-KILL");
        render.end();
        // What is kept is not begun anew.
        fs::remove_file(here.join("kept.film")).unwrap();
        fs::remove_file(here.join("a.pfm")).unwrap();
    }
}
