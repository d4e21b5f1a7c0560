//! Tests of `ptfast rays` and `ptfast trace`.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::succeeds;
use crate::common::{ptfast, stderr};

/// Writes a small ray set to the folder `set` in `here`.
fn small_ray_set(here: &Path, scene: &str) {
    let most = ["--spp", "1", "--max-rays", "4096"];
    succeeds(here, &[&["rays", "--scene", scene, "--out", "set"][..], &most].concat());
}

#[test]
fn ray_sets_have_the_documented_format_and_trace_to_the_same_hits() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for (scene, sets, primitives) in [
        ("spacetime", &["primary", "bounce"][..], [488, 0, 0]),
        ("cornell", &["primary", "bounce", "shadow"], [0, 18, 0]),
        ("mesh:20480", &["primary", "bounce"], [0, 0, 20_482]),
        (INSTANCES, &["primary", "bounce", "shadow"], [1, 1, 4]),
    ] {
        small_ray_set(here, scene);
        let set = here.join("set");
        let manifest: Value =
            serde_json::from_str(&fs::read_to_string(set.join("manifest.json")).unwrap()).unwrap();
        assert_eq!((&manifest["scene"], &manifest["seed"]), (&scene.into(), &1.into()));
        let bytes = |file: String| fs::metadata(set.join(file)).unwrap().len();
        for ((kind, size), count) in
            [("spheres", 32), ("quads", 36), ("triangles", 36)].into_iter().zip(primitives)
        {
            assert_eq!(manifest["counts"][kind], count);
            assert_eq!(bytes(format!("{kind}.f32")), count * size);
        }
        let names: Vec<&str> = manifest["sets"]
            .as_array()
            .unwrap()
            .iter()
            .map(|s| s["name"].as_str().unwrap())
            .collect();
        assert_eq!(names, sets);
        for set_entry in manifest["sets"].as_array().unwrap() {
            let (name, rays) =
                (set_entry["name"].as_str().unwrap(), set_entry["rays"].as_u64().unwrap());
            let kind = if name == "shadow" { "occluded" } else { "closest" };
            assert_eq!(set_entry["kind"], kind);
            // The picture of the scene with instances has only 2304 pixels.
            let least = if scene == INSTANCES { 1024 } else { 2048 };
            assert!((least..=4096).contains(&rays), "{scene} {name}: {rays}");
            for (extension, size) in [("rays", 24), ("range", 8), ("hits", 8)] {
                assert_eq!(bytes(format!("{name}.{extension}")), rays * size);
            }
            assert_eq!(set.join(format!("{name}.time")).exists(), scene == "spacetime");
            let instances = format!("{name}.instances");
            assert_eq!(set.join(&instances).exists(), scene == INSTANCES);
            if scene == INSTANCES {
                assert_eq!(bytes(instances), rays * 4);
            }
        }
        if scene == INSTANCES {
            let counts = &manifest["counts"];
            assert_eq!(
                (&counts["meshes"], &counts["instances"]),
                (&[8, 8, 2][..].into(), &8.into())
            );
            assert_eq!(bytes("meshes.f32".to_owned()), 18 * 36);
            assert_eq!(bytes("instances.f32".to_owned()), 8 * 52);
        }

        for file in ["set/manifest.json", "set/quads.f32", "set/primary.hits"] {
            let same = ptfast(here, &["trace", "set", "--json", file]);
            let says = "would overwrite a part of the ray set";
            assert!(stderr(&same).contains(says), "{}", stderr(&same));
        }
        let table = succeeds(here, &["trace", "set", "--reps", "1", "--json", "trace.json"]);
        assert!(table.contains("0 different"), "{table}");
        let record: Value =
            serde_json::from_str(&fs::read_to_string(here.join("trace.json")).unwrap()).unwrap();
        assert_eq!(record["schema"], 1);
        assert!(record["machine"]["cpu"].is_string());
        let rows = record["kernels"].as_array().unwrap();
        assert!(rows.len() >= 3 * sets.len(), "{table}");
        for row in rows {
            assert_eq!(row["different"], 0);
            assert!(row["mrays_per_s"].as_f64().unwrap() > 0.0);
        }
        fs::remove_dir_all(set).unwrap();
    }
}

/// A scene with instances, some of them of lights.
const INSTANCES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/instances.ron");

#[test]
fn damaged_instances_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    small_ray_set(here, INSTANCES);
    for (file, at, word, want) in [
        ("instances.f32", 48, 3, "instances.f32:[0]: mesh 3 does not exist"),
        ("instances.f32", 0, f32::NAN.to_bits(), "instances.f32:[0]: the matrix must be finite"),
        ("meshes.f32", 36, f32::INFINITY.to_bits(), "meshes.f32:[1]: a coordinate is not finite"),
        (
            "primary.instances",
            4,
            8,
            "primary.instances:[1]: instance 8 does not exist, there are 8",
        ),
    ] {
        let path = here.join("set").join(file);
        let whole = fs::read(&path).unwrap();
        let mut damaged = whole.clone();
        damaged[at..at + 4].copy_from_slice(&u32::to_le_bytes(word));
        fs::write(&path, damaged).unwrap();
        let output = ptfast(here, &["trace", "set", "--reps", "1"]);
        assert_eq!(output.status.code(), Some(65));
        assert!(stderr(&output).contains(want), "{}", stderr(&output));
        fs::write(&path, whole).unwrap();
    }
}

#[test]
fn trace_finds_a_wrong_hit() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    small_ray_set(here, "checker");
    let path = here.join("set/primary.hits");
    let mut hits = fs::read(&path).unwrap();
    hits[8] ^= 1;
    fs::write(&path, hits).unwrap();
    let output = ptfast(here, &["trace", "set", "--reps", "1", "--kernel", "stream"]);
    assert_eq!(output.status.code(), Some(1));
    // A notice about the build may come before the error.
    let (text, last) = (stderr(&output), "ptfast: set: 1 hits differ from those of the ray set");
    assert_eq!(text.lines().last(), Some(last), "{text}");
}

#[test]
fn all_rays_of_a_render_are_recorded() {
    let scene = ptfast::Scene::load("cornell").unwrap();
    let settings = ptfast::ImageSettings {
        width: 37,
        height: 21,
        spp: 5,
        ..ptfast::ImageSettings::of(&scene)
    };
    let sets = ptfast::internals::record(&scene, &settings, u64::MAX).unwrap();
    let counts: Vec<u64> = sets.sets.iter().map(|set| set.rays.len() as u64).collect();
    let rays = ptfast::Renderer::new(&scene, settings, ptfast::Engine::Wavefront)
        .unwrap()
        .render()
        .unwrap()
        .tally
        .rays;
    assert_eq!(counts, [rays.primary, rays.bounce, rays.shadow]);
}
