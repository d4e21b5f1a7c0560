//! Tests of the command line, as users and scripts see it.

mod camera;
mod display;
mod inspect;
mod newcomer;
mod rays;
mod render;

use std::fs;
use std::path::Path;

use crate::common::{ptfast, stderr, stdout};

/// Runs the program, checks that it succeeds, and returns its standard output.
#[track_caller]
pub(crate) fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = ptfast(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    stdout(&output)
}

/// Arguments of a small render. The width must follow.
const SMALL: [&str; 6] = ["render", "--scene", "cornell", "--spp", "3", "--width"];

#[test]
fn compare_measures_and_paints() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for (name, seed) in [("a.pfm", "1"), ("b.pfm", "2")] {
        succeeds(here, &[&SMALL[..], &["20", "-o", name, "--seed", seed]].concat());
    }
    let output =
        ptfast(here, &["compare", "a.pfm", "b.pfm", "--heatmap", "h.png", "--display", "2"]);
    assert_eq!(output.status.code(), Some(1), "different images must exit with 1");
    for row in ["mse", "relative mse", "psnr", "largest", "at pixel (", "ratio of means"] {
        assert!(stdout(&output).contains(row), "{}", stdout(&output));
    }
    assert!(here.join("h.png").exists());
    succeeds(here, &[&SMALL[..], &["30", "-o", "large.pfm"]].concat());
    let sizes = ptfast(here, &["compare", "a.pfm", "large.pfm"]);
    assert_eq!(sizes.status.code(), Some(1));
    assert!(stdout(&sizes).contains("no: 20 x 20 and 30 x 30 pixels"));
}

#[test]
fn scenes_are_listed_shown_and_checked() {
    let folder = tempfile::tempdir().unwrap();
    let list = succeeds(folder.path(), &["scenes"]);
    assert_eq!(list, succeeds(folder.path(), &["scenes", "list"]));
    assert_eq!(list.lines().count(), 5);
    assert!(list.contains("cornell") && list.contains("18 quads"));
    let ron = succeeds(folder.path(), &["scenes", "show", "cornell"]);
    fs::write(folder.path().join("mine.ron"), ron).unwrap();
    let json = succeeds(folder.path(), &["scenes", "show", "mine.ron", "--json"]);
    fs::write(folder.path().join("mine.json"), json).unwrap();
    let check = succeeds(folder.path(), &["scenes", "check", "mine.json"]);
    assert!(check.contains("18 quads"), "{check}");
}

/// The first example of each form in docs/scenes.md is a valid scene without warnings.
#[test]
fn documented_scenes_are_valid() {
    let manual = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/scenes.md");
    let manual = fs::read_to_string(manual).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for form in ["ron", "json"] {
        let (_, rest) = manual.split_once(&format!("\n```{form}\n")).expect("a block of this form");
        let (scene, _) = rest.split_once("\n```\n").expect("the end of the block");
        let name = format!("first.{form}");
        fs::write(folder.path().join(&name), scene).unwrap();
        let check = ptfast(folder.path(), &["scenes", "check", &name]);
        assert!(check.status.success(), "{}", stderr(&check));
        assert_eq!(stderr(&check), "", "{name}");
    }
}

/// `figures` writes six pictures of the right size, and a page with their captions and times.
#[test]
fn figures_make_six_pictures_and_a_page() {
    let folder = tempfile::tempdir().unwrap();
    succeeds(folder.path(), &["figures", "--out", "out", "--quick", "--quiet"]);
    let page = fs::read_to_string(folder.path().join("out/index.html")).unwrap();
    for number in 1..=6 {
        let file = format!("figure-{number}.png");
        let image = ptfast::Image::read(&folder.path().join("out").join(&file)).unwrap();
        let want = if number <= 3 { (1280, 720) } else { (400, 400) };
        assert_eq!((image.width(), image.height()), want);
        assert!(page.contains(&format!("src=\"{file}\"")));
        assert!(page.contains(&format!("<b>Figure {number}.</b>")));
    }
    assert!(page.contains("about 3 minutes for 100 samples per pixel"), "{page}");
    assert!(page.contains("clamped to [0, 1]"));
}
