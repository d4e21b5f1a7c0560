//! Tests of mistakes that new users make, and of pipes.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use super::succeeds;
use crate::common::{ptfast, stderr, stdout};

const SKY: &str = "background: constant(radiance: (1, 1, 1))";

fn scene(more: &str) -> String {
    format!("(camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 40), {more})")
}

/// Runs the program with `input` on standard input.
fn piped(folder: &Path, arguments: &[&str], input: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_ptfast"))
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
    child.wait_with_output().unwrap()
}

#[track_caller]
fn fails(folder: &Path, arguments: &[&str], code: i32, says: &str) {
    let output = ptfast(folder, arguments);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", stderr(&output));
    assert!(stderr(&output).contains(says), "{arguments:?}: {}", stderr(&output));
}

#[test]
fn unrelated_files_are_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let base = ["render", "cornell", "--width", "16", "--spp", "1", "-o"];
    succeeds(here, &[&base[..], &["a.png"]].concat());
    succeeds(here, &[&base[..], &["b.png", "--seed", "2"]].concat());
    let image = fs::read(here.join("a.png")).unwrap();
    fails(here, &["compare", "a.png", "b.png", "--heatmap", "a.png"], 2, "would overwrite");
    assert_eq!(fs::read(here.join("a.png")).unwrap(), image);

    fs::create_dir(here.join("d")).unwrap();
    let rays = ["rays", "cornell", "--spp", "1", "--max-rays", "2048", "-o", "d"];
    let figures = ["figures", "--quick", "-o", "d"];
    let dashboard = ["dashboard", "--history", "records", "-o", "d"];
    fs::create_dir(here.join("records")).unwrap();
    let bench =
        ["bench", "--scene", "cornell", "--width", "8", "--spp", "1", "--blocks", "6", "-j", "1"];
    succeeds(here, &[&bench[..], &["-q", "--json", "records/a.json"]].concat());
    for (command, file) in [
        (&rays[..], "manifest.json"),
        (&rays, "spheres.f32"),
        (&figures, "figure-3.png"),
        (&figures, "index.html"),
        (&dashboard, "index.html"),
    ] {
        let file = here.join("d").join(file);
        fs::write(&file, "mine").unwrap();
        fails(here, command, 2, "is not an earlier output of this command");
        assert_eq!(fs::read_to_string(&file).unwrap(), "mine");
        fs::remove_file(file).unwrap();
    }
    // Earlier outputs of the same command are overwritten.
    for command in [&rays[..], &dashboard] {
        succeeds(here, command);
        succeeds(here, command);
        fs::remove_dir_all(here.join("d")).unwrap();
    }
}

#[test]
fn scenes_and_images_go_through_pipes() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let small = ["--width", "16", "--spp", "2", "--print", "hash"];
    let hash = succeeds(here, &[&["render", "cornell", "-o", "a.png"], &small[..]].concat());
    for form in [&["scenes", "show", "cornell"][..], &["scenes", "show", "cornell", "--json"]] {
        let text = succeeds(here, form);
        let output = piped(here, &[&["render", "-", "-o", "b.png"], &small[..]].concat(), &text);
        assert_eq!(stdout(&output), hash, "{}", stderr(&output));
    }
    let output = ptfast(here, &["render", "cornell", "--width", "16", "--spp", "2", "-o", "-"]);
    assert!(output.status.success(), "{}", stderr(&output));
    fs::write(here.join("c.png"), &output.stdout).unwrap();
    assert_eq!(fs::read(here.join("a.png")).unwrap(), output.stdout);
    let wrong = piped(here, &["render", "-", "-o", "b.png"], "(camera: )");
    assert_eq!(wrong.status.code(), Some(65));
    assert!(stderr(&wrong).starts_with("ptfast: standard input:1:"), "{}", stderr(&wrong));
}

#[test]
fn quiet_prints_errors_only() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    fs::write(here.join("black.ron"), scene("")).unwrap();
    let base = ["render", "black.ron", "--width", "8", "--spp", "1", "-o", "a.png"];
    let run = |more: &[&str]| ptfast(here, &[&base[..], more].concat());
    let quiet = run(&["-q", "--stats"]);
    assert_eq!((stdout(&quiet), stderr(&quiet)), (String::new(), String::new()));
    let hash = run(&["-q", "--print", "hash"]);
    assert_eq!((stdout(&hash).len(), stderr(&hash)), (65, String::new()));
    let text = stdout(&run(&[]));
    assert!(text.contains(&format!("hash    {}", stdout(&hash).trim())), "{text}");
    assert!(!text.contains("plan:") && stdout(&run(&["--stats"])).contains("plan: waves of"));
}

#[test]
fn black_pictures_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let grey = "materials: {\"grey\": lambertian(albedo: (1, 1, 1))}";
    let around = "primitives: [sphere(center: (0, 0, 5), radius: 1, material: \"grey\")]";
    for (more, says) in [
        (SKY.to_owned(), "the scene has no primitives"),
        (format!("{grey}, {around}"), "nothing emits light, and the background is black"),
        (format!("{SKY}, {grey}, {around}"), "the camera is inside primitive 0"),
    ] {
        fs::write(here.join("a.ron"), scene(&more)).unwrap();
        for command in [&["scenes", "check"][..], &["render", "--width", "8", "--spp", "1"]] {
            let output = ptfast(here, &[command, &["a.ron"]].concat());
            assert!(
                output.status.success() && stderr(&output).contains(says),
                "{}",
                stderr(&output)
            );
        }
    }
}

#[test]
fn meshes_are_shown_and_ignored_data_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let square = "v 10 0 0\nv 14 0 0\nv 14 4 0\nv 10 4 0\nvt 0 0\nvn 0 0 1\nusemtl red\n\
                  f 1/1/1 2/1/1 3/1/1 4/1/1\n";
    fs::write(here.join("a.obj"), square).unwrap();
    let small = ["--width", "64", "--height", "64", "--spp", "4"];
    let output = ptfast(here, &[&["render", "a.obj", "-o", "a.pfm"], &small[..]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let notice = "ptfast: a.obj: one of its materials is grey, since no file describes it\n";
    assert_eq!(stderr(&output).matches(notice).count(), 1, "{}", stderr(&output));
    // The mesh is in the middle of the picture, and the sky around it.
    let image = ptfast::Image::read(&here.join("a.pfm")).unwrap();
    let (middle, corner) = (image.pixels()[32 * 64 + 32], image.pixels()[0]);
    assert!((middle[0] / corner[0] - 1.0).abs() > 0.05, "{middle:?} {corner:?}");
    let text = succeeds(here, &["scenes", "show", "a.obj"]);
    fs::write(here.join("a.ron"), text).unwrap();
    // `scenes show` prints the view for pictures of the usual shape.
    let hash = |scene| {
        let render = ["render", scene, "-o", "b.png", "--print", "hash", "--width", "64"];
        succeeds(here, &[&render[..], &["--spp", "4"]].concat())
    };
    assert_eq!(hash("a.obj"), hash("a.ron"));
}

#[test]
fn unfinished_renders_can_be_shown() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let base = ["render", "cornell", "--width", "64", "-q", "-o"];
    let long = ["a.png", "--spp", "100000", "--time-limit", "1ms"];
    assert_eq!(ptfast(here, &[&base[..], &long].concat()).status.code(), Some(75));
    let merge = ["merge", "a.partial.film", "-o", "b.png"];
    fails(here, &merge, 65, "% complete: continue this part before merging");
    let text = succeeds(here, &[&merge[..], &["--partial"]].concat());
    assert!(text.contains("of 100000 spp on average"), "{text}");
    // The same samples give the same picture.
    let picture = |file: &str| ptfast::Image::read(&here.join(file)).unwrap();
    assert_eq!(picture("b.png"), picture("a.partial.png"));

    // One of two shards covers half of the picture.
    succeeds(here, &[&base[..], &["0.film", "--spp", "16", "--shard", "0/2"]].concat());
    fails(here, &["merge", "0.film", "-o", "c.png"], 65, "shards are missing: 1/2");
    succeeds(here, &["merge", "0.film", "-o", "c.pfm", "--partial"]);
    let black = picture("c.pfm").pixels().iter().filter(|pixel| **pixel == [0.0; 3]).count();
    assert!((64 * 64 / 3..64 * 64 * 2 / 3).contains(&black), "{black}");
}

#[test]
fn usage_errors_point_to_the_command() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    succeeds(here, &["render", "cornell", "--width", "8", "--samples", "1", "--out", "a.png"]);
    let says = |arguments: &[&str]| {
        let output = ptfast(here, arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        stderr(&output)
    };
    let seed = says(&["render", "cornell", "--seed", "-1"]);
    assert!(seed.contains("invalid value '-1' for '--seed <N>'"), "{seed}");
    assert!(seed.ends_with("(see `ptfast render --help`)\n"), "{seed}");
    let glow = says(&["render", "cornell", "--glow", "0.1"]);
    assert!(glow.contains("unexpected argument '--glow'") && !glow.contains("tip"), "{glow}");
    let typo = says(&["render", "cornell", "--thraeds", "1"]);
    assert!(typo.contains("'--threads'"), "{typo}");
    let crop = says(&["render", "cornell", "--crop", "-1,0,8,8"]);
    assert!(crop.contains("must be left,upper,right,lower"), "{crop}");
    let samples = says(&["converge", "cornell", "--samples", "1"]);
    assert!(samples.contains("--spp"), "{samples}");
    for command in ["compare", "merge"] {
        assert!(!succeeds(here, &[command, "--help"]).contains("--outside-files"), "{command}");
    }
    let version = succeeds(here, &["--version", "--verbose"]);
    for line in ["ptfast ", "commit: ", "instruction set: ", "compiler: rustc "] {
        assert!(version.lines().any(|found| found.starts_with(line)), "{version}");
    }
    assert_eq!(succeeds(here, &["--version"]).lines().count(), 1);
}

/// Names cannot forge a line of the summary.
#[cfg(unix)]
#[test]
fn names_with_line_breaks_stay_on_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let name = "a\nhash    0.ron";
    fs::write(folder.path().join(name), scene(SKY)).unwrap();
    let text =
        succeeds(folder.path(), &["render", name, "--width", "8", "--spp", "1", "-o", "b.png"]);
    assert_eq!(text.lines().filter(|line| line.starts_with("hash")).count(), 1, "{text}");
    assert!(text.contains("a\\nhash"), "{text}");
}

/// A stopped render does not overwrite an unrelated file that has the name of its partial image.
#[test]
fn pictures_of_others_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    fs::write(here.join("a.partial.png"), "mine").unwrap();
    let base = ["render", "cornell", "--width", "32", "--spp", "20000", "-o", "a.png"];
    let stopped = ptfast(here, &[&base[..], &["--time-limit", "1ms"]].concat());
    assert_eq!(stopped.status.code(), Some(75), "{}", stderr(&stopped));
    assert!(!stderr(&stopped).contains("a.partial.png"), "{}", stderr(&stopped));
    assert_eq!(fs::read_to_string(here.join("a.partial.png")).unwrap(), "mine");
    assert!(here.join("a.partial.film").exists());
}

/// If the program that reads the image from a pipe exits early, the render ends without an error.
#[test]
fn closed_pipes_end_a_render_quietly() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_ptfast"))
        .args(["render", "cornell", "--width", "300", "--spp", "1", "-o", "-"])
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), stderr(&output)), (Some(0), String::new()));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}
