//! Tests of MTL files as exporters write them.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::cli::succeeds;
use crate::common::{ptfast, stderr};

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/import")
}

/// The materials of the scene of `a.obj` with this material file, as JSON.
fn materials(there: &Path, mtl: &[u8], options: &[&str]) -> Value {
    fs::write(there.join("a.mtl"), mtl).unwrap();
    let scene = succeeds(there, &[&["scenes", "show", "--json", "a.obj"], options].concat());
    serde_json::from_str::<Value>(&scene).unwrap()["materials"].clone()
}

#[test]
fn material_files_of_exporters_are_understood() {
    let there = tempfile::tempdir().unwrap();
    let there = there.path();
    fs::copy(folder().join("grid.png"), there.join("wall#2.png")).unwrap();
    let obj = "mtllib\ta.mtl b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m #1\nf 1 2 3\nusemtl m #2\nf 1 2 3\n";
    fs::write(there.join("a.obj"), obj).unwrap();
    fs::write(there.join("b.mtl"), "newmtl m #2\nKd 0 0 1 # blue\n").unwrap();
    let show = |mtl: &[u8]| materials(there, mtl, &[]);
    // Maya writes this for opaque surfaces.
    let maya = show(b"newmtl m #1\nillum 4\nKd 0.5 0.5 0.5\nTf 1.00 1.00 1.00\nNi 1.00\n");
    assert_eq!(maya["m #1"], json!({ "lambertian": { "albedo": [0.5, 0.5, 0.5] } }));
    assert_eq!(maya["m #2"], json!({ "lambertian": { "albedo": [0.0, 0.0, 1.0] } }));
    let glass = show(b"newmtl m #1\nillum 7\nd 0.1\nNi 1.5\n");
    assert_eq!(glass["m #1"]["dielectric"]["ior"], 1.5);
    let map = show(b"newmtl m #1\nmap_Kd wall#2.png\nmap_Ke\n");
    assert!(map["m #1"]["lambertian"]["albedo"].to_string().contains("wall#2.png"), "{map}");
    let halo = show(b"newmtl m #1\nd -halo 0.5\n# caf\xe9\n");
    assert_eq!(halo["m #1"]["lambertian"]["opacity"]["blend"]["alpha"], 0.5);
    // A glowing surface is a lamp only if it has no colour of its own.
    let glow = show(b"newmtl m #1\nKd 0 0 0\nmap_Kd wall#2.png\nKe 1 1 1\n");
    assert!(glow["m #1"].get("principled").is_some(), "{glow}");
    for line in ["Kd xyz 1 0 0", "decal a.png", "map_Kd -mm 0 2 wall#2.png", "map_bump a.png"] {
        fs::write(there.join("a.mtl"), format!("newmtl m #1\n{line}\n")).unwrap();
        let output = ptfast(there, &["scenes", "check", "a.obj", "--strict"]);
        let error = stderr(&output);
        assert_eq!((output.status.code(), error.lines().count()), (Some(2), 1), "{line}: {error}");
    }
    fs::write(there.join("a.mtl"), "").unwrap();
    let output = ptfast(there, &["scenes", "check", "a.obj", "--strict"]);
    assert!(stderr(&output).contains("one of its materials is grey"), "{}", stderr(&output));
}

/// What Blender 5.2.3 writes for known materials, without and with the keywords of physically based materials, and
/// what it reads from that (`obj_export_mtl.cc`, `obj_import_mtl.cc`).
#[test]
fn material_files_of_blender_are_understood() {
    let there = tempfile::tempdir().unwrap();
    let there = there.path();
    fs::copy(folder().join("grid.png"), there.join("grid.png")).unwrap();
    fs::write(there.join("a.obj"), "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n")
        .unwrap();
    let show = |by: &str, own: &str| {
        let plain = "Ns 490\nKd 0.8 0.8 0.8\nKs 0.5 0.5 0.5\nKe 0 0 0\nNi 1.5\nd 1\nillum 2\n";
        let text = format!("# {by} MTL File: 'None'\nnewmtl m\n{plain}{own}\n");
        materials(there, text.as_bytes(), &["--strict"])["m"]["principled"].clone()
    };
    let blender = |own: &str| show("Blender 5.2.3 LTS", own);
    let pbr = |own: &str| {
        let usual = "Pr 0.5\nPm 0\nPs 0\nPc 0\nPcr 0.03\naniso 0\nanisor 0";
        blender(&format!("{usual}\n{own}"))
    };
    let rough = |value: &Value| (value["roughness"].as_f64().unwrap() * 1e4).round() / 1e4;
    // Roughness 0.3; by Phong's exponent elsewhere.
    assert_eq!(rough(&blender("")), 0.3);
    assert_eq!(rough(&show("another", "")), 0.2525);
    // An alpha of 0.5, also of metal, is no glass.
    for (own, metal) in [("d 0.5\nillum 9", 0.0), ("Ka 1 1 1\nd 0.5\nillum 6", 1.0)] {
        let found = blender(own);
        assert_eq!(found["opacity"]["blend"]["alpha"], 0.5, "{found}");
        assert_eq!(
            (&found["transmission"], &found["metalness"]),
            (&json!(0.0), &json!(metal)),
            "{found}"
        );
    }
    assert_eq!(blender("Ka 0.5 0.5 0.5\nillum 3")["metalness"], 0.5);
    assert_eq!(show("another", "illum 3")["metalness"], 1.0);
    assert_eq!(show("another", "d 0.5\nillum 9")["opacity"]["blend"]["alpha"], 0.5);
    // Half of the usual level; black is not a mirror.
    assert_eq!(blender("Ks 0.25 0.25 1")["specular_color"], json!([0.5, 0.5, 2.0]));
    assert_eq!(
        (&blender("Kd 0 0 0")["metalness"], &show("another", "Kd 0 0 0")["metalness"]),
        (&json!(0.0), &json!(1.0))
    );
    let matte = pbr("Ks 0 0 0\nillum 1");
    assert_eq!((&matte["specular"], &matte["metalness"]), (&json!(0.0), &json!(0.0)));
    let brushed = pbr("aniso 0.5\nanisor 0.25\nPs 0.75");
    assert_eq!(
        (&brushed["anisotropy"], &brushed["anisotropy_rotation"], &brushed["sheen_color"]),
        (&json!(0.5), &json!(90.0), &json!([0.75, 0.75, 0.75]))
    );
    // A coat of weight 0.5.
    assert_eq!(
        (&pbr("Pc 2")["coat"], &show("another", "Pr 0.5\nPc 0.5")["coat"]),
        (&json!(0.5), &json!(0.5))
    );
    // Red glass, half glass, and a surface that is no glass.
    let glass = pbr("Kd 0.64 0.04 0.16\nTf 1 1 1");
    assert_eq!(
        (&glass["transmission"], &glass["base_color"]),
        (&json!(1.0), &json!([1.0, 0.25, 0.5]))
    );
    let half = pbr("Tf 0.5 0.5 0.5");
    assert_eq!(half["transmission"], 0.5);
    assert_eq!(half["base_color"], pbr("")["base_color"]);
    assert_eq!(show("3ds Max", "Tf 1 1 1")["transmission"], 0.0);
    let normal = blender("map_Bump -bm 0.5 grid.png")["normal"]["image"].clone();
    assert_eq!((&normal["normal_scale"], &normal["encoding"]), (&json!(0.5), &json!("linear")));
}

/// Opacity in MTL files: the alpha of an image as Blender reads it, and `d` before `Tr` (tinyobjloader, issue 43).
#[test]
fn opacity_of_material_files_is_told_apart() {
    let there = tempfile::tempdir().unwrap();
    let there = there.path();
    let image = |name: &str, color: image::DynamicImage| color.save(there.join(name)).unwrap();
    image("rgba.png", image::RgbaImage::from_pixel(2, 2, image::Rgba([0, 255, 0, 9])).into());
    image("rgb.png", image::RgbImage::from_pixel(2, 2, image::Rgb([128, 128, 255])).into());
    image("grey.png", image::GrayImage::from_pixel(2, 2, image::Luma([200])).into());
    fs::write(
        there.join("a.obj"),
        "\u{feff}mtllib \\\n a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n",
    )
    .unwrap();
    let show = |lines: &str| {
        let text = format!("\u{feff}# a\\\nnewmtl m\n{lines}");
        materials(there, text.as_bytes(), &[])["m"]["lambertian"].clone()
    };
    for (file, channel) in [("rgba.png", "a"), ("rgb.png", "g"), ("grey.png", "g")] {
        let shown = show(&format!("map_d {file}\n"));
        assert_eq!(shown["opacity"]["blend"]["alpha"]["channel"], channel, "{file}: {shown}");
    }
    assert_eq!(show("d 1\nTr 1\n").get("opacity"), None);
    assert_eq!(show("Kd 0.25 \\\n 0.5 \\\r\n 1\n")["albedo"], json!([0.25, 0.5, 1.0]));
    // A flat normal map, and heights.
    assert_eq!(show("bump -bm 2 rgb.png\n")["normal"]["image"]["normal_scale"], 2.0);
    assert_eq!(show("bump grey.png\n").get("normal"), None);
    for (lines, names) in
        [("Tr 1", "has 1 invisible material, with `d 0` or `Tr 1`: `m`"), ("d 0", "`m`")]
    {
        fs::write(there.join("a.mtl"), format!("newmtl m\n{lines}\n")).unwrap();
        let error = stderr(&ptfast(there, &["scenes", "check", "a.obj", "--strict"]));
        assert!(error.contains(names), "{error}");
    }
    fs::write(there.join("a.mtl"), "newmtl m\nd 0.5 \\\n0\nKd 1 x\n").unwrap();
    let error = stderr(&ptfast(there, &["scenes", "check", "a.obj"]));
    assert!(error.contains("a.mtl:4: `kd` must be"), "{error}");
}
