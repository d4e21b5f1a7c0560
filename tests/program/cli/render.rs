//! Tests of `ptfast render`.

use std::fs;

use serde_json::Value;

use super::{SMALL, succeeds};
use crate::common::{ptfast, stderr, stdout};

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

    // The metadata in the picture.
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
    assert!(
        folder.path().join("spheres.png").exists(),
        "the default target must be named after the scene"
    );
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
fn progress_is_quiet_when_asked() {
    let folder = tempfile::tempdir().unwrap();
    let output = ptfast(folder.path(), &[&SMALL[..], &["20", "--quiet"]].concat());
    assert_eq!(stderr(&output), "");
    let help = succeeds(folder.path(), &["render", "--help"]);
    let limits = help.split("\nLimits:").nth(1).unwrap().split("\n\n").next().unwrap();
    assert_eq!(
        limits.matches("\n      --").count(),
        3,
        "the section must list exactly the three limits: {limits}"
    );
    for flag in ["--scene", "--width", "--spp", "--sampling", "--roulette", "--gamma", "--json"] {
        assert!(help.contains(flag), "{flag}");
    }
}

/// The record says whether threads are pinned, and it must not overwrite the picture.
#[test]
fn pinning_is_recorded_and_files_do_not_clash() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let base = ["render", "--scene", "cornell", "--width", "9", "--spp", "1", "-o", "a.png"];
    let with = |more: &[&str]| ptfast(here, &[&base[..], more].concat());
    for (pin, told) in [("on", ["yes", "failed"]), ("off", ["no", "no"])] {
        let output = with(&["--pin", pin, "--json", "a.json"]);
        assert!(output.status.success(), "{}", stderr(&output));
        let text = fs::read_to_string(here.join("a.json")).unwrap();
        let record: Value = serde_json::from_str(&text).unwrap();
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
        refused(&["--json", record], "need different files");
        assert_eq!(fs::read(here.join("a.png")).unwrap(), picture);
    }
    // The same, while neither file exists.
    fs::remove_file(here.join("a.png")).unwrap();
    refused(&["--json", "./a.png"], "need different files");
    let scene = ptfast(here, &["scenes", "show", "cornell"]).stdout;
    fs::write(here.join("my.ron"), &scene).unwrap();
    let same = ["render", "--scene", "my.ron", "--json", "./my.ron"];
    let output = ptfast(here, &same);
    assert!(stderr(&output).contains("would overwrite the scene"), "{}", stderr(&output));
    // A built-in scene is not a file, so a record may have the same name.
    assert!(with(&["--json", "cornell"]).status.success());
    assert_eq!(fs::read(here.join("my.ron")).unwrap(), scene);
}

/// A render must not overwrite the plan and the textures that it reads.
#[test]
fn files_that_are_read_are_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let render = |scene: &str, more: &str| {
        let line = format!("render --scene {scene} --width 8 --spp 2 --quiet -o {more}");
        ptfast(here, &line.split(' ').collect::<Vec<_>>())
    };
    assert!(render("cornell", "k.film --json plan.json").status.success());
    assert!(render("cornell", "albedo.png").status.success());
    fs::write(here.join("globe.ron"), GLOBE).unwrap();
    assert!(render("globe.ron", "globe.png").status.success());
    for (file, scene, more, says) in [
        ("plan.json", "cornell", "b.png --plan plan.json --json plan.json", "the plan"),
        ("albedo.png", "globe.ron", "albedo.png", "a part of the scene"),
    ] {
        let before = fs::read(here.join(file)).unwrap();
        let output = render(scene, more);
        assert_eq!(output.status.code(), Some(2), "{more}");
        let says = format!("would overwrite {says}");
        assert!(stderr(&output).contains(&says), "{more}: {}", stderr(&output));
        assert!(fs::read(here.join(file)).unwrap() == before);
    }
}

const GLOBE: &str = r#"(
    camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 40),
    background: constant(radiance: (1, 1, 1)),
    textures: { "map": image(file: "albedo.png") },
    materials: { "land": lambertian(albedo: "map") },
    primitives: [sphere(center: (0, 0, 0), radius: 1, material: "land")],
)"#;

/// Clamping must be requested. It is reported, and it changes the image.
#[test]
fn clamping_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let base = ["render", "--scene", "cornell", "--width", "20", "--spp", "8", "--json", "a.json"];
    let run = |more: &[&str], file: &str| {
        let output = ptfast(folder.path(), &[&base[..], more, &["-o", file]].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        let record: Value =
            serde_json::from_slice(&std::fs::read(folder.path().join("a.json")).unwrap()).unwrap();
        (record, stderr(&output))
    };
    let (plain, quiet) = run(&[], "a.exr");
    assert_eq!((&plain["clamp"], &plain["clamped"]), (&Value::Null, &0.into()));
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
    assert!(
        stderr(&wrong).contains("clamp must be above 0 and finite, is 0"),
        "{}",
        stderr(&wrong)
    );
}
