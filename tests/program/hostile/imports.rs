//! Hostile scenes of other programs.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::{Value, json};

use super::{Case, Content};

fn pbrt(text: impl Into<String>, says: &str) -> Case {
    Case::scene("a.pbrt", text.into(), says)
}

fn gltf(json: &Value, says: &str) -> Case {
    Case::scene("a.gltf", json.to_string(), says)
}

/// A scene of one triangle, whose parts `change` replaces.
fn triangle(change: impl FnOnce(&mut Value), says: &str) -> Case {
    let mut json = json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "uri": "a.bin", "byteLength": 36 }],
    });
    change(&mut json);
    gltf(&json, says).with("a.bin", Content::Bytes([[0; 12], [1; 12], [9; 12]].concat()))
}

/// A file that decompresses to more than the memory limit.
fn bomb() -> Content {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    let zeros = vec![b' '; 1 << 20];
    (0..64).for_each(|_| encoder.write_all(&zeros).unwrap());
    Content::Bytes(encoder.finish().unwrap())
}

/// Files that include the next one twice each, so that there would be 2^20 of the last.
fn fan_out() -> Case {
    const NAMES: [&str; 20] = [
        "0.pbrt", "1.pbrt", "2.pbrt", "3.pbrt", "4.pbrt", "5.pbrt", "6.pbrt", "7.pbrt", "8.pbrt",
        "9.pbrt", "10.pbrt", "11.pbrt", "12.pbrt", "13.pbrt", "14.pbrt", "15.pbrt", "16.pbrt",
        "17.pbrt", "18.pbrt", "19.pbrt",
    ];
    let twice = |name: &str| format!("Include \"{name}\" Include \"{name}\"");
    let first = pbrt(twice(NAMES[0]), "more than 10000 files are included");
    let with_next = |case: Case, i: usize| {
        let text = NAMES.get(i + 1).map_or_else(String::new, |next| twice(next));
        case.with(NAMES[i], Content::Bytes(text.into_bytes()))
    };
    (0..NAMES.len()).fold(first, with_next)
}

pub(super) fn cases() -> Vec<Case> {
    let huge = 1u64 << 62;
    let mut cases = vec![
        pbrt("AttributeBegin ".repeat(100_000), "nested at most 1000"),
        pbrt(
            "Shape \"sphere\" \"float radius\" [".to_owned() + &"1 ".repeat(100_000),
            "no closing bracket",
        ),
        pbrt("Include \"a.pbrt\"", "includes itself"),
        pbrt("Include \"b.pbrt\"", "includes itself")
            .with("b.pbrt", Content::Bytes(b"Include \"a.pbrt\"".into())),
        pbrt("Include \"/etc/passwd\"", "outside the folder"),
        pbrt("Include \"b.pbrt.gz\"", "limit").with("b.pbrt.gz", bomb()),
        pbrt("WorldBegin Shape \"plymesh\" \"string filename\" \"b.ply.gz\"", "limit")
            .with("b.ply.gz", bomb()),
        pbrt("WorldBegin Shape \"plymesh\" \"string filename\" \"/etc/passwd.ply\"", "cannot read"),
        pbrt("\u{0}\u{1}", "unknown directive"),
        pbrt("Scale 1e400 1 1", "not finite"),
        pbrt("Scale nan 1 1", "not finite"),
        pbrt("PixelFilter \"gaussian\" \"float xradius\" -nan", "not finite"),
        pbrt("Scale 0 1 1", "singular or not finite"),
        pbrt(
            "WorldBegin Scale 1 1 2 ".to_owned() + &"Shape \"sphere\" ".repeat(1000),
            "limit of memory",
        ),
        pbrt(
            "WorldBegin Shape \"trianglemesh\" \"point3 P\" [0 0 0] \"integer indices\" [0 1 2]",
            "indices[0] must be below",
        ),
        pbrt(
            "WorldBegin Shape \"trianglemesh\" \"point3 P\" [0 0 0] \"integer indices\" [0 1 -2]",
            "whole numbers",
        ),
        pbrt("WorldBegin Shape \"sphere\" \"float radius\" -1", "radius must be above 0"),
        pbrt(
            "WorldBegin Texture \"a\" \"spectrum\" \"scale\" \"texture tex\" \"a\"",
            "unknown texture \"a\"",
        ),
        pbrt(
            "MakeNamedMaterial \"a\" \"string type\" \"mix\" \"string materials\" [\"a\" \"a\"] NamedMaterial \"a\" WorldBegin Shape \"sphere\"",
            "the mixture contains itself",
        ),
        // The names of generated materials are taken.
        pbrt(
            "MakeNamedMaterial \"a 1\" MakeNamedMaterial \"a\" WorldBegin NamedMaterial \"a 1\" Shape \"disk\" NamedMaterial \"a\" Shape \"disk\" Shape \"disk\" \"float alpha\" 0.5 Shape \"disk\" \"float alpha\" 0.4 Oops",
            "unknown directive `Oops`",
        ),
        fan_out(),
        Case::scene(
            "a.obj",
            "mtllib /etc/passwd\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n",
            "outside the folder",
        ),
        Case::scene(
            "a.obj",
            "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n",
            "outside the folder",
        )
        .with("a.mtl", Content::Bytes(b"newmtl a\nmap_Kd /etc/passwd\n".into())),
        pbrt("WorldBegin ".to_owned() + &"Shape \"sphere\" ".repeat(200_000), "limit"),
        gltf(&json!([]), "`asset.version` must be 2.0"),
        Case::scene("a.gltf", "[".repeat(100_000), "limit of memory"),
        Case::scene("a.gltf", "[".repeat(2000), "invalid type: sequence"),
        Case::scene(
            "a.gltf",
            "{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [".to_owned()
                + &"{},".repeat(1_000_000)
                + "{}]}",
            "limit of memory",
        ),
        Case::scene(
            "a.gltf",
            "{\"asset\": {\"version\": \"2.0\"}, \"materials\": [".to_owned()
                + &"[],".repeat(1_000_000)
                + "[]]}",
            "limit of memory",
        ),
        triangle(
            |json| {
                let many = json!({ "componentType": 5126, "count": 2_000_000, "type": "VEC3" });
                json["accessors"].as_array_mut().unwrap().push(many);
                let attributes = json!({ "TRANSLATION": 1 });
                json["nodes"][0]["extensions"] =
                    json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
            },
            "limit of memory",
        ),
        Case::scene("a.glb", "glTF", "version of the container"),
        Case::scene("a.glb", "glTF\u{2}\0\0\0\0\0\0\0", "no JSON chunk"),
        Case::scene(
            "a.glb",
            "glTF\u{2}\0\0\0\0\0\0\0\u{7f}\u{7f}\u{7f}\u{7f}JSON",
            "chunk exceeds",
        ),
        triangle(|json| json["nodes"][0]["children"] = json!([0]), "reached twice"),
        triangle(|json| json["scenes"][0]["nodes"] = json!([7]), "unknown node 7"),
        triangle(|json| json["nodes"][0]["mesh"] = json!(7), "unknown mesh 7"),
        triangle(|json| json["nodes"][0]["skin"] = json!(7), "unknown skin 7"),
        triangle(|json| json["nodes"][0]["camera"] = json!(7), "unknown camera"),
        triangle(|json| json["nodes"][0]["scale"] = json!([1e300, 1e300, 1e300]), "within ±1e9"),
        triangle(
            |json| json["meshes"][0]["primitives"][0]["material"] = json!(7),
            "unknown material 7",
        ),
        triangle(
            |json| json["meshes"][0]["primitives"][0]["indices"] = json!(0),
            "1 unsigned integers",
        ),
        triangle(
            |json| json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(9),
            "unknown accessor 9",
        ),
        triangle(|json| json["accessors"][0]["bufferView"] = json!(9), "unknown buffer view 9"),
        triangle(|json| json["accessors"][0]["count"] = json!(huge), "limit"),
        triangle(|json| json["accessors"][0]["count"] = json!(4), "exceeds the buffer view"),
        triangle(|json| json["accessors"][0]["count"] = json!(-1), "invalid value"),
        triangle(
            |json| json["accessors"][0]["byteOffset"] = json!(huge),
            "exceeds the buffer view",
        ),
        triangle(
            |json| json["accessors"][0]["componentType"] = json!(5124),
            "unknown component type",
        ),
        triangle(|json| json["accessors"][0]["type"] = json!("VEC2"), "3 numbers are needed"),
        triangle(|json| json["accessors"][0]["type"] = json!("MAT9"), "not supported"),
        triangle(|json| json["bufferViews"][0]["byteStride"] = json!(4), "less than an element"),
        triangle(
            |json| json["bufferViews"][0]["byteStride"] = json!(u64::MAX),
            "exceeds the buffer view",
        ),
        triangle(
            |json| json["bufferViews"][0]["byteOffset"] = json!(u64::MAX),
            "exceeds its buffer",
        ),
        triangle(|json| json["bufferViews"][0]["byteLength"] = json!(37), "exceeds its buffer"),
        triangle(|json| json["bufferViews"][0]["buffer"] = json!(9), "unknown buffer 9"),
        triangle(|json| json["buffers"][0]["byteLength"] = json!(37), "fewer than its byteLength"),
        triangle(|json| json["buffers"][0]["uri"] = json!("%2Fetc/passwd"), "outside the folder"),
        triangle(
            |json| json["buffers"][0]["uri"] = json!("data:;base64,???"),
            "a.gltf:buffers[0]: wrong base64",
        ),
        triangle(
            |json| {
                json["materials"] = json!([{ "normalTexture": { "index": 0 } }]);
                json["textures"] = json!([{ "source": 0 }]);
                json["images"] = json!([{ "uri": "../../../etc/passwd" }]);
                json["meshes"][0]["primitives"][0]["material"] = json!(0);
            },
            "outside the folder",
        ),
        triangle(
            |json| json["extensionsRequired"] = json!(["EXT_unknown"]),
            "requires the extension EXT_unknown",
        ),
        triangle(
            |json| {
                json["accessors"] =
                    json!([{ "componentType": 5126, "count": 1u64 << 40, "type": "VEC3" }]);
            },
            "limit of memory",
        ),
        triangle(
            |json| {
                let part = json!({ "bufferView": 0, "byteOffset": 12, "componentType": 5123 });
                json["accessors"][0]["sparse"] =
                    json!({ "count": 1, "indices": part, "values": part });
            },
            "a sparse accessor has an index",
        ),
        triangle(
            |json| {
                json["materials"] = json!([{ "normalTexture": { "index": 3 } }]);
                json["meshes"][0]["primitives"][0]["material"] = json!(0);
            },
            "unknown texture 3",
        ),
        triangle(
            |json| {
                json["materials"] = json!([{ "normalTexture": { "index": 0 } }]);
                json["textures"] = json!([{ "source": 0 }]);
                json["images"] = json!([{ "bufferView": 0 }]);
                json["meshes"][0]["primitives"][0]["material"] = json!(0);
            },
            "images[0]: ",
        ),
        triangle(
            |json| {
                let parts = vec![json!({ "attributes": { "POSITION": 0 } }); 100_000];
                json["meshes"][0]["primitives"] = json!(parts);
            },
            "limit",
        ),
    ];
    // A file of the scene's own kind as a mesh or a texture.
    cases.push(Case::scene(
        "a.ron",
        r#"(camera: (look_from: (0, 0, 1), look_at: (0, 0, 0), vfov: 9), textures: {"a": image(file: "a.png", index: 0)})"#,
        "a.png",
    ).with("a.png", Content::Bytes(b"{}".into())));
    cases
}
