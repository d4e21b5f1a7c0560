//! Tests of renders that end by time or noise instead of a number of samples.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::{hash, refusal, with};
use crate::common::{ptfast, stderr};

const SMALL: [&str; 7] = ["render", "cornell", "--width", "40", "--seed", "5", "-o"];

/// Renders with `more` arguments, and returns the hash, the number of samples per pixel, and the record.
fn render(here: &Path, name: &str, more: &[&str]) -> (String, String, Value) {
    let words = with(&with(&SMALL, &[name, "--json", "record.json"]), more);
    let hash = hash(here, &words);
    let record = fs::read_to_string(here.join("record.json")).unwrap();
    let record: Value = serde_json::from_str(&record).unwrap();
    (hash, record["spp"].to_string(), record)
}

/// The image, its metadata and the film are those of a render with `--spp` and the number that the record names.
#[test]
fn goals_give_the_image_of_their_number_of_samples() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for goal in [
        &["--time", "300ms"][..],
        &["--time", "1ms"],
        &["--noise", "20%"],
        &["--noise", "0.1%", "--max-spp", "50"],
        &["--time", "1h", "--noise", "20%", "--transparent"],
    ] {
        let (by_goal, spp, record) = render(here, "a.exr", goal);
        let transparent = goal.contains(&"--transparent");
        let spp_flags = ["--spp", &spp, "--transparent"];
        let flags = &spp_flags[..if transparent { 3 } else { 2 }];
        let (by_number, ..) = render(here, "b.exr", flags);
        assert_eq!(by_goal, by_number, "{goal:?}: {spp} samples");
        assert!(fs::read(here.join("a.exr")).unwrap() == fs::read(here.join("b.exr")).unwrap());
        assert!(!here.join("a.partial.film").exists() && !here.join("a.partial.exr").exists());
        match goal {
            [_, "20%", ..] | [_, _, _, "20%", ..] => {
                assert!(record["noise"].as_f64().unwrap() <= 0.2, "{record}");
            }
            [_, "1ms", ..] => assert_eq!(spp, "1"),
            [_, _, "--max-spp", ..] => assert_eq!(spp, "50"),
            _ => {}
        }
    }
    let (film, spp, _) = render(here, "a.film", &["--noise", "20%"]);
    let merged = hash(here, &["merge", "a.film", "-o", "c.png"]);
    let (by_number, ..) = render(here, "b.film", &["--spp", &spp]);
    assert_eq!([&film, &merged], [&by_number; 2]);
}

/// A film that was kept is continued by a goal, and a goal's film by a larger number of samples.
#[test]
fn goals_continue_and_are_continued() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let keep = ["--checkpoint", "kept.film"];
    render(here, "a.png", &with(&keep, &["--spp", "20"]));
    let (by_goal, spp, _) = render(here, "a.png", &with(&keep, &["--noise", "20%"]));
    assert_eq!(render(here, "b.png", &["--spp", &spp]).0, by_goal);
    let (continued, ..) = render(here, "a.png", &with(&keep, &["--spp", "400"]));
    assert_eq!(render(here, "b.png", &["--spp", "400"]).0, continued);
    // A stopped render ends where an uninterrupted one does.
    let noise = ["--noise", "12%", "--time-limit", "100ms"];
    let words = with(&with(&SMALL, &["c.png"]), &noise);
    let mut runs = (0..1000).map(|_| ptfast(here, &words));
    let last = runs.find(|run| run.status.code() != Some(75)).expect("some run must be the last");
    assert!(last.status.success(), "{}", stderr(&last));
    let (whole, ..) = render(here, "d.png", &["--noise", "12%"]);
    assert_eq!(hash(here, &words[..words.len() - 2]), whole);
    assert!(fs::read(here.join("c.png")).unwrap() == fs::read(here.join("d.png")).unwrap());
}

/// A checkpoint of a goal can be continued by any larger number of samples. One whose pixels have different numbers of
/// samples is first evened out, even if no time is left.
#[test]
fn stopped_goals_become_numbers_and_the_reverse() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    // Several units of work, of which at least one is finished.
    let wide = ["--width", "400", "--time-limit", "1ms"];
    let goal = ["g.png", "--checkpoint", "g.film", "--noise", "0.1%"];
    let words = with(&with(&SMALL[..2], &["--seed", "5", "-o"]), &with(&goal, &wide));
    let says = refusal(here, &words, 75);
    assert!(says.contains(" samples per pixel: run the same command again"), "{says}");
    let number = ["render", "cornell", "--seed", "5", "--width", "400", "--spp", "20", "-o"];
    let continued = hash(here, &with(&number, &["g.png", "--checkpoint", "g.film"]));
    assert_eq!(hash(here, &with(&number, &["h.png"])), continued);

    let stopped = with(&number, &["u.png", "--checkpoint", "u.film", "--time-limit", "1ms"]);
    refusal(here, &stopped, 75);
    let words = ["render", "cornell", "--seed", "5", "--width", "400", "--time", "1ms", "-o"];
    let evened = hash(here, &with(&words, &["u.png", "--checkpoint", "u.film"]));
    let sixteen = ["render", "cornell", "--seed", "5", "--width", "400", "--spp", "16", "-o"];
    assert_eq!(hash(here, &with(&sixteen, &["v.png"])), evened);
}

#[test]
fn missed_goals_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let notices = |more: &[&str]| {
        let output = ptfast(here, &with(&with(&SMALL, &["a.png", "--progress", "none"]), more));
        assert!(output.status.success(), "{}", stderr(&output));
        stderr(&output)
    };
    let late = notices(&["--time", "1ms"]);
    assert!(late.contains("--time 0.001 s: the scene needs longer"), "{late}");
    let noisy = notices(&["--noise", "0.1%", "--max-spp", "50"]);
    let says = "--noise 0.100%: after 50 samples per pixel, the relative error is ";
    assert!(noisy.contains(says) && noisy.contains("%; --max-spp allows more"), "{noisy}");
    let reached = notices(&["--noise", "50%"]);
    assert!(!reached.contains("--max-spp") && reached.contains("--denoise"), "{reached}");
    assert_eq!(notices(&["--noise", "50%", "--denoise"]), "");
}

#[test]
fn goals_have_no_number_of_samples_and_no_parts() {
    let here = tempfile::tempdir().unwrap();
    for (words, says) in [
        (&["--time", "5s", "--spp", "4"][..], "--spp"),
        (&["--noise", "5%", "--shard", "0/2"], "--shard"),
        (&["--noise", "5%", "--sample-range", "0..16"], "--sample-range"),
        (&["--time", "5s", "--skip-complete"], "--skip-complete"),
        (&["--max-spp", "100"], "--max-spp is for renders with --time or --noise"),
        (&["--time", "0s"], "a time such as 90s"),
        (&["--time", "-1s"], "a time such as 90s"),
        (&["--noise", "2"], "must be a percentage such as 2%"),
    ] {
        let output = ptfast(here.path(), &with(&with(&SMALL, &["a.png"]), words));
        assert_eq!(output.status.code(), Some(2), "{words:?}");
        assert!(stderr(&output).contains(says), "{words:?}: {}", stderr(&output));
    }
}
