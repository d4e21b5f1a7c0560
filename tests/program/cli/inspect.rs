//! Tests of the options that show the inside of a render: plans, traces of workers, single paths.

use std::fs;

use serde_json::Value;

use super::{SMALL, succeeds};
use crate::common::{ptfast, stderr, stdout};

/// In a trace, the stages of a worker do not overlap, and each lies within one of the worker's
/// tiles. Tracing does not change the image.
#[test]
fn traces_show_the_work_of_each_worker() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let arguments = ["40", "--threads", "2", "--trace", "trace.json", "--json", "record.json"];
    succeeds(here, &[&SMALL[..], &arguments].concat());
    let read = |name: &str| -> Value {
        serde_json::from_str(&fs::read_to_string(here.join(name)).unwrap()).unwrap()
    };
    let (trace, record) = (read("trace.json"), read("record.json"));
    let events = trace["traceEvents"].as_array().unwrap();
    assert_eq!(events.iter().filter(|event| event["name"] == "thread_name").count(), 2);
    let all = |stage: &str, segment: u64| -> u64 {
        let is = |event: &&Value| event["name"] == stage && event["args"]["segment"] == segment;
        events.iter().filter(is).map(|event| event["args"]["active"].as_u64().unwrap()).sum()
    };
    assert_eq!((all("generate", 1), all("accumulate", 1)), (40 * 40 * 3, 40 * 40 * 3));
    for (number, segment) in record["segments"].as_array().unwrap().iter().enumerate().take(15) {
        for stage in ["extend", "shade", "connect"] {
            let active = segment["stages"][stage]["active"].as_u64().unwrap_or(0);
            assert_eq!(all(stage, number as u64 + 1), active, "{stage} {number}");
        }
    }
    let span = |event: &Value| {
        let [start, seconds] = ["ts", "dur"].map(|field| event[field].as_f64().unwrap());
        (start, start + seconds)
    };
    for worker in 0..2 {
        let of = |category: &'static str| {
            let mut spans: Vec<(f64, f64)> = events
                .iter()
                .filter(|event| event["tid"] == worker && event["cat"] == category)
                .map(span)
                .collect();
            spans.sort_by(|a, b| a.0.total_cmp(&b.0));
            spans
        };
        let (tiles, stages) = (of("tile"), of("stage"));
        for spans in [&tiles, &stages] {
            for pair in spans.windows(2) {
                assert!(pair[0].1 <= pair[1].0 + 1e-3, "{pair:?} of worker {worker}");
            }
        }
        for stage in stages {
            let holds = |tile: &&(f64, f64)| tile.0 <= stage.0 + 1e-3 && stage.1 <= tile.1 + 1e-3;
            assert!(tiles.iter().any(|tile| holds(&tile)), "{stage:?} is in no tile");
        }
    }
    succeeds(here, &[&SMALL[..], &["40", "--json", "plain.json"]].concat());
    assert_eq!(read("plain.json")["hash"], record["hash"]);
}

/// A render can use the plan of a record. Files that have no valid plan are rejected.
#[test]
fn plans_of_records_can_be_reused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let base = ["render", "--scene", "cornell", "--width", "30", "--spp", "4", "-o", "a.png"];
    let with = |more: &[&str]| ptfast(here, &[&base[..], more].concat());
    let first = with(&["--json", "a.json", "--wave-size", "100", "--stats"]);
    assert!(first.status.success(), "{}", stderr(&first));
    let again = with(&["--plan", "a.json", "--json", "b.json", "--stats"]);
    assert!(again.status.success(), "{}", stderr(&again));
    assert!(stdout(&again).contains("plan: waves of 100;"), "{}", stdout(&again));
    // Both renders do the same work, down to the boxes and primitives that are tested.
    let counts = |file: &str| {
        let text = fs::read_to_string(here.join(file)).unwrap();
        let mut record: Value = serde_json::from_str(&text).unwrap();
        for segment in record["segments"].as_array_mut().unwrap() {
            for stage in segment["stages"].as_object_mut().unwrap().values_mut() {
                assert!(stage.as_object_mut().unwrap().remove("seconds").unwrap().is_f64());
            }
        }
        record["segments"].take()
    };
    let counts = (counts("a.json"), counts("b.json"));
    assert!(counts.0[0]["stages"]["extend"]["counters"]["leaf_tests"].as_u64().unwrap() > 0);
    assert_eq!(counts.0[0]["stages"]["extend"]["active"], 30 * 30 * 4);
    assert_eq!(counts.0, counts.1);
    // Plans of records from before shadow rays could be sorted have no such field.
    let record = fs::read_to_string(here.join("a.json")).unwrap();
    let mut record: Value = serde_json::from_str(&record).unwrap();
    for segment in record["plan"]["segments"].as_array_mut().unwrap() {
        assert_eq!(segment.as_object_mut().unwrap().remove("shadows_ordered"), Some(false.into()));
    }
    fs::write(here.join("old.json"), record.to_string()).unwrap();
    let old = with(&["--plan", "old.json", "--json", "c.json", "--stats"]);
    assert!(old.status.success(), "{}", stderr(&old));
    assert!(stdout(&old).contains("plan: waves of 100;"), "{}", stdout(&old));
    // The tables have the exact numbers of rays and of path endings.
    let told = |output| -> Vec<String> {
        let counted = |line: &&str| line.contains(" rays: ") || line.contains(" paths ended: ");
        stdout(output).lines().filter(counted).map(str::to_owned).collect()
    };
    assert!(told(&first).len() == 2 && told(&first)[0].contains(": 3600 primary, "), "{first:?}");
    assert_eq!(told(&first), told(&again));
    let other = ["render", "--scene", "spheres", "--width", "9", "--spp", "1", "-o", "b.png"];
    let elsewhere = ptfast(here, &[&other[..], &["--plan", "a.json"]].concat());
    assert!(elsewhere.status.success(), "{}", stderr(&elsewhere));
    assert!(stderr(&elsewhere).contains("a.json: the plan is of another scene"));
    assert!(!stderr(&again).contains("another scene"));
    for more in [["--wave-size", "9"], ["--engine", "scalar"]] {
        let both = with(&[&["--plan", "a.json"], &more[..]].concat());
        assert_eq!(both.status.code(), Some(2), "{more:?}");
    }
    for (text, place) in [
        ("{", "bad.json:1:"),
        ("{\"plan\": 3}", "bad.json:plan: must be a plan or"),
        ("{\"a\": 3}", "bad.json:plan: must be a plan or"),
        ("{\"plan\": null}", "bad.json:plan: the record has no plan"),
        ("{\"wave_size\": 0, \"segments\": []}", "bad.json:plan: wave_size must be"),
    ] {
        fs::write(here.join("bad.json"), text).unwrap();
        let bad = with(&["--plan", "bad.json"]);
        assert_eq!(bad.status.code(), Some(65), "{text}");
        assert!(stderr(&bad).contains(place), "{}", stderr(&bad));
    }
}

/// `path` prints each ray of a sample. A render of the same sample counts the same rays.
#[test]
fn paths_are_printed_ray_by_ray() {
    let folder = tempfile::tempdir().unwrap();
    let size = ["--scene", "cornell", "--width", "1", "--height", "1", "--seed", "5"];
    let render =
        [&["render", "--spp", "1", "-q", "-o", "a.pfm", "--json", "a.json"], &size[..]].concat();
    assert!(ptfast(folder.path(), &render).status.success());
    let record: Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("a.json")).unwrap()).unwrap();
    let told = ptfast(folder.path(), &[&["path", "--pixel", "0,0"], &size[..]].concat());
    let text = stdout(&told);
    assert!(text.starts_with("  1 camera  from ("), "{text}");
    let rays =
        record["rays"].as_object().unwrap().values().map(|n| n.as_u64().unwrap()).sum::<u64>();
    assert_eq!(text.lines().count() as u64, rays + 1, "{text}");
    let mean: Vec<String> = record["mean"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| format!("{}", c.as_f64().unwrap() as f32))
        .collect();
    assert_eq!(text.lines().last().unwrap(), format!("radiance ({})", mean.join(", ")));
    let far = ["path", "--pixel", "0,0", "--sample", "16777216"];
    let far = ptfast(folder.path(), &[&far[..], &size].concat());
    assert!(stderr(&far).contains("--sample"), "{}", stderr(&far));
    // `path` rejects options that could not change the sample.
    for option in [["--spp", "5"], ["--clamp", "1"]] {
        let other = ["path", "--pixel", "0,0", option[0], option[1]];
        assert_eq!(ptfast(folder.path(), &[&other[..], &size].concat()).status.code(), Some(2));
    }
    let outside = ptfast(folder.path(), &[&["path", "--pixel", "1,0"], &size[..]].concat());
    assert_eq!(outside.status.code(), Some(2));
    assert!(stderr(&outside).contains("--pixel must be within 1 x 1, is 1,0"));
}

/// In dense fog, the first segment ends before the surface behind the fog.
#[test]
fn paths_show_scattering_by_media() {
    let folder = tempfile::tempdir().unwrap();
    let scene = r#"(camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 2),
        materials: {"lamp": light(radiance: (1, 1, 1))},
        primitives: [sphere(center: (0, 0, 0), radius: 20, material: "lamp")],
        media: [sphere(center: (0, 0, 0), radius: 1, density: 1000, albedo: (1, 1, 1))])"#;
    fs::write(folder.path().join("fog.ron"), scene).unwrap();
    let size = ["--width", "1", "--height", "1"];
    let told = succeeds(
        folder.path(),
        &[&["path", "--scene", "fog.ron", "--pixel", "0,0"], &size[..]].concat(),
    );
    let first = told.lines().next().unwrap();
    assert!(first.contains(": is scattered by a medium at 4."), "{told}");
}
