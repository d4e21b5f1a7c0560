//! Tests of bad input.
//!
//! The program must print one line that names the file and the place and says what would be right,
//! exit with the code for this kind of error, and leave no file behind.

use std::fs;
use std::path::Path;

use crate::common::{ptfast, stderr, stdout};

/// A valid scene, into which the tests insert faults.
const GOOD: &str = r#"(
    camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 40),
    materials: {
        "grey": lambertian(albedo: (0.5, 0.5, 0.5)),
    },
    primitives: [
        sphere(center: (0, 0, 0), radius: 1, material: "grey"),
        quad(q: (0, 0, 0), u: (1, 0, 0), v: (0, 1, 0), material: "grey"),
    ],
)"#;

const GOOD_JSON: &str = r#"{
    "camera": {"look_from": [0, 0, 5], "look_at": [0, 0, 0], "vfov": 40},
    "materials": {"grey": {"lambertian": {"albedo": [0.5, 0.5, 0.5]}}},
    "primitives": [
        {"sphere": {"center": [0, 0, 0], "radius": 1, "material": "grey"}}
    ]
}"#;

/// Checks that the program fails with `code` and one line that contains all `parts`, and adds no
/// file to the folder.
#[track_caller]
fn fails(folder: &Path, arguments: &[&str], code: i32, parts: &[&str]) {
    let files = || fs::read_dir(folder).map_or(0, Iterator::count);
    let before = files();
    let output = ptfast(folder, arguments);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
    assert_eq!(message.lines().count(), 1, "{arguments:?}: {message}");
    assert!(message.starts_with("ptfast: "), "{message}");
    for part in parts {
        assert!(message.contains(part), "{arguments:?}: `{part}` is missing in: {message}");
    }
    assert_eq!(stdout(&output), "", "{arguments:?}");
    assert_eq!(files(), before, "{arguments:?} left a file behind");
}

/// Replaces `from` by `to` in the scene `good`, and checks that the result is rejected at `place`.
#[track_caller]
fn refused(name: &str, good: &str, from: &str, to: &str, place: &str, parts: &[&str]) {
    assert!(good.contains(from), "{from}");
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(name), good.replacen(from, to, 1)).unwrap();
    let place = format!("ptfast: {name}{place}");
    let parts: Vec<&str> = [place.as_str()].into_iter().chain(parts.iter().copied()).collect();
    let render = ["render", "--scene", name, "-o", "out.png", "--spp", "1"];
    // A file that cannot be read has the code of the operating system's errors.
    let code = if parts.iter().any(|part| part.contains("cannot read")) { 74 } else { 65 };
    fails(folder.path(), &render, code, &parts);
    fails(folder.path(), &["scenes", "check", name], code, &parts);
}

#[test]
fn the_scenes_without_faults_are_accepted() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("a.ron", GOOD), ("a.json", GOOD_JSON)] {
        fs::write(folder.path().join(name), text).unwrap();
        let output = ptfast(folder.path(), &["scenes", "check", name]);
        assert!(output.status.success(), "{}", stderr(&output));
    }
}

#[test]
fn syntax_and_names_in_ron() {
    let ron = |from, to, place, parts: &[&str]| refused("a.ron", GOOD, from, to, place, parts);
    ron("vfov: 40),", "vfov: 40],", ":2:", &["RON syntax"]);
    ron("vfov: 40", "vfov: forty", ":2:", &["RON syntax", "float"]);
    ron("radius: 1", "raduis: 1", ":7:", &["unknown field `raduis`, did you mean `radius`?"]);
    ron("sphere(", "shpere(", ":7:", &["unknown kind `shpere`, did you mean `sphere`?"]);
    ron("radius: 1, ", "", ":7:", &["the field `radius` is missing"]);
    ron("radius: 1, ", "radius: 1, radius: 2, ", ":7:", &["`radius` is given twice"]);
    ron("albedo: (0.5, 0.5, 0.5)", "albedo: (0.5, 0.5)", ":4:", &["three numbers"]);
    let twice = "\"grey\": dielectric(ior: 1.5), \"grey\": lambertian";
    ron("\"grey\": lambertian", twice, ":4:", &["`grey` is used twice"]);
    let grey = "material: \"grey\"";
    let message = "unknown material `gray`, did you mean `grey`?";
    ron(grey, "material: \"gray\"", ":7:9: primitives[0]", &["sphere: ", message]);
    ron("(0.5, 0.5, 0.5)", "\"wood\"", ":4:", &["unknown texture `wood`, none is defined"]);
}

#[test]
fn syntax_and_names_in_json() {
    let json =
        |from, to, place, parts: &[&str]| refused("a.json", GOOD_JSON, from, to, place, parts);
    json("\"vfov\": 40}", "\"vfov\": 40]", ":2:", &["JSON syntax"]);
    json("\"vfov\": 40", "\"vfov\": 1e999", ":2:", &["out of range"]);
    json("\"radius\"", "\"raduis\"", ":5:", &["unknown field `raduis`, did you mean `radius`?"]);
    json("\"sphere\"", "\"shpere\"", ":5:", &["unknown kind `shpere`, did you mean `sphere`?"]);
    json("\"radius\": 1, ", "", ":5:", &["the field `radius` is missing"]);
    json("\"vfov\": 40", "\"vfov\": true", ":2:", &["expected a number"]);
}

#[test]
fn the_flat_form_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("a.txt"),
        "size 8 8
",
    )
    .unwrap();
    let parts = ["a.txt: scenes are .ron or .json files"];
    fails(folder.path(), &["render", "a.txt", "-o", "out.png"], 2, &parts);
}

#[test]
fn values_out_of_range() {
    let ron = |from, to, place, parts: &[&str]| refused("a.ron", GOOD, from, to, place, parts);
    let ball = ":7:9: primitives[0]";
    ron("radius: 1", "radius: -1", ball, &["sphere: radius must be above 0", "is -1.0"]);
    ron("radius: 1", "radius: 0", ball, &["is 0.0"]);
    ron("radius: 1", "radius: NaN", ball, &["is NaN"]);
    ron("radius: 1", "radius: inf", ball, &["is inf"]);
    ron("center: (0, 0, 0)", "center: (0, NaN, 0)", ball, &["center must be finite"]);
    ron("center: (0, 0, 0)", "center: (0, 1e30, 0)", ball, &["within ±1e9"]);
    ron("u: (1, 0, 0)", "u: (0, 2, 0)", ":8:9: primitives[1]", &["edges must span an area"]);
    ron("u: (1, 0, 0)", "u: (0, 0, 0)", ":8:9: primitives[1]", &["edges must span an area"]);
    ron("look_at: (0, 0, 0)", "look_at: (0, 0, 5)", "", &["look_from and look_at must differ"]);
    ron("vfov: 40", "vfov: 40, up: (0, 0, 1)", "", &["camera: up must not be"]);
    ron("vfov: 40", "vfov: 180", "", &["camera: vfov must be in (0, 180) degrees"]);
    ron("vfov: 40", "vfov: 40, shutter: (1, 0)", "", &["camera: shutter must be"]);
    ron("vfov: 40", "vfov: 40, focus_distance: 0", "", &["camera: focus_distance must be"]);
    for (filter, message) in [
        ("triangle(radius: 0)", "camera: filter: radius must be in [0.1, 16], is 0.0"),
        ("gaussian(sigma: NaN)", "camera: filter: sigma must be in [radius/4, 16], is NaN"),
        ("mitchell(b: -1)", "camera: filter: b must be in [0, 1], is -1.0"),
        ("mitchell(c: 2)", "camera: filter: c must be in [0, 1], is 2.0"),
        ("blackman_harris(radius: 17)", "camera: filter: radius must be in [0.1, 16], is 17.0"),
        ("gausian()", "unknown kind `gausian`, did you mean `gaussian`?"),
        ("gaussian(width: 1)", "unknown field `width`"),
    ] {
        let with = format!("vfov: 40, filter: {filter}");
        refused("a.ron", GOOD, "vfov: 40", &with, ":2:", &[message]);
    }
    ron("(0.5, 0.5, 0.5)", "(0.5, 1.5, 0.5)", ":4:", &["albedo must be in [0, 1]"]);
    let metal = "metal(albedo: (1, 1, 1), fuzz: 2)";
    ron("lambertian(albedo: (0.5, 0.5, 0.5))", metal, ":4:", &["fuzz must be in"]);
    let glass = "dielectric(ior: 0)";
    ron("lambertian(albedo: (0.5, 0.5, 0.5))", glass, ":4:", &["ior must be in"]);
    let lamp = "light(radiance: (-1, 0, 0))";
    ron("lambertian(albedo: (0.5, 0.5, 0.5))", lamp, ":4:", &["radiance must be"]);
    ron("materials:", "render: (width: 0), materials:", "", &["render: width must be in 1 to"]);
    ron(
        "materials:",
        "render: (roulette: 0), materials:",
        "",
        &["render: roulette must be in 1 to"],
    );
    let absurd = "render: (width: 1000000000, height: 1000000000), materials:";
    ron("materials:", absurd, "", &["render: width must be in 1 to 65536"]);
    let sky = "background: constant(radiance: (0, NaN, 0)), materials:";
    ron("materials:", sky, "", &["background: radiance must be"]);
    let picture = r#"textures: {"p": image(file: "nosuch.png")}, materials:"#;
    ron("materials:", picture, ":3:19: textures.p", &["nosuch.png: cannot read"]);
    let first = ":6:18: primitives[0]";
    let triangles =
        r#"primitives: [triangles(vertices: [(0, 0, 0)], indices: [(0, 1, 2)], material: "grey"),"#;
    ron("primitives: [", triangles, first, &["indices[0] must be below the number of vertices 1"]);
    let triangles =
        r#"primitives: [triangles(vertices: [(0, inf, 0)], indices: [], material: "grey"),"#;
    ron("primitives: [", triangles, first, &["vertices[0] must be finite"]);
    for (fields, says) in [
        (
            "normals: [(0, 0, 1), (0, 0, 1)]",
            "normals must be as many as vertices, which are 1, or none, are 2",
        ),
        ("normals: [(0, 0, inf)]", "normals[0] must be finite"),
        ("uvs: [(0, inf)]", "uvs[0] must be finite"),
    ] {
        let triangles = r#"primitives: [triangles(vertices: [(0, 0, 0)], indices: [], "#;
        let triangles = format!(r#"{triangles}{fields}, material: "grey"),"#);
        refused("a.ron", GOOD, "primitives: [", &triangles, first, &[says]);
    }
    let flat_box = r#"primitives: [box(min: (0, 0, 0), max: (1, 0, 1), material: "grey"),"#;
    ron("primitives: [", flat_box, first, &["box: max must be above min"]);
}

#[test]
fn values_of_materials_and_media_are_checked() {
    for (material, message) in [
        ("dielectric(ior: 1.5, fresnel: fast)", "unknown kind `fast`, known: `schlick`"),
        ("rough_dielectric(ior: 1, alpha: 0.5)", "ior must be in [0.01, 0.99] or [1.01, 100]"),
        ("rough_dielectric(ior: 1.5, alpha: 0)", "alpha must be in [0.001, 1]"),
        ("rough_dielectric(ior: 1.5, alpha: (texture: \"t\"))", "unknown texture `t`"),
        ("dielectric(ior: 1.5, opacity: blend(alpha: 7))", "alpha must be in [0, 1]"),
        ("conductor(eta: (1, 1, 1), k: (1, 1, 1), alpha: 2)", "alpha must be in [0, 1], is 2.0"),
        ("conductor(eta: (0, 1, 1), k: (0, 1, 1))", "k must be at least 0.001 in channels"),
        ("conductor(eta: (0, 0, 0), k: (0, 0, 0))", "k must be at least 0.001 in channels"),
        ("conductor(eta: (1, 1, 101), k: (1, 1, 1))", "eta must be in [0, 100]"),
        ("principled(ior: 1)", "ior must be in [1.01, 1000]"),
        ("principled(metalness: -1)", "metalness must be in [0, 1]"),
        ("principled(base_color: (2, 0, 0))", "base_color must be in [0, 1]"),
        ("principled(attenuation_color: (0, 1, 1))", "attenuation_color must be in (0, 1] per"),
        ("principled(attenuation_distance: 0)", "attenuation_distance must be above 0"),
        ("principled(roughness: (texture: \"t\", channel: q))", "unknown kind `q`"),
        ("principled(roughness: (texture: \"t\"))", "unknown texture `t`"),
        ("coated_diffuse(reflectance: (1, 1, 1), ior: 0.5)", "ior must be in [1.01, 10]"),
        (
            "diffuse_transmission(reflectance: (1, 0, 0), transmittance: (0.1, 0, 0))",
            "the sum of reflectance and transmittance must be at most 1 per channel",
        ),
        (
            "lambertian(albedo: (1, 1, 1), opacity: mask(alpha: 0.5, threshold: 2))",
            "threshold must be in [0, 1]",
        ),
        ("lambertian(albedo: (1, 1, 1), opacity: blend(alpha: 7))", "alpha must be in [0, 1]"),
    ] {
        let place = if message.starts_with("unknown") { ":4" } else { ":4:15: materials.grey" };
        refused("s.ron", GOOD, "lambertian(albedo: (0.5, 0.5, 0.5))", material, place, &[message]);
    }
    let holes = "lambertian(albedo: (1, 1, 1), opacity: blend(alpha: 0.5))";
    let message = "a material with `opacity` can only be that of triangles";
    let grey = "lambertian(albedo: (0.5, 0.5, 0.5))";
    refused("s.ron", GOOD, grey, holes, ":7:9: primitives[0]", &[message]);
    for (light, message) in [
        ("point(position: (0, inf, 0), intensity: (1, 1, 1))", "position must be finite"),
        ("point(position: (0, 0, 0), intensity: (1, -1, 1))", "intensity must be in [0, 1e30]"),
        (
            "spot(position: (0, 1, 0), look_at: (0, 1, 0), intensity: (1, 1, 1), outer: 9)",
            "position and look_at must differ",
        ),
        (
            "spot(position: (0, 1, 0), look_at: (0, 0, 0), intensity: (1, 1, 1), outer: 9, inner: 9)",
            "inner must be at least 0 and below `outer`",
        ),
        ("distant(direction: (0, 0, 0), irradiance: (1, 1, 1))", "direction must not be zero"),
        (
            "distant(direction: (0, 1, 0), irradiance: (1, 1, 1), angle: 180)",
            "angle must be in [0, 180) degrees",
        ),
    ] {
        let lights = format!("lights: [{light}], materials:");
        refused("s.ron", GOOD, "materials:", &lights, ":3:14: lights[0]", &[message]);
    }
    for (image, message) in [
        ("image(file: \"p.png\", wrap_u: fold)", "unknown kind `fold`"),
        ("image(file: \"p.png\", scale: (inf, 1))", "scale must be within ±1e9"),
        ("image(file: \"p.png\", uv: 2)", "uv must be 0 or 1"),
    ] {
        let textures = format!("textures: {{\"p\": {image}}}, materials:");
        refused("s.ron", GOOD, "materials:", &textures, ":3:", &[message]);
    }
    for (sky, message) in [
        ("image(file: \"nosuch.hdr\")", "nosuch.hdr: cannot read"),
        ("image(file: \"nosuch.hdr\", scale: -1)", "scale must be in [0, 1e30]"),
        ("image(file: \"nosuch.hdr\", rotation: (0, inf, 0))", "rotation must be finite"),
        ("image(file: \"nosuch.hdr\", mapping: cube)", "unknown kind `cube`"),
    ] {
        let background = format!("background: {sky}, materials:");
        refused("s.ron", GOOD, "materials:", &background, "", &[message]);
    }
    let ball_of_fog = "sphere(center: (0, 0, 0), radius: 1, density: 0.5, albedo: (1, 1, 1))";
    for (media, place, message) in [
        (
            "sphere(center: (0, 0, 0), radius: 0, density: 1, albedo: (1, 1, 1))",
            0,
            "radius must be",
        ),
        (
            "sphere(center: (0, 0, 0), radius: 1, density: 0, albedo: (1, 1, 1))",
            0,
            "density must be",
        ),
        (
            "sphere(center: (0, 0, 0), radius: 1, density: 1, albedo: (1, 2, 1))",
            0,
            "albedo must be",
        ),
        (
            "box(min: (0, 0, 0), max: (1, 0, 1), density: 1, albedo: (1, 1, 1))",
            0,
            "max must be above",
        ),
        (&format!("{ball_of_fog}, {ball_of_fog}"), 1, "overlaps media[0]"),
        (
            &format!(
                "{ball_of_fog}, box(min: (0.9, 0, 0), max: (2, 1, 1), density: 1, albedo: (0, 0, 0))"
            ),
            1,
            "overlaps media[0], media must not overlap",
        ),
    ] {
        let with = format!("media: [{media}], materials:");
        let place = format!("media[{place}]: medium");
        refused("s.ron", GOOD, "materials:", &with, ":3:", &[&place, message]);
    }
}

#[test]
fn missing_files_and_non_files() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    fs::create_dir(here.join("folder.ron")).unwrap();
    fs::write(here.join("binary.ron"), b"\xff\xfe\x00").unwrap();
    fs::write(here.join("empty.json"), "").unwrap();
    let render = |scene| ["render", "--spp", "1", "--scene", scene];
    #[cfg(unix)]
    {
        fs::write(here.join("name\u{1b}[2J.json"), "{").unwrap();
        fails(here, &render("name\u{1b}[2J.json"), 65, &["name\\u{1b}[2J.json:1:1: JSON syntax"]);
        std::os::unix::fs::symlink("/dev/zero", here.join("zero.ron")).unwrap();
        fails(here, &render("zero.ron"), 74, &["zero.ron: cannot read: it is a device or pipe"]);
    }
    fails(here, &render("nosuch.ron"), 74, &["nosuch.ron: cannot read"]);
    fails(here, &render("folder.ron"), 74, &["folder.ron: cannot read", "directory"]);
    fails(here, &render("."), 74, &["cannot read", "directory"]);
    fails(here, &render("binary.ron"), 65, &["binary.ron: not UTF-8"]);
    fails(here, &render("empty.json"), 65, &["empty.json:1:0: JSON syntax"]);
    fails(here, &render("spheers"), 2, &["`spheers`", "did you mean `spheres`?"]);
    fails(here, &render("scene.xyz"), 2, &["`scene.xyz`", ".gltf, .glb or .pbrt"]);
    fails(here, &["compare", "a.png", "b.png"], 74, &["a.png: cannot read"]);
    fails(here, &["compare", "empty.json", "b.png"], 65, &["empty.json", "PNG"]);
}

#[test]
fn wrong_usage() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = |arguments: &[&str], parts: &[&str]| {
        let all = [&["render", "--scene", "cornell"], arguments].concat();
        fails(folder.path(), &all, 2, parts);
    };
    wrong(&["--width", "0"], &["--width", "0 is not in 1..=65536"]);
    wrong(&["--spp", "0"], &["--spp"]);
    wrong(&["--depth", "0"], &["--depth"]);
    wrong(&["--roulette", "on"], &["--roulette", "must be auto, off or a number from 1 to 65536"]);
    wrong(&["--threads", "0"], &["--threads"]);
    wrong(&["--width", "1000000000", "--height", "1000000000"], &["--width"]);
    wrong(
        &["--width", "65536", "--height", "65536"],
        &["the limit of pixels is 268435456, this needs 4294967296"],
    );
    wrong(&["--spp", "many"], &["invalid value 'many' for '--spp <N>'"]);
    wrong(&["--sampling", "lihgt"], &["invalid value 'lihgt'", "bsdf, light, mis"]);
    wrong(&["--spp", "1e3"], &["invalid value '1e3' for '--spp <N>': must be a whole number"]);
    wrong(&["--width", "640x480"], &["use --width 640 --height 480"]);
    wrong(&["-spp", "4"], &["unexpected argument '-spp' found, use --spp"]);
    wrong(&["--wdith", "3"], &["unexpected argument '--wdith'", "'--width'"]);
    wrong(&["-o", "out.jpeg"], &["out.jpeg: no writer for the extension `jpeg`, use .png"]);
    wrong(&["-o", "out"], &["no writer for the extension ``"]);
    wrong(&["-o", "a.png", "--json", "a.png"], &["a.png: the image and the record need different"]);
    fails(folder.path(), &["render"], 2, &["<SCENE>", "`ptfast render --help`"]);
    for scene in ["bunny.glb", "spheres"] {
        fails(folder.path(), &[scene], 2, &[&format!("`ptfast render {scene}` renders")]);
    }
    fails(folder.path(), &["rendr"], 2, &["unrecognized subcommand 'rendr'", "render"]);
    fails(
        folder.path(),
        &[],
        2,
        &[
            "a command is missing: render, view, merge, denoise, scenes, figures, compare, rays, path, trace, bench, converge, dashboard",
        ],
    );
}

#[test]
fn targets_that_cannot_be_written() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    fs::create_dir(here.join("folder.png")).unwrap();
    fs::write(here.join("file"), "").unwrap();
    // The error must come before the first ray: renders of these sizes would take hours.
    let render = |target| {
        ["render", "--scene", "spheres", "--width", "9999", "--spp", "99999", "-o", target]
    };
    fails(
        here,
        &render("nosuch/out.png"),
        74,
        &["nosuch/out.png: cannot write: No such file or directory"],
    );
    fails(here, &render("folder.png"), 74, &["folder.png: cannot write: it is a folder"]);
    fails(here, &render("file/out.png"), 74, &["file/out.png: cannot write"]);
    let json = ["render", "--scene", "spheres", "--spp", "99999", "--json", "nosuch/record.json"];
    fails(here, &json, 74, &["nosuch/record.json: cannot write"]);
    let figures = ["figures", "--out", "file"];
    fails(here, &figures, 74, &["file: cannot create the folder"]);
    let rays = |out| ["rays", "--scene", "cloud:9000000", "--max-rays", "200000000", "--out", out];
    fails(here, &rays("file"), 74, &["file: cannot create the folder"]);
    fails(here, &rays("file/set"), 74, &["file/set: cannot create the folder"]);
    let many = ["rays", "--scene", "spheres", "--max-rays", "9999999999", "--out", "set"];
    fails(here, &many, 2, &["9999999999", "2048..=268435456"]);
}

#[test]
fn damaged_ray_sets_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let rays = ["rays", "--scene", "checker", "--out", "set", "--spp", "1", "--max-rays", "2048"];
    assert!(crate::common::ptfast(here, &rays).status.success());
    let trace = ["trace", "set", "--reps", "1"];
    fails(here, &["trace", "nosuch"], 74, &["nosuch/manifest.json: cannot read"]);
    let damage = |file: &str, change: fn(&mut Vec<u8>), code: i32, words: &[&str]| {
        let path = here.join("set").join(file);
        let whole = fs::read(&path).unwrap();
        let mut damaged = whole.clone();
        change(&mut damaged);
        fs::write(&path, damaged).unwrap();
        fails(here, &trace, code, words);
        fs::write(&path, whole).unwrap();
    };
    damage(
        "primary.rays",
        |b| b.truncate(99),
        65,
        &["primary.rays: has 99 bytes, but manifest.json"],
    );
    damage("primary.hits", |b| b[5] = 7, 65, &["primary.hits:[0]: primitive", "there are 3"]);
    damage("spheres.f32", |b| b[12..16].fill(0), 65, &["spheres.f32:[0]: the radius"]);
    damage("spheres.f32", |b| b[0..4].fill(255), 65, &["spheres.f32:[0]", "not finite"]);
    damage(
        "primary.range",
        |b| b[0..4].copy_from_slice(&(-1f32).to_le_bytes()),
        65,
        &["primary.range:[0]: t_min"],
    );
    let rename =
        |b: &mut Vec<u8>| *b = String::from_utf8_lossy(b).replace("bounce", "../abc").into();
    damage("manifest.json", rename, 65, &["manifest.json:sets[1]: the name must be primary"]);
    let twice =
        |b: &mut Vec<u8>| *b = String::from_utf8_lossy(b).replace("bounce", "primary").into();
    damage("manifest.json", twice, 65, &["manifest.json:sets[1]: each set must be listed once"]);
    let kind =
        |b: &mut Vec<u8>| *b = String::from_utf8_lossy(b).replace("closest", "occluded").into();
    damage("manifest.json", kind, 65, &["manifest.json:sets[0]: the kind must be closest"]);
    let none = |b: &mut Vec<u8>| {
        let text = String::from_utf8_lossy(b);
        let (before, rest) = text.split_once("\"sets\":[").unwrap();
        let (_, after) = rest.split_once(']').unwrap();
        *b = format!("{before}\"sets\":[]{after}").into();
    };
    damage("manifest.json", none, 65, &["manifest.json:sets: there must be at least one"]);
    let many = |b: &mut Vec<u8>| {
        *b = String::from_utf8_lossy(b).replace("\"quads\":0", "\"quads\":40000000").into();
    };
    damage("manifest.json", many, 65, &["manifest.json:counts: at most 33554432 primitives"]);
    damage("manifest.json", |b| b[3] = 0xff, 65, &["manifest.json: not UTF-8 text"]);
    damage("manifest.json", |b| b[0] = b'x', 65, &["manifest.json:1:1: "]);
    fs::remove_file(here.join("set/bounce.range")).unwrap();
    fails(here, &trace, 74, &["bounce.range: cannot read"]);
    // In scenes with motion, rays have a time.
    let rays = ["rays", "--scene", "spacetime", "--out", "set", "--spp", "1", "--max-rays", "2048"];
    assert!(crate::common::ptfast(here, &rays).status.success());
    assert!(crate::common::ptfast(here, &trace).status.success());
    fs::remove_file(here.join("set/bounce.time")).unwrap();
    fails(here, &trace, 74, &["bounce.time: cannot read"]);
    #[cfg(target_os = "linux")]
    {
        fs::remove_file(here.join("set/quads.f32")).unwrap();
        std::os::unix::fs::symlink("/dev/zero", here.join("set/quads.f32")).unwrap();
        fails(here, &trace, 74, &["quads.f32: cannot read: it is a device or pipe"]);
        let compare = ["compare", "/dev/zero", "b.png"];
        fails(here, &compare, 74, &["/dev/zero: cannot read: it is a device or pipe"]);
    }
}

#[test]
fn sizes_of_generated_scenes_are_checked() {
    let folder = tempfile::tempdir().unwrap();
    for scene in ["cloud:0", "mesh:-1", "cloud:", "mesh:99999999"] {
        let words = ["the number of", "must be in 1 to 16777216", scene];
        fails(folder.path(), &["scenes", "check", scene], 2, &words);
    }
}

/// A link to a device is rejected like the device itself.
#[test]
#[cfg(target_os = "linux")]
fn devices_are_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink("/dev/full", folder.path().join("full.pfm")).unwrap();
    let render = ["render", "--scene", "cornell", "--spp", "1", "-o", "full.pfm"];
    fails(folder.path(), &render, 74, &["full.pfm: cannot write: it is a device or pipe"]);
    assert!(!fs::metadata("/dev/full").unwrap().is_file());
}

/// If standard output is full, the program prints one line and exits with an error.
#[test]
#[cfg(target_os = "linux")]
fn a_full_standard_output_is_reported() {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_ptfast"))
        .args(["scenes", "list"])
        .stdout(fs::File::options().write(true).open("/dev/full").unwrap())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(74));
    assert!(stderr(&output).starts_with("ptfast: standard output: cannot write"));
    assert_eq!(stderr(&output).lines().count(), 1);
}
