//! Faulty scene files.

use super::{Case, Content};

const RON: &str = r#"(
    camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 40),
    textures: {"t": solid(color: (0.5, 0.5, 0.5))},
    materials: {"grey": lambertian(albedo: "t"), "lamp": light(radiance: (1, 1, 1))},
    primitives: [
        sphere(center: (0, 0, 0), radius: 1, material: "grey"),
        quad(q: (0, 0, 0), u: (1, 0, 0), v: (0, 1, 0), material: "lamp"),
    ],
    media: [],
)"#;

const JSON: &str = r#"{
    "camera": {"look_from": [0, 0, 5], "look_at": [0, 0, 0], "vfov": 40},
    "materials": {"grey": {"lambertian": {"albedo": [0.5, 0.5, 0.5]}}},
    "primitives": [{"sphere": {"center": [0, 0, 0], "radius": 1, "material": "grey"}}]
}"#;

/// A case whose scene is `good` with the first `from` replaced by `to`. It must fail with `says`.
fn edited(file: &'static str, good: &str, from: &str, to: &str, says: &str) -> Case {
    assert!(good.contains(from), "{from}");
    let mut case = Case::scene(file, good.replacen(from, to, 1), says);
    case.name = format!("{file}: {from} -> {}", to.chars().take(60).collect::<String>());
    case
}

pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let mut ron = |from: &str, to: &str, says| cases.push(edited("a.ron", RON, from, to, says));
    for number in ["NaN", "inf", "-inf", "1e39", "-1e39", "1e400", "1e10"] {
        ron("center: (0,", &format!("center: ({number},"), "center must be finite");
        ron("radius: 1", &format!("radius: {number}"), "radius must be");
        ron("look_from: (0,", &format!("look_from: ({number},"), "look_from must be finite");
        ron("vfov: 40", &format!("vfov: {number}"), "vfov must be");
        ron(
            "radiance: (1,",
            &format!("radiance: ({}1e31,", "-".repeat(usize::from(number.starts_with('-')))),
            "radiance must be",
        );
        ron("u: (1,", &format!("u: ({number},"), "u must be finite");
        ron("color: (0.5,", &format!("color: ({number},"), "color must be in");
    }
    for (from, to, says) in [
        ("radius: 1", "radius: 0", "radius must be"),
        ("radius: 1", "radius: -0.0", "radius must be"),
        ("radius: 1", "radius: \"1\"", "RON syntax"),
        ("radius: 1", "radius: 1e", "RON syntax"),
        ("radius: 1", "radius: (((((1)))))", "RON syntax"),
        ("v: (0, 1, 0)", "v: (2, 0, 0)", "must span an area"),
        ("look_at: (0, 0, 0)", "look_at: (0, 0, 5)", "must differ"),
        ("look_at: (0, 0, 0)", "look_at: (0, 1, 5)", "up must not be"),
        ("vfov: 40", "vfov: 40, up: (0, 0, 0)", "up must not be"),
        ("vfov: 40", "vfov: 40, shutter: (1, 0)", "shutter must be"),
        ("vfov: 40", "vfov: 40, focus_distance: 0", "focus_distance must be"),
        ("vfov: 40", "vfov: 40, vfov: 40", "given twice"),
        ("\"t\": solid", "\"t\": solid(color: (0, 0, 0)), \"t\": solid", "twice"),
        ("albedo: \"t\"", "albedo: \"u\"", "unknown texture"),
        ("material: \"grey\"", "material: \"gray\"", "did you mean `grey`"),
        ("primitives: [", "primitives: [], primitives: [", "given twice"),
        ("primitives", "primitves", "unknown field"),
        ("sphere(", "orb(", "unknown kind"),
        ("media: []", "media: [(boundary: sphere(center: (0, 0, 0), radius: nan))]", "a.ron"),
        ("media: []", "render: (width: 0)", "width must be in 1"),
        ("media: []", "render: (width: 65537)", "width must be in 1"),
        ("media: []", "render: (width: 65536, height: 65536)", "the limit of pixels"),
        ("media: []", "render: (width: 4294967296)", "RON syntax"),
        ("media: []", "render: (width: -1)", "RON syntax"),
        ("media: []", "render: (spp: 16777217)", "spp must be"),
        ("media: []", "render: (depth: 0)", "depth must be"),
        (")\n", "", "RON syntax"),
    ] {
        if from != ")\n" {
            ron(from, to, says);
        }
    }
    let vertices = "triangles(vertices: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], indices: [";
    for (indices, says) in [
        ("(0, 1, 3)", "indices[0] must be below"),
        ("(0, 1, 4294967295)", "indices[0] must be below"),
        ("(0, 1, 4294967296)", "RON syntax"),
        ("(0, 1, -1)", "RON syntax"),
    ] {
        let to = format!("{vertices}{indices}], material: \"grey\"), quad(");
        cases.push(edited("a.ron", RON, "quad(", &to, says));
    }

    let mut json = |from: &str, to: &str, says| cases.push(edited("a.json", JSON, from, to, says));
    for (from, to, says) in [
        ("[0, 0, 5]", "[0, 0, 1e39]", "number out of range"),
        ("[0, 0, 5]", "[0, 0, NaN]", "JSON syntax"),
        ("[0, 0, 5]", "[0, 0]", "a.json:2"),
        ("[0, 0, 5]", "[0, 0, 5, 6]", "a.json:2"),
        ("[0, 0, 5]", "{}", "a.json:2"),
        ("\"radius\": 1", "\"radius\": 1e999", "JSON syntax"),
        ("\"radius\": 1", "\"radius\": null", "a.json:4"),
        ("\"radius\": 1", "\"radius\": 1, \"radius\": 2", "given twice"),
        ("\"radius\": 1", "\"radius\": 1, \"\\u0007bell\": 2", "unknown field"),
        ("\"grey\"}", "\"\\ud800\"}", "JSON syntax"),
        ("\"vfov\": 40", "\"vfov\": 40,", "JSON syntax"),
        ("}}]\n}", "}}]\n", "JSON syntax"),
        ("}}]\n}", "}}]\n}}", "JSON syntax"),
    ] {
        json(from, to, says);
    }

    // Binary data, and brackets that are never closed.
    for file in ["a.ron", "a.json"] {
        for (content, says) in [
            (&b""[..], "a."),
            (b"\xef\xbb\xbf", "a."),
            (b"\0\0\0\0", "a."),
            (b"\x7fELF\x02\x01\x01", "a."),
            (b"\xff\xfe(\0c\0a\0m\0", "not UTF-8"),
            (b"\x1b]0;title\x07", "a."),
        ] {
            cases.push(Case::scene(file, content, says));
        }
    }
    for (file, bracket) in
        [("a.ron", "("), ("a.ron", "["), ("a.ron", "{"), ("a.json", "["), ("a.json", "{\"a\":")]
    {
        cases.push(Case::scene(file, bracket.repeat(100_000), file));
    }
    let commented = format!("{}{RON}", "/*".repeat(100_000));
    cases.push(Case::scene("a.ron", commented, "RON syntax"));
    cases.push(Case::scene("a.ron", format!("{RON}{}", "a".repeat(100_000)), "RON syntax"));

    // Files that are too large.
    for file in ["a.ron", "a.json"] {
        let empty = |length, says| {
            let mut case = Case::scene(file, "", says).with(file, Content::Sparse(length));
            case.files.remove(0);
            case
        };
        cases.push(empty(1 << 22, "the limit of memory is 32.0 MiB"));
        cases.push(empty((1 << 28) + 1, "the limit of scene-bytes is 256.0 MiB, this needs 256.1 MiB: --limit scene-bytes=268435457 raises it"));
        cases.push(empty(1 << 40, "the limit of scene-bytes"));
    }
    // Very long words must still give a short one-line error quickly.
    let long = "a".repeat(1 << 21);
    cases.push(edited("a.ron", RON, "vfov", &long, "a.ron:"));
    cases.push(edited("a.json", JSON, "vfov", &long, "a.json:"));
    let textures: String = (0..4000)
        .map(|n| format!("\"{n}{}\": solid(color: (0, 0, 0)), ", "b".repeat(500)))
        .collect();
    let unknown = RON.replace("albedo: \"t\"", &format!("albedo: \"{}\"", "c".repeat(20_000)));
    let textures = format!("textures: {{{textures}");
    cases.push(edited("a.ron", &unknown, "textures: {", &textures, "unknown texture `cccc"));
    let boxes = "box(min: (0, 0, 0), max: (1, 1, 1), material: \"grey\"),".repeat(30_000);
    cases.push(edited("a.ron", RON, "quad(", &format!("{boxes}quad("), "the limit of memory"));
    for (name, says) in
        [("cloud:1000000", "the limit of memory"), ("mesh:16777216", "the limit of memory")]
    {
        let mut case = Case::scene("a.ron", "", says);
        case.arguments = vec!["scenes", "check", name];
        cases.push(case);
    }
    let mut few =
        edited("a.ron", RON, "vfov: 40", "vfov: 41", "the limit of primitives is 1, this needs 2");
    few.arguments.extend(["--limit", "primitives=1"]);
    cases.push(few);
    cases
}
