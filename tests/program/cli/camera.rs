//! Tests of the options that choose the camera and the background.

use std::fs;
use std::path::Path;

use super::succeeds;
use crate::common::{ptfast, stderr};

const SCENE: &str = r#"(
    camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 40),
    CAMERAS
    background: gradient(bottom: (0, 0, 0), top: (1, 1, 1)),
    materials: {"grey": lambertian(albedo: (0.5, 0.5, 0.5))},
    primitives: [sphere(center: (0, 0, 0), radius: 1, material: "grey")],
)"#;
const SIDE: &str = "(look_from: (4, 1, 0), look_at: (0, 0.5, 0), vfov: 30)";

fn render(folder: &Path, arguments: &[&str]) -> std::process::Output {
    ptfast(folder, &[&["render", "--width", "16", "--spp", "2"], arguments].concat())
}

#[test]
fn cameras_are_chosen_and_changed() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let cameras = format!(r#"cameras: {{"side": {SIDE}, "back": {SIDE}}},"#);
    fs::write(here.join("a.ron"), SCENE.replace("CAMERAS", &cameras)).unwrap();
    let plain = SCENE.replace("CAMERAS", "");
    let front = "(look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 40)";
    fs::write(here.join("side.ron"), plain.replace(front, SIDE)).unwrap();
    fs::write(here.join("front.ron"), &plain).unwrap();
    let hash = |arguments: &[&str]| {
        let all = [arguments, &["--print", "hash", "--json", "a.json"]].concat();
        let output = render(here, &all);
        assert!(output.status.success(), "{}", stderr(&output));
        let record = fs::read_to_string(here.join("a.json")).unwrap();
        let record: serde_json::Value = serde_json::from_str(&record).unwrap();
        (String::from_utf8(output.stdout).unwrap(), record["scene_hash"].to_string())
    };
    assert_eq!(hash(&["a.ron"]), hash(&["front.ron"]), "unused cameras change nothing");
    let side = hash(&["side.ron"]);
    assert_ne!(hash(&["a.ron"]), side);
    assert_eq!(hash(&["a.ron", "--camera", "side"]), side);
    let values = ["--look-from", "4,1,0", "--look-at", "0,0.5,0", "--fov", "30"];
    assert_eq!(hash(&[&["a.ron"], &values[..]].concat()), side);
    assert_eq!(hash(&["a.ron", "--camera", "side", "--up", "0,2,0"]), side);
    let turned = hash(&["a.ron", "--camera", "side", "--up", "0,0,-1"]);
    assert_ne!(turned, side);

    // An image of another camera is not complete.
    let skips = |camera: &str| {
        let all = ["a.ron", "--camera", camera, "--skip-complete", "--look-at", "0,0.1,0"];
        let output = render(here, &[&all[..], &["--fov", "20", "-o", "a.exr"]].concat());
        String::from_utf8(output.stdout).unwrap().contains("is complete")
    };
    assert!(!skips("side") && skips("side") && skips("back"), "both cameras are equal");
    let path = ["path", "a.ron", "--pixel", "3,4", "--camera", "side", "--look-from", "4,1,0.5"];
    assert!(succeeds(here, &path).contains("from (4, 1, 0.5)"));
    let set = ["--max-rays", "2048", "--spp", "1", "-o", "set"];
    succeeds(here, &[&["rays", "a.ron", "--camera", "side"], &set[..]].concat());
}

#[test]
fn wrong_cameras_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let cameras = format!(r#"cameras: {{"side": {SIDE}}},"#);
    fs::write(here.join("a.ron"), SCENE.replace("CAMERAS", &cameras)).unwrap();
    for (arguments, message) in [
        (["--camera", "sied"], "unknown camera `sied`, did you mean `side`?"),
        (["--fov", "180"], "camera: vfov must be in (0, 180) degrees, is 180.0"),
        (["--fov", "wide"], "invalid value 'wide' for '--fov <DEGREES>'"),
        (["--look-from", "0,0,0"], "camera: look_from and look_at must differ"),
        (["--look-from", "1,2"], "must be three numbers with commas between them"),
        (["--look-at", "NaN,0,0"], "camera: look_at must be finite"),
        (["--up", "0,0,1"], "camera: up must not be zero or parallel"),
    ] {
        let output = render(here, &[&["a.ron"], &arguments[..]].concat());
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.lines().count() == 1 && error.contains(message), "{error}");
    }
    let none = render(here, &["cornell", "--camera", "side"]);
    assert!(stderr(&none).contains("unknown camera `side`, none is defined"), "{}", stderr(&none));
    let bench = ptfast(here, &["bench", "--camera", "side"]);
    assert_eq!(bench.status.code(), Some(2), "bench has no camera");

    let wrong = SIDE.replace("vfov: 30", "vfov: 0");
    let cameras = format!("cameras: {{\"side\": {wrong}}},");
    fs::write(here.join("a.ron"), SCENE.replace("CAMERAS", &cameras)).unwrap();
    let output = render(here, &["a.ron"]);
    let want = "ptfast: a.ron:3:21: cameras.side: camera: vfov must be in (0, 180)";
    assert!(stderr(&output).starts_with(want), "{}", stderr(&output));
    assert_eq!(output.status.code(), Some(65));
}

#[test]
fn environment_maps_replace_the_background() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let map = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/sky.pfm");
    fs::copy(map, here.join("sky.pfm")).unwrap();
    let plain = SCENE.replace("CAMERAS", "");
    fs::write(here.join("a.ron"), &plain).unwrap();
    let gradient = "gradient(bottom: (0, 0, 0), top: (1, 1, 1))";
    let mapped = plain.replace(gradient, r#"image(file: "sky.pfm")"#);
    fs::write(here.join("b.ron"), mapped).unwrap();
    let hash = |arguments: &[&str]| {
        let output = render(here, &[arguments, &["--print", "hash"]].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        output.stdout
    };
    let mapped = hash(&["b.ron"]);
    assert_eq!(hash(&["a.ron", "--env", "sky.pfm"]), mapped);
    assert_ne!(hash(&["a.ron"]), mapped);
    let error = stderr(&render(here, &["a.ron", "--env", "none.hdr"]));
    assert!(error.contains("none.hdr") && error.lines().count() == 1, "{error}");
}
