//! Tests of exposure and tone maps of 8-bit files.

use std::fs;

use super::succeeds;
use crate::common::{ptfast, stderr};

#[test]
fn exposure_and_tone_maps_change_png_files_only() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let base = ["render", "cornell", "--width", "24", "--spp", "2", "-q", "-o"];
    let render = |name: &str, more: &[&str]| {
        succeeds(here, &[&base[..], &[name], more].concat());
        fs::read(here.join(name)).unwrap()
    };
    let plain = render("a.png", &[]);
    assert_eq!(render("a.png", &["--exposure", "0", "--tonemap", "none"]), plain);
    let (bright, agx, neutral) =
        (["--exposure", "1.5"], ["--tonemap", "agx"], ["--tonemap", "neutral"]);
    let files = [&bright[..], &agx, &neutral].map(|more| render("b.png", more));
    assert!(files.iter().all(|file| *file != plain));
    assert_eq!(render("b.png", &agx), files[1], "equal renders give equal files");
    let linear = render("a.exr", &[]);
    assert_eq!(render("b.exr", &[&bright[..], &agx].concat()), linear);

    // The linear values of these files are lost.
    for more in [&bright[..], &agx] {
        render("c.png", more);
        let output = ptfast(here, &["compare", "a.exr", "c.png"]);
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(65), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(error.contains("c.png: has no linear values"), "{error}");
    }
}

#[test]
fn complete_files_have_the_same_exposure_and_tone_map() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let base = ["render", "cornell", "--width", "24", "--spp", "16", "-o"];
    let skips = |more: &[&str]| {
        let skip = ["a.png", "--skip-complete"];
        succeeds(here, &[&base[..], &skip, more].concat()).contains("is complete")
    };
    let both = ["--exposure", "-0.5", "--tonemap", "agx"];
    for options in [&both[..], &["--exposure", "-0.5"], &["--tonemap", "neutral"], &[]] {
        assert!(!skips(options) && skips(options), "{options:?}");
    }

    // Merged parts have the file of the whole render.
    succeeds(here, &[&base[..], &["a.png"], &both].concat());
    for shard in ["0", "1"] {
        let (name, part) = (format!("{shard}.film"), format!("{shard}/2"));
        succeeds(here, &[&base[..], &[&name, "--shard", &part]].concat());
    }
    succeeds(here, &[&["merge", "0.film", "1.film", "-o", "m.png"], &both[..]].concat());
    assert!(fs::read(here.join("m.png")).unwrap() == fs::read(here.join("a.png")).unwrap());
    for wrong in ["33", "NaN", "bright"] {
        let output = ptfast(here, &[&base[..], &["a.png", "--exposure", wrong]].concat());
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains("must be a number from -32 to 32"), "{error}");
    }
}
