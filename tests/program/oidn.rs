//! Open Image Denoise: what is passed to it, and what becomes of a missing, old or broken one. A small library stands for
//! it.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use ptfast::Image;
use serde_json::Value;

use crate::common::{stderr, stdout};

const FILE: &str = "libOpenImageDenoise.so.2";

/// Builds the library in `folder`.
fn build(folder: &Path, flags: &[&str]) {
    fs::create_dir_all(folder).unwrap();
    let mut cc = Command::new("cc");
    cc.args(["-shared", "-fPIC", "-o"]).arg(folder.join(FILE)).args(flags);
    let built = cc.arg("tests/data/oidn.c").status().expect("cc must start");
    assert!(built.success());
}

/// Runs the program in `here` with the library in `library`.
fn with(here: &Path, library: &str, words: &[&str]) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_ptfast"));
    program.args(words).current_dir(here).env("PTFAST_OIDN", library);
    program.output().expect("the program must start")
}

#[test]
fn pictures_and_features_are_passed_to_the_library() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    build(&here.join("new"), &[]);
    let render = ["render", "cornell", "--width", "40", "--spp", "2", "--denoise=oidn"];
    let run = |words: &[&str]| {
        let output = with(here, "new", words);
        assert!(output.status.success(), "{words:?}: {}", stderr(&output));
        stdout(&output)
    };
    let said = run(&[&render[..], &["-o", "a.exr", "--json", "a.json"]].concat());
    assert!(said.contains("denoise ") && !said.contains("denoised"), "{said}");
    let noisy = Image::read(&here.join("a.exr:noisy")).unwrap();
    let turned =
        |image: &Image| image.pixels().iter().map(|&[r, g, b]| [g, b, r]).collect::<Vec<_>>();
    assert_eq!(Image::read(&here.join("a.exr")).unwrap().pixels(), turned(&noisy));
    let record: Value =
        serde_json::from_str(&fs::read_to_string(here.join("a.json")).unwrap()).unwrap();
    assert_eq!(record["denoised_hash"], Value::Null);
    let bytes = fs::read(here.join("a.exr")).unwrap();
    let has = |text: &[u8]| bytes.windows(text.len()).any(|part| part == text);
    assert!(has(b"ptfast:oidn") && has(b"2.5.1") && !has(b"ptfast:denoised"));
    // A complete picture is not rendered again.
    let skip = [&render[..], &["-o", "a.exr", "--skip-complete"]].concat();
    assert!(run(&skip).contains("is complete"));
    // The error of the denoised picture is estimated.
    let noise = ["-o", "n.png", "--noise", "0.1%", "--max-spp", "48"];
    let goal = [&["render", "cornell", "--width", "40", "--denoise=oidn"][..], &noise].concat();
    assert!(run(&goal).contains("noise "));
    // The same from films and files.
    let layers = ["--layers", "albedo,normal", "--first-hit", "through"];
    run(&[&render[..6], &layers[..], &["-o", "a.film"]].concat());
    run(&["merge", "a.film", "-o", "b.exr", "--denoise=oidn"]);
    run(&["merge", "a.film", "-o", "layers.exr"]);
    run(&["denoise", "layers.exr", "-o", "c.exr", "--quality", "oidn"]);
    // The library knows no normals without albedo.
    run(&[&render[..6], &["--layers", "normal", "-o", "normal.exr"]].concat());
    run(&["denoise", "normal.exr", "-o", "d.exr", "--quality", "oidn"]);
    for name in ["b.exr", "c.exr", "d.exr"] {
        assert_eq!(Image::read(&here.join(name)).unwrap().pixels(), turned(&noisy), "{name}");
    }
}

#[test]
fn a_missing_old_or_broken_library_gives_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    build(&here.join("old"), &["-DOLD"]);
    build(&here.join("one"), &["-DVERSION=10403"]);
    build(&here.join("failing"), &["-DFAIL=1"]);
    fs::create_dir(here.join("broken")).unwrap();
    fs::write(here.join("broken").join(FILE), "no library").unwrap();
    let words =
        ["render", "cornell", "--width", "40", "--spp", "2", "--denoise=oidn", "-o", "a.png"];
    for (library, wanted) in [
        ("missing", "missing"),
        ("broken", "broken/libOpenImageDenoise"),
        ("old", "oidnNewFilter"),
        ("one", "another version, 1.4.3"),
        ("failing", "out of memory"),
    ] {
        let output = with(here, library, &words);
        let error = stderr(&output);
        assert!(
            !output.status.success() && error.trim().lines().count() == 1,
            "{library}: {error}"
        );
        assert!(
            error.contains(wanted) && error.contains("Open Image Denoise"),
            "{library}: {error}"
        );
        assert!(library == "failing" || error.contains("PTFAST_OIDN"), "{library}: {error}");
        // Nothing was rendered, unless the library failed later.
        assert!(!here.join("a.png").exists());
        assert_eq!(
            here.join("a.partial.film").exists(),
            library == "failing",
            "{library}: {error}"
        );
    }
}
