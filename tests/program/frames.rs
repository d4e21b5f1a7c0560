//! Tests of `ptfast render --frames`.

use std::fs;
use std::path::Path;

use crate::common::{ptfast, stderr, stdout};

const SIZE: [&str; 6] = ["--width", "24", "--height", "16", "--spp", "2"];

/// The names of the pictures in `folder`, sorted.
fn pictures(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<_> = names.filter(|name| name.ends_with(".png")).collect();
    names.sort();
    names
}

#[test]
fn an_orbit_is_continued_and_split() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let orbit = ["render", "cornell", "--frames", "3..7", "--orbit", "180", "-o", "a.png"];
    let render = |more: &[&str]| {
        let output = ptfast(here, &[&orbit, &SIZE[..], more].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        stdout(&output)
    };
    render(&["--shard", "1/2"]);
    assert_eq!(pictures(here), ["a.0003.png", "a.0005.png"]);
    let before = fs::metadata(here.join("a.0003.png")).unwrap().modified().unwrap();
    let said = render(&[]);
    assert_eq!(pictures(here), ["a.0003.png", "a.0004.png", "a.0005.png", "a.0006.png"]);
    assert_eq!(said.lines().count(), 4, "{said}");
    let after = fs::metadata(here.join("a.0003.png")).unwrap().modified().unwrap();
    assert_eq!(after, before, "a complete frame is kept");
    // The first frame is the picture of the scene's own camera, and each frame differs.
    let plain = ptfast(here, &[&["render", "cornell", "-o", "b.png"], &SIZE[..]].concat());
    assert!(plain.status.success());
    let bytes = |name: &str| fs::read(here.join(name)).unwrap();
    assert_eq!(bytes("a.0003.png"), bytes("b.png"));
    assert!(bytes("a.0004.png") != bytes("a.0005.png") && bytes("a.0004.png") != bytes("b.png"));
}

#[test]
fn a_frame_that_fails_does_not_stop_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    fs::create_dir(here.join("a.0001.png")).unwrap();
    let orbit = ["render", "cornell", "--frames", "0..3", "--orbit", "90", "-o", "a.png"];
    let output = ptfast(here, &[&orbit, &SIZE[..]].concat());
    assert!(!output.status.success());
    let said = stderr(&output);
    assert!(
        said.contains("frame 1: a.0001.png") && said.contains("1 of 3 frames failed"),
        "{said}"
    );
    assert!(here.join("a.0000.png").is_file() && here.join("a.0002.png").is_file());
}

#[test]
fn what_does_not_move_has_no_frames() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, said) in [
        (&["--frames", "0..3"][..], "--orbit"),
        (&["--frames", "3..3", "--orbit", "1"], "first less than the second"),
        (&["--orbit", "1"], "--frames"),
        (&["--frames", "0..3", "--orbit", "1", "-o", "-"], "-o FILE"),
    ] {
        let output = ptfast(folder.path(), &[&["render", "cornell"], arguments].concat());
        assert!(!output.status.success() && stderr(&output).contains(said), "{}", stderr(&output));
    }
}
