//! Tests of `scenes show` for scenes of other programs: references to their triangles, and paths.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::cli::succeeds;
use crate::common::{ptfast, stderr};

/// Squares on each side of the grids. Their lists are too long to be printed.
const SIDE: usize = 9;

/// Positions and indices of a wavy grid. Every number has an exact form in text.
fn grid() -> (Vec<[f32; 3]>, Vec<u32>) {
    let height = |x: usize, z: usize| ((x * 3 + z * 5) % 4) as f32 * 0.125;
    let point = |i: usize| {
        let (x, z) = (i % (SIDE + 1), i / (SIDE + 1));
        [x as f32 * 0.25 - 1.0, height(x, z), z as f32 * 0.25 - 1.0]
    };
    let corner = |x: usize, z: usize| (z * (SIDE + 1) + x) as u32;
    let square = |i: usize| {
        let (x, z) = (i % SIDE, i / SIDE);
        let [a, b, c, d] =
            [(x, z), (x, z + 1), (x + 1, z + 1), (x + 1, z)].map(|(x, z)| corner(x, z));
        [a, b, c, a, c, d]
    };
    ((0..(SIDE + 1).pow(2)).map(point).collect(), (0..SIDE * SIDE).flat_map(square).collect())
}

/// Writes `room.pbrt`: a grid, an object that is placed twice, and a short list.
fn write_pbrt(folder: &Path) {
    let (points, indices) = grid();
    let points: Vec<_> = points.iter().flatten().map(f32::to_string).collect();
    let indices: Vec<_> = indices.iter().map(u32::to_string).collect();
    let mesh = format!(
        "Shape \"trianglemesh\" \"point3 P\" [{}] \"integer indices\" [{}]",
        points.join(" "),
        indices.join(" ")
    );
    let text = format!(
        "LookAt 0 2 5  0 0 0  0 1 0 Camera \"perspective\"
         WorldBegin LightSource \"infinite\"
         Texture \"wood\" \"spectrum\" \"imagemap\" \"string filename\" \"wood.pfm\"
         Material \"diffuse\" \"texture reflectance\" \"wood\" \"string normalmap\" \"tilted.png\"
         Shape \"trianglemesh\" \"point3 P\" [-9 -1 -9 -9 -1 9 9 -1 0] \"integer indices\" [0 1 2]
         Rotate 30 1 2 3
         {mesh}
         ObjectBegin \"a\" Scale 0.5 0.25 0.5 {mesh} ObjectEnd
         Translate 1 1 0 ObjectInstance \"a\" Translate -2 0 0 ObjectInstance \"a\""
    );
    fs::write(folder.join("room.pbrt"), text).unwrap();
    let texels = [0.25_f32, 0.5, 0.75].map(f32::to_le_bytes).concat();
    fs::write(folder.join("wood.pfm"), [b"PF\n1 1\n-1\n", &*texels].concat()).unwrap();
    let normals = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/import/tilted.png");
    fs::copy(normals, folder.join("tilted.png")).unwrap();
}

/// Writes `grid.gltf`: a mesh with normals, tangents, colours and two sets of texture coordinates, in a node that
/// mirrors it, 20 000 units from the origin.
fn write_gltf(folder: &Path) {
    let (points, indices) = grid();
    let count = points.len();
    let per_vertex =
        |each: &dyn Fn(usize) -> Vec<f32>| (0..count).flat_map(each).collect::<Vec<_>>();
    let turned = |i: usize, w: &[f32]| {
        let part = i as f32 / count as f32;
        [&[part - 0.5, 1.0, part * 0.3][..], w].concat()
    };
    let lists = [
        ("POSITION", "VEC3", points.concat()),
        ("NORMAL", "VEC3", per_vertex(&|i| turned(i, &[]))),
        ("TANGENT", "VEC4", per_vertex(&|i| turned(i + 7, &[1.0]))),
        ("TEXCOORD_0", "VEC2", per_vertex(&|i| vec![i as f32 * 0.3, i as f32 * 0.7])),
        ("TEXCOORD_1", "VEC2", per_vertex(&|i| vec![i as f32 * 0.1, 0.5])),
        ("COLOR_0", "VEC3", per_vertex(&|i| vec![i as f32 / count as f32, 0.5, 1.0])),
    ];
    let (mut buffer, mut views, mut accessors, mut attributes) =
        (Vec::new(), Vec::new(), Vec::new(), serde_json::Map::new());
    let mut add = |bytes: Vec<u8>, count: usize, kind: &str, component: u32| {
        views.push(json!({ "buffer": 0, "byteOffset": buffer.len(), "byteLength": bytes.len() }));
        accessors.push(json!({
            "bufferView": views.len() - 1, "componentType": component, "count": count, "type": kind
        }));
        buffer.extend(bytes);
        accessors.len() - 1
    };
    for (name, kind, list) in lists {
        let bytes = list.into_iter().flat_map(f32::to_le_bytes).collect();
        attributes.insert(name.to_owned(), add(bytes, count, kind, 5126).into());
    }
    let bytes = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
    let indices = add(bytes, indices.len(), "SCALAR", 5125);
    let scene = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "scale": [-1, 1, 1.3], "translation": [20_000.1, 0, -20_000] }],
        "meshes": [{ "primitives": [{ "attributes": attributes, "indices": indices, "material": 0 }] }],
        "materials": [{
            "name": "clay",
            "normalTexture": { "index": 0 },
            "pbrMetallicRoughness": { "baseColorTexture": { "index": 0, "texCoord": 1 } },
        }],
        "textures": [{ "source": 0 }],
        "images": [{ "uri": "bumps.png" }],
        "buffers": [{ "uri": "grid.bin", "byteLength": buffer.len() }],
        "bufferViews": views,
        "accessors": accessors,
    });
    fs::write(folder.join("grid.gltf"), scene.to_string()).unwrap();
    fs::write(folder.join("grid.bin"), buffer).unwrap();
    let image = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/import/grid.png");
    fs::copy(image, folder.join("bumps.png")).unwrap();
}

/// The hash of a small picture of a scene.
fn hash(folder: &Path, scene: &str, more: &[&str]) -> String {
    let render =
        ["render", scene, "--width", "32", "--height", "18", "--spp", "2", "-q", "--print", "hash"];
    succeeds(folder, &[&render[..], &["-o", "picture.png"], more].concat())
}

#[test]
fn long_lists_become_references_and_paths_work_where_the_scene_is_saved() {
    let there = tempfile::tempdir().unwrap();
    let folder = there.path();
    fs::create_dir_all(folder.join("models/parts")).unwrap();
    let models = folder.join("models");
    write_pbrt(&models);
    write_gltf(&models);
    for (name, references, image) in [("room.pbrt", 2, "wood.pfm"), ("grid.gltf", 1, "bumps.png")] {
        let (file, options) = (format!("models/{name}"), ["--missing", "error"]);
        let hash_of_file = hash(folder, &file, &options);
        // On standard output, paths are relative to the current folder.
        let shown = succeeds(folder, &["scenes", "show", &file]);
        let count = shown.matches(&format!("file: \"{file}#")).count();
        assert_eq!(count, references, "{shown}");
        assert!(shown.contains(&format!("\"models/{image}\"")), "{shown}");
        assert!(shown.len() < 6000, "{} bytes", shown.len());
        fs::write(folder.join("a.ron"), shown).unwrap();
        assert_eq!(hash(folder, "a.ron", &[]), hash_of_file, "{name}");
        // In a file, they are relative to its folder.
        for (output, refers, more) in [
            ("models/b.ron", name.to_owned(), &[][..]),
            ("models/parts/c.json", format!("../{name}"), &["--outside-files"]),
        ] {
            succeeds(folder, &["scenes", "show", &file, "-o", output]);
            let shown = fs::read_to_string(folder.join(output)).unwrap();
            assert!(shown.contains(&format!("\"{refers}#")), "{shown}");
            assert_eq!(shown.starts_with('{'), output.ends_with("json"));
            assert_eq!(hash(folder, output, more), hash_of_file, "{name}");
        }
        // Those that are shown again stay as they are.
        let again = succeeds(folder, &["scenes", "show", "models/b.ron"]);
        assert_eq!(again, fs::read_to_string(folder.join("a.ron")).unwrap());
    }
    for (output, want) in [
        ("models/b.ron", "would overwrite the scene"),
        ("models/grid.bin", "must end in .ron or .json"),
        ("-", "must end in .ron or .json"),
        ("gone/a.ron", "gone: cannot read"),
    ] {
        let before = fs::read(folder.join("models/b.ron")).unwrap();
        let output = ptfast(folder, &["scenes", "show", "models/b.ron", "-o", output]);
        assert!(!output.status.success() && stderr(&output).contains(want), "{output:?}");
        assert_eq!(fs::read(folder.join("models/b.ron")).unwrap(), before);
    }
}

#[test]
fn references_can_be_placed_and_have_a_material() {
    let there = tempfile::tempdir().unwrap();
    write_pbrt(there.path());
    let shown = succeeds(there.path(), &["scenes", "show", "--json", "room.pbrt"]);
    let mut scene: Value = serde_json::from_str(&shown).unwrap();
    let camera = ["--look-from", "0,2,9", "--look-at", "0,0,0"];
    let before = hash(there.path(), "room.pbrt", &camera);
    let meshes = scene["primitives"].as_array_mut().unwrap();
    let mesh = meshes.iter_mut().find_map(|part| part.get_mut("mesh")).unwrap();
    // The short list is shape 0, the one in the object is shape 2.
    assert_eq!(mesh["file"], "room.pbrt#1");
    mesh["translation"] = json!([0, 1, 0]);
    fs::write(there.path().join("a.json"), scene.to_string()).unwrap();
    assert_ne!(hash(there.path(), "a.json", &camera), before);
    for (file, want) in [
        ("room.pbrt#3", "room.pbrt#3 is no list of triangles, the last one is room.pbrt#2"),
        ("room.pbrt#99999999999999999999", "the last one is room.pbrt#2"),
        ("room.ply#0", "only parts of glTF and pbrt files have numbers"),
        ("room.pbrt", "parts of glTF and pbrt files have numbers, such as room.pbrt#0"),
        ("gone.pbrt#0", "cannot read"),
    ] {
        let mut scene = scene.clone();
        let meshes = scene["primitives"].as_array_mut().unwrap();
        let mesh = meshes.iter_mut().find_map(|part| part.get_mut("mesh")).unwrap();
        mesh["file"] = file.into();
        fs::write(there.path().join("b.json"), scene.to_string()).unwrap();
        let output = ptfast(there.path(), &["scenes", "check", "b.json"]);
        let message = stderr(&output);
        assert!(message.contains(want) && message.lines().count() == 1, "{message}");
        assert_eq!(output.status.code(), Some(if file.starts_with("gone") { 74 } else { 65 }));
    }
}

/// Textures of MTL files have no names of their own, and `--env` names a map in any folder.
#[test]
fn paths_of_materials_and_of_the_map_of_the_user_are_kept() {
    let there = tempfile::tempdir().unwrap();
    let folder = there.path();
    fs::create_dir_all(folder.join("models")).unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    for (from, to) in [
        ("import/obj.obj", "models/obj.obj"),
        ("import/obj.mtl", "models/obj.mtl"),
        ("import/grid.png", "models/grid.png"),
        ("import/tilted.png", "models/tilted.png"),
        ("import/sky.pfm", "sky.pfm"),
    ] {
        fs::copy(data.join(from), folder.join(to)).unwrap();
    }
    let env = ["--env", "sky.pfm"];
    let want = hash(folder, "models/obj.obj", &env);
    for output in ["a.ron", "models/b.ron"] {
        succeeds(folder, &[&["scenes", "show", "models/obj.obj", "-o", output], &env[..]].concat());
        let shown = fs::read_to_string(folder.join(output)).unwrap();
        assert!(!shown.contains("\"/"), "{shown}");
        assert_eq!(hash(folder, output, &["--outside-files"]), want, "{output}");
    }
    let shown = succeeds(folder, &["scenes", "show", "cornell", "--env", "sky.pfm"]);
    assert!(shown.contains("file: \"sky.pfm\""), "{shown}");
}
