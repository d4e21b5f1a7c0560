//! Tests of stopped and continued renders, which must give the same bits as uninterrupted ones.

use std::fs;
use std::sync::atomic::{AtomicU64, Ordering};

use ptfast::internals::{Checkpoint, Identity, Part, Stream};
use ptfast::{
    ComputeSettings, Engine, ImageSettings, Limits, Observer, Progress, RenderState, Renderer,
    Scene, Stop,
};
use serde_json::Value;

use super::{hash, refusal, with};
use crate::common::{ptfast, stderr};

/// Answers [`Stop::No`] the first `left` times that a render asks whether to stop, and `stop` from then on.
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

/// Stops renders at random moments, saves them in files, and continues them with other engines, numbers of
/// threads and wave sizes. Some of the stops discard unfinished work.
#[test]
fn renders_continue_from_checkpoints() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.film");
    let mut random = Stream::new(6);
    for (name, spp) in [("tests/data/everything.ron", 50), ("cornell", 100), ("spheres", 33)] {
        let scene = Scene::load(name).unwrap();
        let base = ImageSettings { width: 43, height: 29, spp, ..ImageSettings::of(&scene) };
        let new = |settings: &ImageSettings| {
            Renderer::new(&scene, settings.clone(), Engine::Wavefront).unwrap()
        };
        let whole = new(&base).render().unwrap();
        let identity = Identity::new(&scene, &base, base.image());
        let part = Part { identity: identity.clone(), shard: None, samples: 0..spp };
        for _ in 0..4 {
            let mut rendering = new(&base).begin().unwrap();
            let mut stops = 0;
            loop {
                let mut below = |end: u64| random.bits() % end;
                let compute = ComputeSettings {
                    engine: Engine::ALL[below(2) as usize],
                    threads: 1 + below(3) as u32,
                    wave_size: 1 + below(3000) as u32,
                    ..ComputeSettings::default()
                };
                let stop = [Stop::Soon, Stop::Now][below(2) as usize];
                let patience = Patience { left: AtomicU64::new(below(60)), stop };
                let renderer = Renderer::new(&scene, base.clone(), compute).unwrap();
                renderer.advance(&mut rendering, &patience).unwrap();
                let RenderState { film, .. } = &rendering;
                if film.samples_done() == film.samples_to_do() {
                    break;
                }
                stops += 1;
                let scene = scene.name().to_owned();
                let kept = Checkpoint { scene, identity: identity.clone(), shard: None, rendering };
                kept.write(&file).unwrap();
                let kept = Checkpoint::read(&file, &Limits::default()).unwrap();
                rendering = kept.resume(&part).unwrap();
            }
            assert!(stops > 0, "{name}: the render was never stopped");
            let render = new(&base).finish(&mut rendering).unwrap();
            assert_eq!(render.image.hash(), whole.image.hash(), "{name}");
            assert_eq!(render.tally, whole.tally, "{name}");
        }
    }
}

const SMALL: [&str; 11] = [
    "render", "--scene", "cornell", "--width", "24", "--seed", "5", "--quiet", "--print", "hash",
    "-o",
];

/// Finished renders can continue to more samples, whether or not their last chunk is complete.
#[test]
fn samples_may_grow() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for (few, many) in [("16", "48"), ("20", "50"), ("33", "34"), ("7", "100")] {
        let whole = hash(here, &with(&SMALL, &["whole.pfm", "--spp", many]));
        hash(here, &with(&SMALL, &["a.film", "--spp", few]));
        let more = ["more.pfm", "--spp", many, "--checkpoint", "a.film"];
        assert_eq!(hash(here, &with(&SMALL, &more)), whole, "{few} to {many}");
        let bytes = |name: &str| fs::read(here.join(name)).unwrap();
        assert!(bytes("more.pfm") == bytes("whole.pfm"));
        // The checkpoint is complete, and counts each ray once.
        hash(here, &with(&SMALL, &["whole.film", "--spp", many]));
        let read = |name: &str| Checkpoint::read(&here.join(name), &Limits::default()).unwrap();
        let (more, whole) = (read("a.film"), read("whole.film"));
        assert_eq!(more.part(), whole.part(), "{few} to {many}");
        assert_eq!(more.rendering.tally, whole.rendering.tally, "{few} to {many}");
    }
}

/// A complete checkpoint gives the image without being written again.
#[test]
fn complete_checkpoints_give_the_image() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let whole = hash(here, &with(&SMALL, &["kept.film", "--spp", "40"]));
    let modified = || fs::metadata(here.join("kept.film")).unwrap().modified().unwrap();
    let before = modified();
    let again = with(&SMALL, &["a.pfm", "--spp", "40", "--checkpoint", "kept.film"]);
    assert_eq!(hash(here, &again), whole);
    assert_eq!(modified(), before);
}

/// The checkpoint option must not overwrite a file that is not a checkpoint of this render.
#[test]
fn other_files_are_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let render = |spp| with(&SMALL, &["a.pfm", "--checkpoint", "kept.film", "--spp", spp]);
    hash(here, &render("50"));
    fs::remove_file(here.join("a.pfm")).unwrap();
    let advice = ": delete it, or choose another file with --checkpoint";
    for (content, says) in [
        (None, "kept.film: belongs to a render with spp 50, not 40"),
        (Some("my notes"), "kept.film: not a checkpoint of ptfast"),
        (Some("ptfast film\n{}\n"), "kept.film: damaged"),
    ] {
        if let Some(content) = content {
            fs::write(here.join("kept.film"), content).unwrap();
        }
        let before = fs::read(here.join("kept.film")).unwrap();
        let refused = refusal(here, &render("40"), 65);
        assert!(refused.contains(says) && refused.trim_end().ends_with(advice), "{refused}");
        assert!(
            fs::read(here.join("kept.film")).unwrap() == before && !here.join("a.pfm").exists()
        );
    }
    let target = with(&SMALL, &["c.film", "--spp", "40", "--checkpoint", "c.film"]);
    assert!(refusal(here, &target, 2).contains("need different files"));
}

/// A render that is stopped without `--checkpoint` leaves a checkpoint beside the image. The same command
/// continues the render and then deletes the checkpoint. A command with other settings is rejected.
#[test]
fn stopped_renders_are_continued_by_the_same_command() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let image = |depth, more: &[&'static str]| {
        with(&with(&SMALL, &["a.pfm", "--spp", "40", "--depth", depth]), more)
    };
    let says = refusal(here, &image("1", &["--time-limit", "1ms"]), 75);
    let saved = "continue from a.partial.film; a.partial.pfm shows the picture so far";
    assert!(says.contains(saved), "{says}");
    let film = fs::read(here.join("a.partial.film")).unwrap();
    let says = refusal(here, &image("2", &[]), 65);
    assert!(says.contains("a.partial.film: belongs to a render with depth 1, not 2"), "{says}");
    assert!(fs::read(here.join("a.partial.film")).unwrap() == film);
    let continued = hash(here, &image("1", &[]));
    assert_eq!(fs::read_dir(here).unwrap().count(), 1, "only the image may be left");
    assert_eq!(continued, hash(here, &image("1", &[])));
}

/// A checkpoint with another scene, seed or setting is rejected.
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
        (&["--spp", "40", "--roulette", "off"], "roulette 5, not \"off\""),
        (&["--spp", "40", "--clamp", "2"], "clamp null, not 2"),
        (&["--spp", "40", "--scene", "checker"], "scene_hash "),
        (&["--spp", "40", "--crop", "0,0,9,9"], "crop [0,0,24,24], not [0,0,9,9]"),
        (
            &["--spp", "40", "--shard", "0/2", "-o", "c.film"],
            "holds the whole image, not shard 0/2",
        ),
        (
            &["--spp", "40", "--sample-range", "0..16", "-o", "c.film"],
            "holds the samples 0..40, not 0..16",
        ),
    ] {
        // Add the common arguments, except those that `more` replaces.
        let mut words = with(&["render", "--checkpoint", "a.film", "--quiet"], more);
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

/// Checkpoints that are truncated, edited or of another version are rejected. So are files that are not
/// checkpoints.
#[test]
fn damaged_checkpoints_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    hash(here, &with(&SMALL, &["a.film", "--spp", "40"]));
    let good = fs::read(here.join("a.film")).unwrap();
    let mut random = Stream::new(2);
    let refused = |bytes: &[u8], what: &str| {
        fs::write(here.join("bad.film"), bytes).unwrap();
        let words = with(&SMALL, &["b.pfm", "--spp", "40", "--checkpoint", "bad.film"]);
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
    // Faults in files with a valid hash.
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
    refused(&text("\"clamped\":0", "\"clamped\":18446744073709551615"), "each count must be");
    refused(&text("\"seconds\":", "\"seconds\":-"), "the seconds must be");
    refused(&text("\"schema\":3", "\"schema\":1"), "version 1 is not supported");
    refused(&text("\"schema\":3", "\"shemca\":1"), "version null");
    refused(&text("\"roulette\":5", "\"wealth\":5"), "header: unknown field");
    refused(&text("\"width\":24", "\"width\":25000000"), "width must be");
    refused(&text("\"width\":24", "\"width\":23"), "the crop is not within");
    refused(&text("[0,0,24,24]", "[0,0,24,20]"), "damaged");
    refused(&text("\"samples\":[0,40]", "\"samples\":[0,30]"), "a pixel's samples end at 40");
    refused(&text("\"samples\":[0,40]", "\"samples\":[1,40]"), "must begin at a multiple of 16");
    refused(&text("\"shard\":null", "\"shard\":{\"index\":4,\"count\":4}"), "the shard");
    assert!(!here.join("b.pfm").exists());
}

/// A time limit stops a render with exit code 75. The continued render gives the same image.
#[test]
fn limits_of_time_end_a_render() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    // On any machine, the render stops after its first unit of work.
    let limited = with(&SMALL, &["a.pfm", "--spp", "40", "--time-limit", "1ms"]);
    let says = refusal(here, &limited, 75);
    assert!(says.contains("stopped by the time limit after"), "{says}");
    assert!(says.contains("continue from a.partial.film; a.partial.pfm shows"), "{says}");
    assert!(!here.join("a.pfm").exists() && here.join("a.partial.pfm").exists());
    let whole = hash(here, &with(&SMALL, &["whole.pfm", "--spp", "40"]));
    // Each run makes some progress, so repeated runs complete the render.
    let mut runs = (0..1000).map(|_| ptfast(here, &limited));
    let last =
        runs.find(|run| run.status.code() != Some(75)).expect("1000 runs must complete the render");
    assert!(last.status.success(), "{last:?}");
    let bytes = |name: &str| fs::read(here.join(name)).unwrap();
    assert!(bytes("a.pfm") == bytes("whole.pfm") && whole.len() == 64);
}

/// `--skip-complete` skips complete files of the same render only.
#[test]
fn complete_files_are_skipped() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for name in ["a.png", "a.exr", "a.film"] {
        let skips = |more: &[&str]| {
            let loud = ["render", "--scene", "cornell", "--width", "24", "--seed", "5", "-o"];
            let words = with(&with(&loud, &[name, "--skip-complete"]), more);
            let output = ptfast(here, &words);
            assert!(output.status.success());
            String::from_utf8(output.stdout).unwrap().contains("is complete")
        };
        assert!(!skips(&["--spp", "3"]), "{name} does not exist yet");
        assert!(skips(&["--spp", "3"]), "{name}");
        assert!(!skips(&["--spp", "4"]), "{name} has other settings");
        assert!(!skips(&["--spp", "4", "--depth", "3"]) && skips(&["--spp", "4", "--depth", "3"]));
        assert!(!skips(&["--spp", "4"]) && skips(&["--spp", "4"]), "{name}");
        let whole = fs::read(here.join(name)).unwrap();
        fs::write(here.join(name), &whole[..whole.len() - whole.len() / 4]).unwrap();
        assert!(!skips(&["--spp", "4"]), "{name} is truncated");
        fs::write(here.join(name), "damaged").unwrap();
        assert!(!skips(&["--spp", "4"]), "{name} is damaged");
        let record = ["--spp", "4", "--json", "record.json"];
        assert!(!skips(&record) && skips(&record), "the record is missing at first");
        fs::remove_file(here.join("record.json")).unwrap();
    }
    let words = with(&SMALL[..7], &["-o", "a.png", "--skip-complete", "--progress", "json"]);
    ptfast(here, &words);
    let skipped: Value = serde_json::from_str(&stderr(&ptfast(here, &words))).unwrap();
    assert_eq!((&skipped["event"], &skipped["done"]), (&"done".into(), &skipped["total"]));
    let curve = with(&SMALL, &["a.png", "--skip-complete", "--spp", "4", "--gamma", "2"]);
    let output = ptfast(here, &curve);
    assert!(
        !String::from_utf8(output.stdout).unwrap().contains("is complete"),
        "the transfer curve differs"
    );
    let says = refusal(here, &with(&SMALL, &["a.pfm", "--skip-complete"]), 2);
    assert!(says.contains("needs a format with metadata"), "{says}");
}
