//! Tests of scenes of other programs. Each scene in `tests/data/import` has everything that ptfast reads
//! of its format, and is paired with the same scene in RON.

use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use ptfast::{
    Engine, ImageSettings, ImportOptions, Limits, Renderer, Roulette, Scene, SceneDescription,
};
use serde_json::{Value, json};

use crate::cli::succeeds;
use crate::common::{ptfast, stderr, stdout};

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/import")
}

fn load(name: &str) -> Scene {
    Scene::load(folder().join(name).to_str().unwrap()).unwrap()
}

#[test]
fn scenes_are_the_same_in_ron() {
    for name in ["pbrt.pbrt", "gltf.gltf", "compressed.gltf", "obj.obj"] {
        let ron = load(Path::new(name).with_extension("ron").to_str().unwrap());
        let scene = load(name);
        let shown = succeeds(&folder(), &["scenes", "show", name]);
        assert_eq!(scene.hash(), ron.hash(), "{name} is now\n{shown}");
        assert_eq!(scene.defaults(), ron.defaults(), "{name}");
        assert_eq!(ImageSettings::of(&scene).roulette, Roulette::Auto, "{name}");
        let images = Engine::ALL.map(|engine| {
            let settings = ImageSettings { spp: 2, ..ImageSettings::of(&scene) };
            Renderer::new(&scene, settings, engine).unwrap().render().unwrap().image.hash()
        });
        assert_eq!(images[0], images[1], "{name}");
    }
}

/// The container of a glTF file and its buffer.
fn glb(json: &Value, buffer: &[u8]) -> Vec<u8> {
    let mut json = json.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + json.len() as u32 + buffer.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json[..]), (b"BIN\0", buffer)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

fn gltf() -> (Value, Vec<u8>) {
    let json = fs::read_to_string(folder().join("gltf.gltf")).unwrap();
    (serde_json::from_str(&json).unwrap(), fs::read(folder().join("gltf parts.bin")).unwrap())
}

#[test]
fn containers_have_the_same_scene() {
    let (mut json, mut buffer) = gltf();
    buffer.resize(buffer.len().next_multiple_of(4), 0);
    json["buffers"] = json!([{ "byteLength": buffer.len() }]);
    let there = tempfile::tempdir().unwrap();
    fs::copy(folder().join("grid.png"), there.path().join("grid.png")).unwrap();
    fs::write(there.path().join("a.glb"), glb(&json, &buffer)).unwrap();
    let scene = Scene::load(there.path().join("a.glb").to_str().unwrap()).unwrap();
    assert_eq!(scene.hash(), load("gltf.gltf").hash());
}

/// Exporters write zeros where texture coordinates define no tangent.
#[test]
fn tangents_of_gltf_files_that_cannot_be_used_are_computed() {
    let there = tempfile::tempdir().unwrap();
    for file in ["gltf parts.bin", "grid.png"] {
        fs::copy(folder().join(file), there.path().join(file)).unwrap();
    }
    let (json, mut buffer) = gltf();
    let shown = |attributes: &str| {
        let mut json = json.clone();
        let attributes = serde_json::from_str(attributes).unwrap();
        json["meshes"][0]["primitives"][0]["attributes"] = attributes;
        fs::write(there.path().join("a.gltf"), json.to_string()).unwrap();
        let checked = ptfast(there.path(), &["scenes", "check", "a.gltf"]);
        let warned = stderr(&checked).contains("so all of their part are computed");
        (succeeds(there.path(), &["scenes", "show", "a.gltf"]).contains("tangents: ["), warned)
    };
    let all = r#"{"POSITION": 0, "NORMAL": 1, "TANGENT": 20, "TEXCOORD_0": 2}"#;
    assert_eq!(shown(all), (true, false));
    // Accessor 1 has vectors of three numbers, and 14 has three vectors for four vertices.
    for wrong in ["1", "14"] {
        assert_eq!(shown(&all.replace("20", wrong)), (false, true), "{wrong}");
    }
    // They have no meaning without normals and texture coordinates.
    assert_eq!(shown(r#"{"POSITION": 0, "NORMAL": 1, "TANGENT": 1}"#), (false, false));
    buffer[796..812].fill(0);
    fs::write(there.path().join("gltf parts.bin"), &buffer).unwrap();
    assert_eq!(shown(all), (false, true));
}

/// pbrt's area lights scatter light as well, and may have alpha. Such lamps stay triangles.
#[test]
fn lamps_of_pbrt_files_scatter_light() {
    let there = tempfile::tempdir().unwrap();
    let shown = |material: &str, alpha: &str| {
        let text = format!(
            r#"Camera "perspective"
            WorldBegin
            {material}
            AreaLightSource "diffuse" "rgb L" [2 2 2]
            Shape "trianglemesh" "point3 P" [0 0 1 1 0 1 1 1 1 0 1 1] "integer indices" [0 1 2 0 2 3] {alpha}"#
        );
        fs::write(there.path().join("a.pbrt"), text).unwrap();
        succeeds(there.path(), &["scenes", "show", "a.pbrt"])
    };
    let black = r#"Material "diffuse" "rgb reflectance" [0 0 0]"#;
    let grey = r#"Material "diffuse" "rgb reflectance" [0.5 0.5 0.5]"#;
    let alpha = r#""float alpha" [0.25]"#;
    let has = |text: &str, parts: &[&str]| {
        parts.iter().for_each(|part| assert!(text.contains(part), "{part} in {text}"));
    };
    has(&shown(black, ""), &["light(radiance: (2.0, 2.0, 2.0), sides: front)", "quad("]);
    let lit = ["base_color: (0.5, 0.5, 0.5)", "emission: (2.0, 2.0, 2.0)", "emission_sides: front"];
    has(&shown(grey, ""), &[&lit[..], &["quad("]].concat());
    has(&shown(grey, alpha), &[&lit[..], &["triangles(", "opacity: blend(alpha: 0.25)"]].concat());
    has(
        &shown(black, alpha),
        &["base_color: (0.0, 0.0, 0.0)", "emission_sides: front", "triangles("],
    );
}

/// glTF 2.0, 3.9.2: colours of vertices multiply the texture. 3.9.3: `scale` multiplies the components of normals
/// along the surface.
#[test]
fn gltf_files_have_colors_beside_textures_and_scales_of_normals() {
    let there = tempfile::tempdir().unwrap();
    for file in ["gltf parts.bin", "grid.png", "tilted.png"] {
        fs::copy(folder().join(file), there.path().join(file)).unwrap();
    }
    let (mut json, _) = gltf();
    let shown = |json: &Value| {
        fs::write(there.path().join("a.gltf"), json.to_string()).unwrap();
        let shown = succeeds(there.path(), &["scenes", "show", "a.gltf"]);
        (shown.contains("vertex_colors: true"), shown.contains("normal_scale: 0.5"))
    };
    assert_eq!(shown(&json), (false, false));
    // Accessor 1 has vectors of three numbers.
    json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(1);
    json["materials"][0]["normalTexture"]["scale"] = json!(0.5);
    assert_eq!(shown(&json), (true, true));
}

/// The extensions of Khronos for materials. An index of 0 stands for an infinite one, and converters write 1000 beside
/// the colour of the reflection that was meant.
#[test]
fn extensions_of_gltf_materials_are_read() {
    let there = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(folder().join("gltf.gltf")).unwrap();
    for file in ["gltf parts.bin", "grid.png"] {
        fs::copy(folder().join(file), there.path().join(file)).unwrap();
    }
    let read = |extensions: Value| {
        let mut json: Value = serde_json::from_str(&text).unwrap();
        let materials = json["materials"].as_array_mut().unwrap();
        let car = materials.iter_mut().find(|material| material["name"] == "car").unwrap();
        car["extensions"] = extensions;
        fs::write(there.path().join("a.gltf"), json.to_string()).unwrap();
        let shown = succeeds(there.path(), &["scenes", "show", "--json", "a.gltf"]);
        let shown: Value = serde_json::from_str(&shown).unwrap();
        shown["materials"]["car"]["principled"].clone()
    };
    for (extension, value, field, want) in [
        ("ior", json!({ "ior": 1000 }), "ior", json!(1000.0)),
        ("ior", json!({ "ior": 0 }), "ior", json!(1000.0)),
        ("ior", json!({ "ior": 1 }), "ior", json!(1.01)),
        (
            "specular",
            json!({ "specularColorFactor": [3, 0.5, 0] }),
            "specular_color",
            json!([3.0, 0.5, 0.0]),
        ),
        (
            "sheen",
            json!({ "sheenColorFactor": [1, 0.5, 0] }),
            "sheen_color",
            json!([1.0, 0.5, 0.0]),
        ),
        ("sheen", json!({ "sheenRoughnessFactor": 0.25 }), "sheen_roughness", json!(0.25)),
        ("anisotropy", json!({ "anisotropyStrength": 0.5 }), "anisotropy", json!(0.5)),
        (
            "anisotropy",
            json!({ "anisotropyRotation": -PI / 2.0 }),
            "anisotropy_rotation",
            json!(-90.0),
        ),
        (
            "diffuse_transmission",
            json!({ "diffuseTransmissionFactor": 0.5 }),
            "diffuse_transmission",
            json!(0.5),
        ),
        (
            "diffuse_transmission",
            json!({ "diffuseTransmissionColorFactor": [1, 0.5, 0] }),
            "diffuse_transmission_color",
            json!([1.0, 0.5, 0.0]),
        ),
    ] {
        let material = read(json!({ format!("KHR_materials_{extension}"): value }));
        assert_eq!(material[field], want, "{extension}: {material}");
    }
    // Maps of directions have linear encoding and no factor.
    let map = json!({ "index": 0 });
    for (extension, value, field) in [
        (
            "clearcoat",
            json!({ "clearcoatFactor": 1, "clearcoatNormalTexture": map }),
            "coat_normal",
        ),
        (
            "anisotropy",
            json!({ "anisotropyStrength": 1, "anisotropyTexture": map }),
            "anisotropy_map",
        ),
    ] {
        let material = read(json!({ format!("KHR_materials_{extension}"): value }));
        assert!(material[field].is_string(), "{extension}: {material}");
    }
}

/// A city in map coordinates is the same picture as one at the origin, since only its distance from there is lost.
#[test]
fn scenes_far_from_the_origin_lose_no_bits() {
    let there = tempfile::tempdir().unwrap();
    let path = there.path().join("a.pbrt");
    let image = |[x, y]: [f64; 2]| {
        // The camera is 5 in front of a triangle and a ball, which are moved by a transform.
        let text = format!(
            "LookAt {} {} 5  {x} {y} 0  0 1 0 Camera \"perspective\" \"float fov\" 30
             WorldBegin LightSource \"infinite\" Translate {x} {y} 0
             Shape \"sphere\" \"float radius\" 0.3
             Shape \"trianglemesh\" \"point3 P\" [-1 -1 0.1  1 -1 0.1  0 1 0.3] \"integer indices\" [0 1 2]",
            x + 0.5,
            y + 0.25,
        );
        fs::write(&path, text).unwrap();
        let scene = Scene::load(path.to_str().unwrap()).unwrap();
        let settings = ImageSettings { width: 60, height: 40, spp: 2, ..ImageSettings::of(&scene) };
        let image =
            Renderer::new(&scene, settings, Engine::Scalar).unwrap().render().unwrap().image;
        (image.hash(), scene.origin().to_array())
    };
    let (near, origin) = image([0.0, 0.0]);
    assert_eq!(origin, [0.0; 3]);
    let (moved, origin) = image([65_536.0, -1_048_576.0]);
    assert_eq!((moved, origin), (near, [65_536.0, -1_048_576.0, 0.0]));

    // The same for OBJ files, whose numbers have more digits than f32 holds.
    let place = |[x, y]: [f64; 2], options: &[&str]| {
        let mut text = String::new();
        for [u, v, w] in [[0.125, 0.25, 0.0], [1.5, 0.0, 0.5], [0.0, 1.375, 0.25]] {
            text += &format!("v {} {} {w}\n", x + u, y + v);
        }
        fs::write(there.path().join("city.obj"), text + "f 1 2 3\n").unwrap();
        let show = [&["scenes", "show", "--json", "city.obj"], options].concat();
        let shown: Value = serde_json::from_str(&succeeds(there.path(), &show)).unwrap();
        (shown["origin"].clone(), shown["camera"].clone())
    };
    let (none, near) = place([0.0, 0.0], &[]);
    let (origin, moved) = place([85_000.0, 446_464.0], &[]);
    assert_eq!((none, origin), (Value::Null, json!([85_000.0, 446_464.0, 0.0])));
    assert_eq!(moved, near);
    let (origin, _) = place([85_000.0, 446_464.0], &["--z-up"]);
    assert_eq!(origin, json!([85_000.0, 0.0, -446_464.0]));

    // Arguments and reports are in the coordinates of the file.
    let view = ["--look-from", "65536.5,-1048575,4", "--look-at", "65536.5,-1048575,0"];
    let size = ["--width", "3", "--height", "3", "--pixel", "1,1"];
    let path = succeeds(there.path(), &[&["path", "a.pbrt"], &view[..], &size].concat());
    assert!(path.contains("camera  from (65536.5, -1048575, 4) along"), "{path}");
    let shown = succeeds(there.path(), &["scenes", "show", "a.pbrt"]);
    assert!(shown.contains("origin: (65536.0, -1048576.0, 0.0)"), "{shown}");
    let rays = ["rays", "a.pbrt", "--spp", "1", "--max-rays", "2048", "-o", "set"];
    succeeds(there.path(), &rays);
    let manifest = fs::read_to_string(there.path().join("set/manifest.json")).unwrap();
    let manifest: Value = serde_json::from_str(&manifest).unwrap();
    assert_eq!(manifest["origin"], json!([65_536.0, -1_048_576.0, 0.0]));
}

/// The middle of the map is +x in three.js 0.187 (`equirectUv`), in the viewer of Khronos 1.1.0 (`dirToUV`), and in
/// Blender 5.2.3 after its export. A rotation of -90 degrees about y takes -z, our middle, there.
#[test]
fn maps_of_the_user_are_turned_as_in_other_programs() {
    let there = tempfile::tempdir().unwrap();
    fs::copy(folder().join("sky.pfm"), there.path().join("sky.pfm")).unwrap();
    let asset = json!({ "asset": { "version": "2.0" } });
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    fs::write(there.path().join("a.gltf"), asset.to_string()).unwrap();
    fs::write(there.path().join("a.obj"), obj).unwrap();
    fs::write(there.path().join("a.pbrt"), "WorldBegin").unwrap();
    for (name, turn, want) in [
        ("a.gltf", "0", -90.0),
        ("a.gltf", "30", -60.0),
        ("a.obj", "-30", -120.0),
        ("a.pbrt", "0", 0.0),
        ("spheres", "30", 30.0),
    ] {
        let show = ["scenes", "show", "--json", name, "--env", "sky.pfm", "--env-rotation", turn];
        let shown: Value = serde_json::from_str(&succeeds(there.path(), &show)).unwrap();
        let rotation = &shown["background"]["image"]["rotation"];
        assert_eq!(rotation[1].as_f64().unwrap_or_default(), want, "{name}: {rotation}");
    }
    let output = ptfast(there.path(), &["scenes", "show", "spheres", "--env-rotation", "1"]);
    assert_eq!(output.status.code(), Some(2));
}

/// Blender 5.2.3 exports a lamp of 1000 W as 683 · 1000 / 4π candela, and a sun of 1 W/m² as 683 lux (`lights.py` of
/// glTF-Blender-IO). Emission is not multiplied.
#[test]
fn lamps_of_blender_are_divided_by_683() {
    let there = tempfile::tempdir().unwrap();
    let mut json = json!({
        "asset": { "version": "2.0", "generator": "Khronos glTF Blender I/O v5.2.40" },
        "nodes": [
            { "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            { "extensions": { "KHR_lights_punctual": { "light": 1 } } },
            { "camera": 0 }, { "mesh": 0, "translation": [-0.5, -0.5, -1] },
        ],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
        "accessors": [{ "componentType": 5126, "count": 3, "type": "VEC3", "bufferView": 0 }],
        "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
        "buffers": [{ "byteLength": 36, "uri": "a.bin" }],
        "extensions": { "KHR_lights_punctual": { "lights": [
            { "type": "point", "intensity": 54351.41 }, { "type": "directional", "intensity": 683 },
        ] } },
    });
    let corners = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let bytes: Vec<u8> = corners.iter().flat_map(|corner| corner.to_le_bytes()).collect();
    fs::write(there.path().join("a.bin"), bytes).unwrap();
    let write = |json: &Value| fs::write(there.path().join("a.gltf"), json.to_string()).unwrap();
    write(&json);
    for (units, [candela, lux]) in [("file", [54351.41, 683.0]), ("blender", [79.577, 1.0])] {
        let show = ["scenes", "show", "--json", "a.gltf", "--light-units", units];
        let shown: Value = serde_json::from_str(&succeeds(there.path(), &show)).unwrap();
        let [intensity, irradiance] = [
            shown.pointer("/lights/0/point/intensity/0").unwrap().as_f64().unwrap(),
            shown.pointer("/lights/1/distant/irradiance/0").unwrap().as_f64().unwrap(),
        ];
        assert!((intensity / candela - 1.0).abs() < 1e-4, "{units}: {intensity}");
        assert!((irradiance / lux - 1.0).abs() < 1e-4, "{units}: {irradiance}");
    }
    let said = |options: &[&str]| {
        let render = ["render", "a.gltf", "--width", "8", "--spp", "4"];
        let output = ptfast(there.path(), &[&render, options].concat());
        assert!(output.status.success());
        stderr(&output)
    };
    let bright = said(&[]);
    assert!(
        bright.contains("`--exposure auto`") && bright.contains("`--light-units blender`"),
        "{bright}"
    );
    assert!(!said(&["--exposure", "auto"]).contains("too bright"));
    assert!(!said(&["-o", "a.exr"]).contains("too bright"));
    json["asset"]["generator"] = json!("other");
    write(&json);
    let other = said(&[]);
    assert!(other.contains("`--exposure auto`") && !other.contains("light-units"), "{other}");
}

/// All frames have one camera, which shows the object at all times. `--z-up` turns the object.
#[test]
fn files_without_a_camera_are_seen_whole_on_a_ground() {
    let there = tempfile::tempdir().unwrap();
    let (mut json, _) = gltf();
    for node in json["nodes"].as_array_mut().unwrap() {
        let node = node.as_object_mut().unwrap();
        node.remove("camera");
        node.remove("extensions");
    }
    for file in ["gltf parts.bin", "grid.png", "tilted.png"] {
        fs::copy(folder().join(file), there.path().join(file)).unwrap();
    }
    fs::write(there.path().join("a.gltf"), json.to_string()).unwrap();
    fs::write(there.path().join("a.obj"), "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n").unwrap();
    let show = |name: &str, options: &[&str]| -> Value {
        let show = [&["scenes", "show", "--json", name], options].concat();
        serde_json::from_str(&succeeds(there.path(), &show)).unwrap()
    };
    let frame = |at: &str| show("a.gltf", &["--animation", "move", "--at", at]);
    let [start, end] = ["0", "2"].map(frame);
    assert_eq!(start["camera"], end["camera"]);
    assert_ne!(start["primitives"], end["primitives"]);
    let ground = |scene: &Value| scene["materials"].get("ground of the view").is_some();
    assert!(ground(&start) && !ground(&show("a.gltf", &["--no-ground"])));
    fs::copy(folder().join("sky.pfm"), there.path().join("sky.pfm")).unwrap();
    assert!(!ground(&show("a.gltf", &["--env", "sky.pfm"])));
    // The triangle lies, and stands with z up.
    let view = |options: &[&str]| {
        let scene = show("a.obj", options);
        (numbers(&scene["camera"]["look_from"])[2], numbers(&scene["camera"]["look_at"])[2])
    };
    // Its corners are at z = 0 and 1, and at z = -0 and y = 1.
    let [(_, lying), (_, standing)] = [view(&[]), view(&["--z-up"])];
    assert!(lying > 0.3 && standing < 0.2, "{lying} {standing}");
    let output = ptfast(there.path(), &["scenes", "check", "spheres", "--z-up"]);
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
}

/// The reference code of KHR_lights_punctual squares the attenuation between the cones.
#[test]
fn spots_of_gltf_files_fall_by_a_square() {
    let there = tempfile::tempdir().unwrap();
    let json = json!({
        "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }],
        "nodes": [{ "extensions": { "KHR_lights_punctual": { "light": 0 } } }],
        "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "spot", "spot": {} }] } },
    });
    fs::write(there.path().join("a.gltf"), json.to_string()).unwrap();
    let shown = succeeds(there.path(), &["scenes", "show", "a.gltf"]);
    assert!(shown.contains("falloff: square"), "{shown}");
    let text = r#"WorldBegin LightSource "spot""#;
    fs::write(there.path().join("a.pbrt"), text).unwrap();
    assert!(!succeeds(there.path(), &["scenes", "show", "a.pbrt"]).contains("falloff"));
}

#[test]
fn animations_and_variants_can_be_chosen() {
    let show = |options: &[&str]| {
        succeeds(&folder(), &[&["scenes", "show", "gltf.gltf"], options].concat())
    };
    let rest = show(&[]);
    let [start, middle, end] = ["0", "1", "9"].map(|at| show(&["--animation", "move", "--at", at]));
    // The wall moves from x = 0 to 4, the soft part grows, and the lamp turns.
    for (shown, corner) in [
        (&rest, "(-2.0, 0.0, -2.0)"),
        (&start, "(0.0, 0.0, 0.0)"),
        (&middle, "(2.0, 0.0, 0.0)"),
        (&end, "(4.0, 0.0, 0.0)"),
    ] {
        assert!(shown.contains(&format!("vertices: [{corner}")), "{corner} {shown}");
    }
    assert_eq!(show(&["--animation", "0", "--at", "1"]), middle);
    assert!(rest.contains("(0.0, 3.25, 0.0)") && end.contains("(0.0, 3.5, 0.0)"), "{end}");
    // A cubic moves one of two joints from y = 1 to 5. It begins with the slope 4 and ends with 0, so
    // that at the middle, y is 4. The vertices that follow both joints move by half as much.
    let [start, middle, end] = ["0", "1", "2"].map(|at| show(&["--animation", "bend", "--at", at]));
    for (shown, y) in [(&rest, "2.0"), (&start, "2.0"), (&middle, "3.5"), (&end, "4.0")] {
        let line = shown.lines().find(|line| line.ends_with("material: \"veil\"),")).unwrap();
        assert!(line.contains(&format!("(1.5, {y}, 1.0), (0.5, {y}, 1.0)]")), "{y}: {line}");
    }
    let variant = show(&["--variant", "shiny"]);
    assert_eq!(show(&["--variant", "plain"]), rest);
    let notices = stderr(&ptfast(&folder(), &["scenes", "check", "gltf.gltf"]));
    assert!(notices.contains("`--variant` chooses one: plain, shiny"), "{notices}");
    assert!(
        variant != rest && variant.matches("\"car\"").count() > rest.matches("\"car\"").count()
    );
    for (option, name) in [("--variant", "shin"), ("--animation", "mov")] {
        let output = ptfast(&folder(), &["scenes", "check", "gltf.gltf", option, name]);
        let error = stderr(&output);
        assert_eq!(output.status.code(), Some(65), "{error}");
        assert!(
            error.contains(&format!("unknown {} `{name}`, did you mean", &option[2..])),
            "{error}"
        );
    }
}

#[test]
fn files_that_are_missing_and_things_that_ptfast_lacks_are_named() {
    let there = tempfile::tempdir().unwrap();
    let text = r#"Camera "spherical" WorldBegin Texture "a" "spectrum" "imagemap" "string filename" "no.png"
        Material "velvet" Shape "sphere" Shape "sphere" Material "diffuse" "texture reflectance" "a" Shape "sphere"
        Shape "plymesh" "string filename" "no.ply" Shape "nurbs""#;
    fs::write(there.path().join("a.pbrt"), text).unwrap();
    let check = |options: &[&str]| {
        ptfast(there.path(), &[&["scenes", "check", "a.pbrt"], options].concat())
    };
    let output = check(&[]);
    assert_eq!(output.status.code(), Some(74));
    let error = stderr(&output);
    assert!(error.contains("no.png: cannot read") && error.contains("`--missing grey`"), "{error}");
    let output = check(&["--missing", "grey"]);
    let said = stderr(&output);
    assert!(output.status.success() && stdout(&output).contains("3 spheres"), "{said}");
    for line in [
        "ptfast: a.pbrt: the camera spherical is not supported, so it is a perspective",
        "ptfast: a.pbrt: no.png is missing, so it is grey",
        "ptfast: a.pbrt: the material velvet is not supported, so it is matte grey",
        "ptfast: a.pbrt: no.ply is missing, so it is left out",
        "ptfast: a.pbrt: the shape nurbs is not supported, so it is left out",
    ] {
        assert_eq!(said.matches(line).count(), 1, "{line}: {said}");
    }
    let output = check(&["--missing", "grey", "--strict"]);
    let error = stderr(&output);
    assert_eq!((output.status.code(), error.lines().count()), (Some(2), 1), "{error}");
    assert!(error.contains("spherical") && error.contains("`--strict` rejects that"), "{error}");
}

/// A missing file of any kind has the exit code 74. The option is named only where it helps.
#[test]
fn missing_files_have_one_exit_code() {
    let there = tempfile::tempdir().unwrap();
    let there = there.path();
    fs::write(there.join("a.obj"), "mtllib no.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n")
        .unwrap();
    let buffer =
        json!({ "asset": { "version": "2.0" }, "buffers": [{ "byteLength": 9, "uri": "no.bin" }] });
    fs::write(there.join("a.gltf"), buffer.to_string()).unwrap();
    fs::write(there.join("a.pbrt"), "WorldBegin Include \"no.pbrt\"").unwrap();
    fs::write(there.join("b.pbrt"), "WorldBegin Shape \"plymesh\" \"string filename\" \"no.ply\"")
        .unwrap();
    for (arguments, file, helps) in [
        (&["a.obj"][..], "no.mtl", true),
        (&["a.gltf"], "no.bin", false),
        (&["a.pbrt"], "no.pbrt", true),
        (&["b.pbrt"], "no.ply", true),
        (&["no.glb"], "no.glb", false),
        (&["spheres", "--env", "no.hdr"], "no.hdr", false),
    ] {
        let output = ptfast(there, &[&["scenes", "check"], arguments].concat());
        let error = stderr(&output);
        assert_eq!((output.status.code(), error.lines().count()), (Some(74), 1), "{error}");
        assert!(error.contains(&format!("{file}: cannot read")), "{error}");
        assert_eq!(error.contains("`--missing grey`"), helps, "{error}");
    }
}

/// The scene `a.pbrt` with this text, as JSON with all triangles.
fn shown(there: &Path, text: &str) -> Value {
    let path = there.join("a.pbrt");
    fs::write(&path, text).unwrap();
    let path = path.to_str().unwrap();
    let description = SceneDescription::load(path, &ImportOptions::default(), &Limits::default());
    serde_json::from_str(&description.unwrap().to_json()).unwrap()
}

/// The numbers in `value`, in order.
fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(values) => values.iter().flat_map(numbers).collect(),
        Value::Object(fields) => fields.values().flat_map(numbers).collect(),
        _ => value.as_f64().into_iter().collect(),
    }
}

/// `pbrt.pbrt` has only one camera and one filter, so the others are tested here.
#[test]
fn other_parts_of_pbrt_files_have_these_values() {
    let there = tempfile::tempdir().unwrap();
    let camera = "Camera \"perspective\"";
    let fog = r#"MakeNamedMedium "fog" "rgb sigma_a" [ 1 1 1 ] "rgb sigma_s" [ 3 3 3 ]"#;
    let sun = r#"LightSource "distant" "point3 to" [ 0 -1 0 ] "float illuminance" 2"#;
    for (head, body, pointer, want) in [
        // The shorter side of the picture, its height, spans four units.
        (
            r#"Camera "orthographic" "float screenwindow" [ -2 2 -2 2 ]"#,
            "",
            "/camera/parallel",
            json!(4),
        ),
        (r#"PixelFilter "box""#, camera, "/camera/filter", Value::Null),
        (
            r#"Sampler "stratified" "integer xsamples" 8 "integer ysamples" 4"#,
            "",
            "/render/spp",
            json!(32),
        ),
        (
            r#"PixelFilter "gaussian" "float xradius" 2 "float sigma" 0.5"#,
            "",
            "/camera/filter/gaussian",
            json!({ "radius": 2, "sigma": 0.5 }),
        ),
        (
            r#"PixelFilter "mitchell" "float xradius" 3 "float B" 0.5 "float C" 0.25"#,
            "",
            "/camera/filter/mitchell",
            json!({ "radius": 3, "b": 0.5, "c": 0.25 }),
        ),
        // The white of sRGB.
        (
            camera,
            r#"LightSource "point" "xyz I" [ 0.95047 1 1.08883 ]"#,
            "/lights/0/point/intensity",
            json!([1, 1, 1]),
        ),
        (camera, sun, "/lights/0/distant/irradiance", json!([2, 2, 2])),
        // Radiance π lights a floor with π².
        (
            camera,
            r#"LightSource "infinite" "rgb L" [ 1 1 1 ] "float illuminance" 9.8696044"#,
            "/background/constant/radiance",
            json!([PI, PI, PI]),
        ),
        (
            &format!("{fog} MediumInterface \"\" \"fog\" {camera}"),
            "",
            "/media/0/box/density",
            json!(4),
        ),
        (
            &format!("{fog} MediumInterface \"\" \"fog\" {camera}"),
            "",
            "/media/0/box/albedo",
            json!([0.75, 0.75, 0.75]),
        ),
    ] {
        let scene = shown(there.path(), &format!("{head} WorldBegin {body}"));
        let got = scene.pointer(pointer).cloned().unwrap_or_default();
        let (numbers, wanted) = (numbers(&got), numbers(&want));
        let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-3 * b.abs();
        assert!(
            numbers.len() == wanted.len() && numbers.iter().zip(&wanted).all(near),
            "{head} {body}: {got}"
        );
    }
}

/// Spheres of ptfast have other poles than those of pbrt, and no opacity.
#[test]
fn spheres_of_pbrt_files_become_triangles_where_needed() {
    let there = tempfile::tempdir().unwrap();
    fs::copy(folder().join("grid.png"), there.path().join("grid.png")).unwrap();
    let texture = r#"Texture "t" "spectrum" "imagemap" "string filename" "grid.png"
        Material "diffuse" "texture reflectance" "t""#;
    let primitive = |text: &str| {
        let scene = shown(there.path(), &format!("WorldBegin {text}"));
        assert_eq!(scene["primitives"].as_array().unwrap().len(), 1);
        scene["primitives"][0].clone()
    };
    assert!(primitive("Shape \"sphere\"").get("sphere").is_some());
    assert!(primitive("Shape \"sphere\" \"float alpha\" 0.5").get("triangles").is_some());
    let [upright, lying] = ["", "Rotate 90 1 0 0"].map(|turn| {
        let sphere = primitive(&format!("{texture} {turn} Shape \"sphere\""));
        // The first vertex is at the pole where v = 0.
        numbers(&sphere["triangles"]["vertices"][0])
    });
    let near = |at: &[f64], want: [f64; 3]| at.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(near(&upright, [0.0, 0.0, -1.0]) && near(&lying, [0.0, 1.0, 0.0]), "{lying:?}");
}

/// Expected: the radiance L with area · π · L = power, for each patch of pbrt.
#[test]
fn power_of_pbrt_lights_is_spread_over_their_area() {
    let there = tempfile::tempdir().unwrap();
    let light = r#"AreaLightSource "diffuse" "float power" 3.14159265 Material "interface""#;
    let patch = r#""point3 P" [ 0 0 0  1 0 0  0 1 0  1 1 0 ]"#;
    for shape in [
        format!(r#"Shape "bilinearmesh" {patch}"#),
        r#"Shape "disk" "float radius" 0.56418958"#.to_owned(),
    ] {
        let scene = shown(there.path(), &format!("WorldBegin {light} {shape}"));
        let radiance = numbers(&scene["materials"]);
        assert!(radiance.iter().all(|c| (c - 1.0).abs() < 1e-5), "{shape}: {radiance:?}");
    }
}

#[test]
fn stretched_spheres_of_pbrt_files_are_ellipsoids() {
    let there = tempfile::tempdir().unwrap();
    let text = r#"WorldBegin Translate 1 2 3 Scale 1 2 4 Shape "sphere" "float radius" 0.5"#;
    let scene = shown(there.path(), text);
    let mesh = &scene["primitives"][0]["triangles"];
    let (mut low, mut high) = ([f64::MAX; 3], [f64::MIN; 3]);
    for (vertex, normal) in
        numbers(&mesh["vertices"]).chunks(3).zip(numbers(&mesh["normals"]).chunks(3))
    {
        let center = [1.0, 2.0, 3.0];
        let unit: Vec<f64> = (0..3).map(|i| (vertex[i] - center[i]) / [0.5, 1.0, 2.0][i]).collect();
        let square: f64 = unit.iter().map(|x| x * x).sum();
        assert!((square - 1.0).abs() < 1e-5, "{vertex:?}");
        // The gradient of x² + y²/4 + z²/16.
        let gradient: Vec<f64> = (0..3).map(|i| unit[i] / [0.5, 1.0, 2.0][i]).collect();
        let length = gradient.iter().map(|x| x * x).sum::<f64>().sqrt();
        let along: f64 = (0..3).map(|i| gradient[i] / length * normal[i]).sum();
        let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!(along > 0.9999 * length, "{vertex:?} {normal:?}");
        for i in 0..3 {
            (low[i], high[i]) = (low[i].min(vertex[i]), high[i].max(vertex[i]));
        }
    }
    assert_eq!((low, high), ([0.5, 1.0, 1.0], [1.5, 3.0, 5.0]));
}

#[test]
fn errors_of_pbrt_files_name_the_line() {
    let there = tempfile::tempdir().unwrap();
    for (text, want) in [
        ("Shape \"sphere", "a.pbrt:2: the text has no closing"),
        ("Shap \"sphere\"", "a.pbrt:2: unknown directive `Shap`, did you mean `Shape`?"),
        ("Scale 1 2", "a.pbrt:2: expected 3 numbers"),
        ("Scale 0 1 1", "a.pbrt:2: the transform is singular"),
        ("AttributeEnd", "a.pbrt:2: `AttributeEnd` without its beginning"),
        (
            "AttributeBegin TransformEnd",
            "a.pbrt:2: `TransformEnd` where `AttributeEnd` is expected",
        ),
        ("AttributeBegin", "a.pbrt: `AttributeEnd` is missing"),
        ("NamedMaterial \"a\"", "a.pbrt:2: unknown material \"a\""),
        ("ObjectInstance \"a\"", "a.pbrt:2: unknown object \"a\""),
        ("Shape \"sphere\" \"float radius\" true", "a.pbrt:2: `radius` must be numbers"),
        ("Shape \"trianglemesh\" \"point3 P\" [ 0 0 ]", "a.pbrt:2: `P` must be groups of 3"),
        ("Include \"a.pbrt\"", "a.pbrt: the file includes itself"),
    ] {
        fs::write(there.path().join("a.pbrt"), format!("WorldBegin\n{text}\n")).unwrap();
        let output = ptfast(there.path(), &["scenes", "check", "a.pbrt"]);
        let error = stderr(&output);
        assert_eq!((output.status.code(), error.lines().count()), (Some(65), 1), "{text}: {error}");
        assert!(error.contains(want), "{text}: {error}");
    }
}
