//! The program as a user and a script see it.

mod common;

use std::fs;
use std::path::Path;

use common::{ptfast, stderr, stdout};
use serde_json::Value;

#[track_caller]
fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = ptfast(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    stdout(&output)
}

const SMALL: [&str; 6] = ["render", "--scene", "cornell", "--spp", "3", "--width"];

#[test]
fn render_writes_image_record_and_summary() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let arguments = [&SMALL[..], &["20", "--json", "record.json", "-o", "a.png", "--seed", "7"]];
    let summary = succeeds(here, &arguments.concat());
    let record: Value =
        serde_json::from_str(&fs::read_to_string(here.join("record.json")).unwrap()).unwrap();
    let hash = record["hash"].as_str().unwrap();
    assert!(summary.contains(hash) && summary.contains("a.png"), "{summary}");
    assert!(summary.contains("seed 7"), "{summary}");

    // The fields that scripts rely on.
    assert_eq!(record["schema"], 1);
    for field in ["cpu", "cores", "isa", "lanes", "os", "rustc", "flags", "commit"] {
        assert!(!record["machine"][field].is_null(), "machine.{field}");
    }
    let want = serde_json::json!({
        "scene": "cornell", "engine": "wavefront", "sampling": "mis", "sampler": "sobol",
        "width": 20, "height": 20, "spp": 3, "depth": 50, "seed": 7, "non_finite": 0,
    });
    for (field, value) in want.as_object().unwrap() {
        assert_eq!(&record[field], value, "{field}");
    }
    for step in ["load", "build", "plan", "render", "write"] {
        assert!(record["seconds"][step].as_f64().unwrap() >= 0.0, "seconds.{step}");
    }
    assert_eq!(record["rays"]["primary"], 20 * 20 * 3);
    assert!(record["rays"]["bounce"].as_u64().unwrap() > 1000);
    assert!(record["rays"]["shadow"].as_u64().unwrap() > 1000);
    for stage in ["generate", "extend", "sort", "shade", "connect", "accumulate"] {
        assert!(record["stages"][stage].is_f64(), "stages.{stage}");
    }
    assert_eq!(
        record["endings"].as_object().unwrap().values().map(|n| n.as_u64().unwrap()).sum::<u64>(),
        1200
    );
    for rate in ["mrays_per_s", "msamples_per_s", "peak_rss_bytes", "threads"] {
        assert!(record[rate].as_f64().unwrap() > 0.0, "{rate}");
    }

    // What the picture says of itself.
    let decoder =
        png::Decoder::new(std::io::BufReader::new(fs::File::open(here.join("a.png")).unwrap()));
    let reader = decoder.read_info().unwrap();
    let text: Vec<(String, String)> = reader
        .info()
        .utf8_text
        .iter()
        .map(|chunk| (chunk.keyword.clone(), chunk.get_text().unwrap()))
        .collect();
    let get = |key: &str| &text.iter().find(|(k, _)| k == key).unwrap_or_else(|| panic!("{key}")).1;
    assert_eq!(get("ptfast:hash"), hash);
    assert_eq!(get("ptfast:seed"), "7");
    assert!(get("ptfast:settings").contains("\"spp\":3"));
    assert_eq!(get("Software"), concat!("ptfast ", env!("CARGO_PKG_VERSION")));
}

#[test]
fn equal_renders_give_equal_files() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for extension in ["png", "exr", "hdr", "pfm"] {
        let names = [format!("a.{extension}"), format!("b.{extension}")];
        for (name, threads) in names.iter().zip(["1", "3"]) {
            let arguments = [&SMALL[..], &["20", "-o", name, "--threads", threads]];
            succeeds(here, &arguments.concat());
        }
        let bytes = |name: &String| fs::read(here.join(name)).unwrap();
        assert_eq!(bytes(&names[0]), bytes(&names[1]), "{extension}");
        let same = ptfast(here, &["compare", &names[0], &names[1]]);
        assert_eq!(same.status.code(), Some(0));
        assert!(stdout(&same).contains("identical        yes"));
    }
    let exr = fs::read(here.join("a.exr")).unwrap();
    let text = String::from_utf8_lossy(&exr);
    assert!(text.contains("ptfast:hash: ") && text.contains("ptfast:seed: 1"));
}

#[test]
fn one_side_keeps_the_proportion() {
    let folder = tempfile::tempdir().unwrap();
    for (side, length) in [("--width", "64"), ("--height", "36")] {
        let arguments = ["render", "--scene", "spheres", "--spp", "1", side, length];
        assert!(succeeds(folder.path(), &arguments).contains(" 64 x 36,"));
    }
    assert!(folder.path().join("spheres.png").exists(), "the default target");
}

/// Each worker's stages, one after the other, within its tiles; all the work, and the same image.
#[test]
fn traces_tell_what_each_worker_did() {
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

#[test]
fn compare_measures_and_paints() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for (name, seed) in [("a.pfm", "1"), ("b.pfm", "2")] {
        succeeds(here, &[&SMALL[..], &["20", "-o", name, "--seed", seed]].concat());
    }
    let output =
        ptfast(here, &["compare", "a.pfm", "b.pfm", "--heatmap", "h.png", "--display", "2"]);
    assert_eq!(output.status.code(), Some(1), "different");
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
fn a_failed_render_keeps_the_old_target() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("out.png"), "precious").unwrap();
    fs::write(folder.path().join("bad.ron"), "(").unwrap();
    let output = ptfast(folder.path(), &["render", "--scene", "bad.ron", "-o", "out.png"]);
    assert_eq!(output.status.code(), Some(65));
    assert_eq!(fs::read_to_string(folder.path().join("out.png")).unwrap(), "precious");
}

#[test]
fn scenes_are_listed_shown_and_checked() {
    let folder = tempfile::tempdir().unwrap();
    let list = succeeds(folder.path(), &["scenes"]);
    assert_eq!(list, succeeds(folder.path(), &["scenes", "list"]));
    assert_eq!(list.lines().count(), 4);
    assert!(list.contains("cornell") && list.contains("18 quads"));
    let ron = succeeds(folder.path(), &["scenes", "show", "cornell"]);
    fs::write(folder.path().join("mine.ron"), ron).unwrap();
    let json = succeeds(folder.path(), &["scenes", "show", "mine.ron", "--json"]);
    fs::write(folder.path().join("mine.json"), json).unwrap();
    let check = succeeds(folder.path(), &["scenes", "check", "mine.json"]);
    assert!(check.contains("18 quads"), "{check}");
}

#[test]
fn progress_is_quiet_when_asked() {
    let folder = tempfile::tempdir().unwrap();
    let output = ptfast(folder.path(), &[&SMALL[..], &["20", "--quiet"]].concat());
    assert_eq!(stderr(&output), "");
    let help = succeeds(folder.path(), &["render", "--help"]);
    for flag in ["--scene", "--width", "--spp", "--sampling", "--roulette", "--gamma", "--json"] {
        assert!(help.contains(flag), "{flag}");
    }
}

/// Six pictures of the right size and a page that shows each with its caption and times.
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
    assert!(page.contains("about 3 minutes for 100 samples a pixel"), "{page}");
    assert!(page.contains("clamped to [0, 1]"));
}

/// A small ray set in `set` of folder `here`.
fn small_ray_set(here: &Path, scene: &str) {
    let most = ["--spp", "1", "--max-rays", "4096"];
    succeeds(here, &[&["rays", "--scene", scene, "--out", "set"][..], &most].concat());
}

#[test]
fn rays_are_written_as_other_programs_read_them_and_traced_to_the_same_hits() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for (scene, sets, primitives) in [
        ("spacetime", &["primary", "bounce"][..], [488, 0, 0]),
        ("cornell", &["primary", "bounce", "shadow"], [0, 18, 0]),
        ("mesh:20480", &["primary", "bounce"], [0, 0, 20_482]),
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
            assert!((2048..=4096).contains(&rays), "{scene} {name}: {rays}");
            for (extension, size) in [("rays", 24), ("range", 8), ("hits", 8)] {
                assert_eq!(bytes(format!("{name}.{extension}")), rays * size);
            }
            assert_eq!(set.join(format!("{name}.time")).exists(), scene == "spacetime");
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
        let chosen = succeeds(here, &["trace", "set", "--reps", "1", "--kernel", "auto"]);
        assert!(chosen.contains("choice  primary"), "{chosen}");
        fs::remove_dir_all(set).unwrap();
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
    let output = ptfast(here, &["trace", "set", "--reps", "1", "--kernel", "single"]);
    assert_eq!(output.status.code(), Some(1));
    // A notice about the build may come first.
    let (text, last) = (stderr(&output), "ptfast: set: 1 hits differ from the set's");
    assert_eq!(text.lines().last(), Some(last), "{text}");
}

#[test]
fn the_rays_of_a_render_are_recorded_all() {
    let scene = ptfast::Scene::load("cornell").unwrap();
    let settings = ptfast::RenderSettings {
        width: 37,
        height: 21,
        spp: 5,
        ..ptfast::RenderSettings::of(&scene)
    };
    let sets = ptfast::rayset::record(&scene, &settings, u64::MAX).unwrap();
    let counts: Vec<u64> = sets.sets.iter().map(|set| set.rays.len() as u64).collect();
    let rays = ptfast::Renderer::new(&scene, settings).unwrap().render().unwrap().tally.rays;
    assert_eq!(counts, [rays.primary, rays.bounce, rays.shadow]);
}

/// A record's plan can be given back; what is none is refused.
#[test]
fn plans_are_given_back() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let base = ["render", "--scene", "cornell", "--width", "30", "--spp", "4", "-o", "a.png"];
    let with = |more: &[&str]| ptfast(here, &[&base[..], more].concat());
    let first = with(&["--json", "a.json", "--wave-size", "100", "--stats"]);
    assert!(first.status.success(), "{}", stderr(&first));
    let again = with(&["--plan", "a.json", "--json", "b.json", "--stats"]);
    assert!(again.status.success(), "{}", stderr(&again));
    assert!(stderr(&again).contains("plan: waves of 100,"), "{}", stderr(&again));
    // The same work, down to the boxes and primitives that are tested.
    let counts = |file: &str| {
        let text = fs::read_to_string(here.join(file)).unwrap();
        let mut record: serde_json::Value = serde_json::from_str(&text).unwrap();
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
    // The tables tell rays and endings to the last one.
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
    for more in [["--wave-size", "9"], ["--tile-size", "9"], ["--engine", "scalar"]] {
        let both = with(&[&["--plan", "a.json"], &more[..]].concat());
        assert_eq!(both.status.code(), Some(2), "{more:?}");
    }
    for (text, place) in [
        ("{", "bad.json:1:"),
        ("{\"plan\": 3}", "bad.json:plan: neither a plan nor"),
        ("{\"a\": 3}", "bad.json:plan: neither a plan nor"),
        ("{\"plan\": null}", "bad.json:plan: the record has none"),
        (
            "{\"wave_size\": 0, \"tile_size\": 8, \"segments\": []}",
            "bad.json:plan: wave_size must be",
        ),
    ] {
        fs::write(here.join("bad.json"), text).unwrap();
        let bad = with(&["--plan", "bad.json"]);
        assert_eq!(bad.status.code(), Some(65), "{text}");
        assert!(stderr(&bad).contains(place), "{}", stderr(&bad));
    }
}

/// Whether threads are pinned is told; and no picture is lost to a record of the same name.
#[test]
fn pins_and_files_are_what_was_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let base = ["render", "--scene", "cornell", "--width", "9", "--spp", "1", "-o", "a.png"];
    let with = |more: &[&str]| ptfast(here, &[&base[..], more].concat());
    for (pin, told) in [("on", ["yes", "failed"]), ("off", ["no", "no"])] {
        let output = with(&["--pin", pin, "--json", "a.json"]);
        assert!(output.status.success(), "{}", stderr(&output));
        let text = fs::read_to_string(here.join("a.json")).unwrap();
        let record: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert!(told.contains(&record["pinned"].as_str().unwrap()), "{pin}");
    }
    let refused = |more: &[&str], message: &str| {
        let output = with(more);
        assert_eq!(output.status.code(), Some(2), "{more:?}");
        assert!(stderr(&output).contains(message), "{}", stderr(&output));
    };
    let picture = fs::read(here.join("a.png")).unwrap();
    let absolute = here.join("a.png");
    for record in ["a.png", "./a.png", absolute.to_str().unwrap()] {
        refused(&["--json", record], "need two files");
        assert_eq!(fs::read(here.join("a.png")).unwrap(), picture);
    }
    // Neither is there yet.
    fs::remove_file(here.join("a.png")).unwrap();
    refused(&["--json", "./a.png"], "need two files");
    let scene = ptfast(here, &["scenes", "show", "cornell"]).stdout;
    fs::write(here.join("my.ron"), &scene).unwrap();
    let same = ["render", "--scene", "my.ron", "--json", "./my.ron"];
    let output = ptfast(here, &same);
    assert!(stderr(&output).contains("would replace the scene"), "{}", stderr(&output));
    // A built-in scene is no file.
    assert!(with(&["--json", "cornell"]).status.success());
    assert_eq!(fs::read(here.join("my.ron")).unwrap(), scene);
}

/// One sample, ray by ray: the one that the render counts.
#[test]
fn paths_are_told_ray_by_ray() {
    let folder = tempfile::tempdir().unwrap();
    let size = ["--scene", "cornell", "--width", "1", "--height", "1", "--seed", "5"];
    let render =
        [&["render", "--spp", "1", "-q", "-o", "a.pfm", "--json", "a.json"], &size[..]].concat();
    assert!(ptfast(folder.path(), &render).status.success());
    let record: serde_json::Value =
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
    let outside = ptfast(folder.path(), &[&["path", "--pixel", "1,0"], &size[..]].concat());
    assert_eq!(outside.status.code(), Some(2));
    assert!(stderr(&outside).contains("--pixel must be within 1 x 1, is 1,0"));
}

/// Clamping is asked for, told, and part of what decides the image.
#[test]
fn clamping_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let base =
        ["render", "--scene", "cornell", "--width", "20", "--spp", "8", "-q", "--json", "a.json"];
    let run = |more: &[&str], file: &str| {
        let output = ptfast(folder.path(), &[&base[..], more, &["-o", file]].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        let record: serde_json::Value =
            serde_json::from_slice(&std::fs::read(folder.path().join("a.json")).unwrap()).unwrap();
        (record, stderr(&output))
    };
    let (plain, quiet) = run(&[], "a.exr");
    assert_eq!((&plain["clamp"], &plain["clamped"]), (&serde_json::Value::Null, &0.into()));
    assert_eq!(quiet, "");
    let (clamped, told) = run(&["--clamp", "1"], "b.exr");
    let count = clamped["clamped"].as_u64().unwrap();
    assert!(count > 0, "{clamped}");
    assert_eq!(told, format!("ptfast: {count} samples were clamped to 1\n"));
    assert!(clamped["mean"][0].as_f64() < plain["mean"][0].as_f64());
    let (scalar, _) = run(&["--clamp", "1", "--engine", "scalar"], "c.exr");
    assert_eq!((&scalar["hash"], &scalar["clamped"]), (&clamped["hash"], &clamped["clamped"]));
    let wrong = ptfast(folder.path(), &[&base[..], &["--clamp", "0", "-o", "d.exr"]].concat());
    assert_eq!(wrong.status.code(), Some(2));
    assert!(stderr(&wrong).contains("clamp must be above 0, is 0"), "{}", stderr(&wrong));
}
