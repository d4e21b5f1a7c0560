//! Stopped and continued: the same bits, whatever continues.

use std::fs;
use std::sync::atomic::{AtomicU64, Ordering};

use ptfast::internals::{Checkpoint, Identity, Stream};
use ptfast::{
    Engine, Limits, Observer, Progress, RenderSettings, Renderer, Rendering, Scene, Stop,
};
use serde_json::Value;

use super::{hash, refusal, with};
use crate::common::{ptfast, stderr};

/// Stops a render when it was asked so many times whether it is to go on.
struct Patience {
    left: AtomicU64,
    stop: Stop,
}

impl Observer for Patience {
    fn progressed(&self, _: Progress) {}

    fn stop(&self) -> Stop {
        let left = self
            .left
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1));
        if left.is_ok() { Stop::No } else { self.stop }
    }
}

/// At random moments, by files, by other engines, threads, and waves; some work is thrown away.
#[test]
fn renders_go_on_where_they_were_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.film");
    let mut random = Stream::new(6);
    for (name, spp) in [("tests/data/everything.ron", 50), ("cornell", 100), ("spheres", 33)] {
        let scene = Scene::load(name).unwrap();
        let base = RenderSettings { width: 43, height: 29, spp, ..RenderSettings::of(&scene) };
        let whole = Renderer::new(&scene, base.clone()).unwrap().render().unwrap();
        let identity = Identity::new(&scene, &base, base.image());
        for _ in 0..4 {
            let mut rendering = Renderer::new(&scene, base.clone()).unwrap().begin().unwrap();
            let mut stops = 0;
            loop {
                let mut below = |end: u64| random.bits() % end;
                let settings = RenderSettings {
                    engine: Engine::ALL[below(2) as usize],
                    threads: 1 + below(3) as u32,
                    wave_size: 1 + below(3000) as u32,
                    ..base.clone()
                };
                let stop = [Stop::Soon, Stop::Now][below(2) as usize];
                let patience = Patience { left: AtomicU64::new(below(60)), stop };
                let renderer = Renderer::new(&scene, settings).unwrap();
                renderer.advance(&mut rendering, &patience).unwrap();
                let Rendering { film, .. } = &rendering;
                if film.samples_done() == film.samples_to_do() {
                    break;
                }
                stops += 1;
                let scene = scene.name().to_owned();
                let kept = Checkpoint { scene, identity: identity.clone(), shard: None, rendering };
                kept.write(&file).unwrap();
                let kept = Checkpoint::read(&file, &Limits::default()).unwrap();
                rendering = kept.resume("a.film", &identity, None, 0..spp).unwrap();
            }
            assert!(stops > 0, "{name}: it was never stopped");
            let render =
                Renderer::new(&scene, base.clone()).unwrap().finish(&mut rendering).unwrap();
            assert_eq!(render.image.hash(), whole.image.hash(), "{name}");
            assert_eq!(render.tally, whole.tally, "{name}");
        }
    }
}

const SMALL: [&str; 9] =
    ["render", "--scene", "cornell", "--width", "24", "--seed", "5", "--quiet", "-o"];

/// From finished renders to more samples, with and without a last chunk that is not complete.
#[test]
fn samples_may_grow() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for (few, many) in [("16", "48"), ("20", "50"), ("33", "34"), ("7", "100")] {
        let whole = hash(here, &with(&SMALL, &["whole.pfm", "--spp", many]));
        hash(here, &with(&SMALL, &["a.film", "--spp", few]));
        let first = fs::read(here.join("a.film")).unwrap();
        let more = ["more.pfm", "--spp", many, "--resume", "a.film"];
        assert_eq!(hash(here, &with(&SMALL, &more)), whole, "{few} to {many}");
        let bytes = |name: &str| fs::read(here.join(name)).unwrap();
        assert!(bytes("more.pfm") == bytes("whole.pfm"));
        // What was traced is counted once, too.
        hash(here, &with(&SMALL, &["whole.film", "--spp", many]));
        hash(here, &with(&SMALL, &["more.film", "--spp", many, "--resume", "a.film"]));
        let tallies = ["more.film", "whole.film"].map(|name| {
            Checkpoint::read(&here.join(name), &Limits::default()).unwrap().rendering.tally
        });
        assert_eq!(tallies[0], tallies[1], "{few} to {many}");
        // It may be a part that is to be merged.
        assert!(fs::read(here.join("a.film")).unwrap() == first, "{few} to {many}");
    }
}

/// A film of fewer samples is replaced by one of more where the user names it for both.
#[test]
fn what_is_resumed_for_more_samples_stays() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    hash(here, &with(&SMALL, &["a.film", "--spp", "50"]));
    let first = fs::read(here.join("a.film")).unwrap();
    let more = |words: &[&'static str]| {
        let whole = with(&SMALL, &["b.pfm", "--spp", "100", "--resume", "a.film"]);
        with(&whole, words)
    };
    let stopped = ["--time-limit", "1ms"];
    let says = refusal(here, &more(&stopped), 75);
    assert!(says.contains("--resume b.partial.film, b.partial.pfm shows it"), "{says}");
    let says = refusal(here, &more(&["--checkpoint-every", "1s"]), 2);
    assert!(says.contains("--checkpoint must name a file"), "{says}");
    // Nothing is to be done, and nothing is written but the image.
    hash(here, &with(&SMALL, &["c.pfm", "--spp", "50", "--resume", "a.film"]));
    assert!(fs::read(here.join("a.film")).unwrap() == first);
    let says = refusal(here, &more(&[&stopped[..], &["--checkpoint", "a.film"]].concat()), 75);
    assert!(says.contains("--resume a.film, b.partial.2.pfm shows it"), "{says}");
    assert!(fs::read(here.join("a.film")).unwrap() != first);
}

/// What is kept is replaced by what has as much of the same render, and by nothing else.
#[test]
fn what_is_kept_is_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let whole = hash(here, &with(&SMALL, &["kept.film", "--spp", "40"]));
    let kept = |spp, more: &[&'static str]| {
        with(&with(&SMALL, &["a.pfm", "--checkpoint", "kept.film", "--spp", spp]), more)
    };
    let says = refusal(here, &kept("40", &[]), 2);
    assert!(says.contains("kept.film has 100% of this render: go on with --resume"), "{says}");
    assert_eq!(hash(here, &kept("40", &["--resume", "kept.film"])), whole);
    fs::remove_file(here.join("a.pfm")).unwrap();
    let stopped = with(&SMALL, &["b.pfm", "--spp", "50", "--time-limit", "1ms"]);
    refusal(here, &[&stopped[..], &["--checkpoint", "part.film"]].concat(), 75);
    for (name, content, spp, more, says) in [
        ("kept.film", None, "50", &[][..], "kept.film is of another render: name another file"),
        ("kept.film", None, "50", &["--resume", "part.film"], "kept.film is of another render"),
        ("kept.film", Some("my notes"), "40", &[], "kept.film: not a checkpoint of ptfast: name"),
        ("kept.film", Some("ptfast film\n{}\n"), "40", &[], "kept.film: damaged"),
    ] {
        if let Some(content) = content {
            fs::write(here.join(name), content).unwrap();
        }
        let before = fs::read(here.join(name)).unwrap();
        let refused = refusal(here, &kept(spp, more), 2);
        assert!(refused.contains(says), "{refused}");
        assert!(fs::read(here.join(name)).unwrap() == before && !here.join("a.pfm").exists());
    }
    fs::rename(here.join("part.film"), here.join("kept.film")).unwrap();
    let says = refusal(here, &kept("50", &[]), 2);
    assert!(says.contains("% of this render: go on with --resume kept.film, or remove"), "{says}");
    let nowhere = with(&SMALL, &["c.pfm", "--checkpoint-every", "1s"]);
    assert!(refusal(here, &nowhere, 2).contains("--checkpoint must name a file"));
    let target = with(&SMALL, &["c.film", "--spp", "40", "--checkpoint", "c.film"]);
    assert!(refusal(here, &target, 2).contains("need two files"));
}

/// What is stopped without a checkpoint takes a name that is free.
#[test]
fn partial_files_are_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let image = |depth, more: &[&'static str]| {
        with(&with(&SMALL, &["a.pfm", "--spp", "40", "--depth", depth]), more)
    };
    for (depth, partial) in [("1", "a.partial"), ("2", "a.partial.2")] {
        let says = refusal(here, &image(depth, &["--time-limit", "1ms"]), 75);
        let kept = format!("--resume {partial}.film, {partial}.pfm shows it");
        assert!(says.contains(&kept), "{says}");
    }
    assert_eq!(fs::read_dir(here).unwrap().count(), 4);
    let second = fs::read(here.join("a.partial.2.film")).unwrap();
    let seldom = ["--resume", "a.partial.2.film", "--checkpoint-every", "100h"];
    let resumed = hash(here, &image("2", &seldom));
    assert_eq!(resumed, hash(here, &image("2", &[])));
    assert!(fs::read(here.join("a.partial.2.film")).unwrap() == second, "not in the end");
    let first = hash(here, &image("1", &["--resume", "a.partial.film"]));
    assert_eq!(first, hash(here, &image("1", &[])));
    assert_eq!(fs::read_dir(here).unwrap().count(), 5);
}

/// Of another scene, seed or setting.
#[test]
fn other_renders_are_not_continued() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    hash(here, &with(&SMALL, &["a.film", "--spp", "40"]));
    for (more, field) in [
        (&["--spp", "32"][..], "spp 40, not 32"),
        (&["--spp", "40", "--seed", "6"], "seed 5, not 6"),
        (&["--spp", "40", "--width", "25"], "width 24, not 25"),
        (&["--spp", "40", "--depth", "7"], "depth "),
        (&["--spp", "40", "--sampling", "bsdf"], "sampling \"mis\", not \"bsdf\""),
        (&["--spp", "40", "--sampler", "independent"], "sampler "),
        (&["--spp", "40", "--roulette", "off"], "roulette true, not false"),
        (&["--spp", "40", "--clamp", "2"], "clamp null, not 2"),
        (&["--spp", "40", "--scene", "checker"], "scene_hash "),
        (&["--spp", "40", "--crop", "0,0,9,9"], "crop [0,0,24,24], not [0,0,9,9]"),
        (&["--spp", "40", "--shard", "0/2", "-o", "c.film"], "all shards, not of shard 0/2"),
        (&["--spp", "40", "--sample-range", "0..16", "-o", "c.film"], "samples 0..40, not 0..16"),
    ] {
        // The last of two counts.
        let mut words = with(&["render", "--resume", "a.film", "--quiet"], more);
        for pair in [["--scene", "cornell"], ["--width", "24"], ["--seed", "5"], ["-o", "b.pfm"]] {
            if !more.contains(&pair[0]) {
                words.extend(pair);
            }
        }
        let says = refusal(here, &words, 65);
        assert!(says.contains("a.film: ") && says.contains(field), "{field}: {says}");
    }
    assert!(!here.join("b.pfm").exists() && !here.join("c.film").exists());
}

/// Torn, edited, of another version or something else.
#[test]
fn damaged_checkpoints_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    hash(here, &with(&SMALL, &["a.film", "--spp", "40"]));
    let good = fs::read(here.join("a.film")).unwrap();
    let mut random = Stream::new(2);
    let refused = |bytes: &[u8], what: &str| {
        fs::write(here.join("bad.film"), bytes).unwrap();
        let words = with(&SMALL, &["b.pfm", "--spp", "40", "--resume", "bad.film"]);
        let says = refusal(here, &words, 65);
        assert!(says.contains("bad.film: ") && says.contains(what), "{what}: {says}");
    };
    for length in [0, 5, 12, 13, 100, good.len() - 33, good.len() - 1] {
        let what = if length < 12 { "not a checkpoint" } else { "damaged" };
        refused(&good[..length], what);
    }
    for _ in 0..20 {
        let mut edited = good.clone();
        let place = (12 + random.bits() % (good.len() as u64 - 12)) as usize;
        edited[place] ^= 1 << (random.bits() % 8);
        refused(&edited, "damaged");
    }
    refused(&[&good[..], b"x"].concat(), "damaged");
    refused(b"something else", "not a checkpoint");
    // With a hash that is right.
    let hashed = |mut bytes: Vec<u8>| {
        let hash = blake3::hash(&bytes);
        bytes.extend(hash.as_bytes());
        bytes
    };
    let text = |from: &str, to: &str| {
        let end = good.len() - 32;
        let line = good[12..].iter().position(|&byte| byte == b'\n').unwrap() + 12;
        let header = std::str::from_utf8(&good[..line]).unwrap();
        assert!(header.contains(from), "{header}");
        let mut bytes = header.replace(from, to).into_bytes();
        bytes.extend(&good[line..end]);
        hashed(bytes)
    };
    let sums = &good[..good.len() - 36];
    refused(&hashed([sums, &f32::NAN.to_le_bytes()].concat()), "a sum of samples is not a number");
    refused(&text("\"clamped\":0", "\"clamped\":18446744073709551615"), "the counts are none");
    refused(&text("\"seconds\":", "\"seconds\":-"), "the seconds are none");
    refused(&text("\"schema\":2", "\"schema\":1"), "version 1 of checkpoints is not known");
    refused(&text("\"schema\":2", "\"shemca\":1"), "version null");
    refused(&text("\"roulette\":true", "\"wealth\":true"), "header: unknown field");
    refused(&text("\"width\":24", "\"width\":25000000"), "width must be");
    refused(&text("\"width\":24", "\"width\":23"), "the crop is not within");
    refused(&text("[0,0,24,24]", "[0,0,24,20]"), "damaged");
    refused(&text("\"samples\":[0,40]", "\"samples\":[0,30]"), "a pixel's samples end at 40");
    refused(&text("\"samples\":[0,40]", "\"samples\":[1,40]"), "cannot be of 40");
    refused(&text("\"shard\":null", "\"shard\":{\"index\":4,\"count\":4}"), "the shard");
    let elsewhere = with(&SMALL, &["b.pfm", "--spp", "40", "--resume", "none.film"]);
    assert!(refusal(here, &elsewhere, 74).contains("none.film: cannot read"));
    assert!(!here.join("b.pfm").exists());
}

/// A limit of time ends a render with its own code; where it went on, the image is the same.
#[test]
fn limits_of_time_end_a_render() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    // After the first work that is done, whatever the machine.
    let limited = with(&SMALL, &["a.pfm", "--spp", "40", "--time-limit", "1ms"]);
    let says = refusal(here, &limited, 75);
    assert!(says.contains("stopped by the time limit after"), "{says}");
    assert!(says.contains("go on with --resume a.partial.film, a.partial.pfm shows it"), "{says}");
    assert!(!here.join("a.pfm").exists() && here.join("a.partial.pfm").exists());
    let whole = hash(here, &with(&SMALL, &["whole.pfm", "--spp", "40"]));
    // Each run does something, however short: in the end it is done.
    let again = [&limited[..], &["--resume", "a.partial.film"]].concat();
    let mut runs = (0..1000).map(|_| ptfast(here, &again));
    let last = runs.find(|run| run.status.code() != Some(75)).expect("it ends");
    assert!(last.status.success(), "{last:?}");
    let bytes = |name: &str| fs::read(here.join(name)).unwrap();
    assert!(bytes("a.pfm") == bytes("whole.pfm") && whole.len() == 64);
}

/// What is complete is not rendered again, unless it is of something else.
#[test]
fn complete_files_are_skipped() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for name in ["a.png", "a.exr", "a.film"] {
        let skips = |more: &[&str]| {
            let words = with(&with(&SMALL, &[name, "--skip-complete"]), more);
            let output = ptfast(here, &words);
            assert!(output.status.success());
            String::from_utf8(output.stdout).unwrap().contains("is complete")
        };
        assert!(!skips(&["--spp", "3"]), "{name} is not there");
        assert!(skips(&["--spp", "3"]), "{name}");
        assert!(!skips(&["--spp", "4"]), "{name} of other settings");
        assert!(!skips(&["--spp", "4", "--depth", "3"]) && skips(&["--spp", "4", "--depth", "3"]));
        assert!(!skips(&["--spp", "4"]) && skips(&["--spp", "4"]), "{name}");
        let whole = fs::read(here.join(name)).unwrap();
        fs::write(here.join(name), &whole[..whole.len() - whole.len() / 4]).unwrap();
        assert!(!skips(&["--spp", "4"]), "{name} is cut");
        fs::write(here.join(name), "damaged").unwrap();
        assert!(!skips(&["--spp", "4"]), "{name} is damaged");
        let record = ["--spp", "4", "--json", "record.json"];
        assert!(!skips(&record) && skips(&record), "there is no record");
        fs::remove_file(here.join("record.json")).unwrap();
    }
    let words = with(&SMALL[..7], &["-o", "a.png", "--skip-complete", "--progress", "json"]);
    ptfast(here, &words);
    let skipped: Value = serde_json::from_str(&stderr(&ptfast(here, &words))).unwrap();
    assert_eq!((&skipped["event"], &skipped["done"]), (&"done".into(), &skipped["total"]));
    let curve = with(&SMALL, &["a.png", "--skip-complete", "--spp", "4", "--gamma", "2"]);
    let output = ptfast(here, &curve);
    assert!(!String::from_utf8(output.stdout).unwrap().contains("is complete"), "another curve");
    let says = refusal(here, &with(&SMALL, &["a.pfm", "--skip-complete"]), 2);
    assert!(says.contains("needs a file that tells what it is of"), "{says}");
}
