//! Tests of images that other programs write, used as textures and environment maps.

use std::fs;
use std::path::Path;

use crate::common::{ptfast, stderr, stdout};

/// A square of 2 × 2 that fills the picture, and emits the light of a texture.
const SQUARE: &str = r#"(camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), parallel: 2),
    render: (width: 2, height: 2, spp: 1, depth: 1),
    textures: {"t": image(file: "FILE", filter: nearest)},
    materials: {"m": principled(base_color: (0, 0, 0), specular: 0, emission: "t")},
    primitives: [quad(q: (-1, -1, 0), u: (2, 0, 0), v: (0, 2, 0), material: "m")])"#;

/// The picture of the square with an image as texture, and the messages.
fn square(there: &Path, image: &str) -> (Vec<[f32; 3]>, String) {
    fs::write(there.join("a.ron"), SQUARE.replace("FILE", image)).unwrap();
    let said = stderr(&ptfast(there, &["scenes", "check", "a.ron"]));
    let output = ptfast(there, &["render", "a.ron", "-q", "-o", "a.pfm"]);
    assert_eq!(output.status.code(), Some(0), "{image}: {}", stderr(&output));
    (ptfast::Image::read(&there.join("a.pfm")).unwrap().pixels().to_vec(), said)
}

/// A portable float map of 2 × 2 pixels, row by row from the bottom.
fn pfm(scale: &str, pixels: [[f32; 3]; 4]) -> Vec<u8> {
    let values = pixels.into_iter().flatten().flat_map(f32::to_le_bytes);
    format!("PF\n2 2\n{scale}\n").into_bytes().into_iter().chain(values).collect()
}

/// `oiiotool --resize` makes negative pixels in every map with a sun. Blender and Mitsuba load such files.
#[test]
fn pixels_without_a_meaning_are_mended_with_a_notice() {
    let there = tempfile::tempdir().unwrap();
    let there = there.path();
    let bad = [[-0.01, 0.5, 0.5], [f32::NAN, 1.0, 1.0], [f32::INFINITY, 1.0, 1.0], [0.25; 3]];
    fs::write(there.join("bad.pfm"), pfm("-1", bad)).unwrap();
    fs::write(there.join("good.pfm"), pfm("-1", [[0.5; 3]; 4])).unwrap();
    let notice = "bad.pfm: 1 negative texels count as 0, 1 infinite texels count as 65504, \
                  1 NaN texels count as black";
    let (picture, said) = square(there, "bad.pfm");
    assert_eq!(picture, [[65504.0, 1.0, 1.0], [0.25; 3], [0.0, 0.5, 0.5], [0.0; 3]]);
    assert_eq!((said.matches(notice).count(), said.lines().count()), (1, 1), "{said}");
    assert_eq!(square(there, "good.pfm").1, "");
    // The same notice, whatever format names the file.
    let triangle = "\"point3 P\" [0 0 0 1 0 0 0 1 0]";
    let pbrt = format!(
        "WorldBegin LightSource \"infinite\" \"string filename\" \"bad.pfm\"\n\
         Shape \"trianglemesh\" {triangle} \"integer indices\" [0 1 2]\n"
    );
    fs::write(there.join("a.pbrt"), pbrt).unwrap();
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n";
    fs::write(there.join("a.obj"), obj).unwrap();
    fs::write(there.join("a.mtl"), "newmtl m\nKe 1 1 1\nmap_Ke bad.pfm\n").unwrap();
    let gltf = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}"#;
    fs::write(there.join("a.gltf"), gltf).unwrap();
    for scene in [&["a.pbrt"][..], &["a.obj"], &["a.gltf", "--env", "bad.pfm"]] {
        let output = ptfast(there, &[&["scenes", "check"], scene].concat());
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(0), "{scene:?}: {said}");
        assert_eq!(said.matches(notice).count(), 1, "{scene:?}: {said}");
    }
}

/// An EXR file of 2 × 2 pixels, in which every channel has one value.
fn exr(path: &Path, channels: &[(&str, f32)]) {
    use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
    use exr::prelude::{LayerAttributes, WritableImage};
    let channel =
        |&(name, value): &(&str, f32)| AnyChannel::new(name, FlatSamples::F32(vec![value; 4]));
    let channels = AnyChannels::sort(channels.iter().map(channel).collect());
    let attributes = LayerAttributes::default();
    let layer = Layer::new((2, 2), attributes, Encoding::UNCOMPRESSED, channels);
    Image::from_layer(layer).write().non_parallel().to_file(path).unwrap();
}

/// Blender writes such files; `a.exr:LAYER` names a layer wherever an image is named.
#[test]
fn layers_of_exr_files_are_textures_environments_and_compared() {
    let there = tempfile::tempdir().unwrap();
    let there = there.path();
    let channels = ["R", "G", "B"].map(|c| [format!("L.Combined.{c}"), format!("L.AO.{c}")]);
    let channels: Vec<(&str, f32)> =
        channels.iter().flat_map(|[a, b]| [(a.as_str(), 0.25), (b.as_str(), 0.5)]).collect();
    exr(&there.join("a.exr"), &channels);
    exr(&there.join("grey.exr"), &[("Y", 0.5)]);
    assert_eq!(square(there, "a.exr").0, [[0.25; 3]; 4]);
    assert_eq!(square(there, "a.exr:L.AO").0, [[0.5; 3]; 4]);
    assert_eq!(square(there, "grey.exr").0, [[0.5; 3]; 4]);
    let runs = |arguments: &[&str]| {
        let output = ptfast(there, arguments);
        (output.status.code(), stderr(&output))
    };
    assert_eq!(runs(&["compare", "a.exr:L.AO", "grey.exr"]), (Some(0), String::new()));
    assert_eq!(runs(&["compare", "a.exr:L.Combined", "grey.exr"]).0, Some(1));
    let (code, said) = runs(&["compare", "a.exr:L.A", "grey.exr"]);
    assert_eq!(
        (code, said.contains("it has no layer `L.A`, did you mean `L.AO`?")),
        (Some(65), true),
        "{said}"
    );
    let env = ["scenes", "check", "spheres", "--env"];
    assert_eq!(runs(&[&env[..], &["a.exr:L.AO"]].concat()), (Some(0), String::new()));
    // Files outside the folder of the scene stay refused.
    fs::create_dir(there.join("scene")).unwrap();
    fs::write(there.join("scene/a.ron"), SQUARE.replace("FILE", "../a.exr:L.AO")).unwrap();
    let (code, said) = runs(&["scenes", "check", "scene/a.ron"]);
    assert_eq!((code, said.contains("outside the folder")), (Some(65), true), "{said}");
}

/// The formula of a surface with opacity α and reflectance c before a white sky of radiance 1: c α + 1 − α, as Cycles
/// shows it. The file has c α.
#[test]
fn colors_of_exr_files_are_divided_by_the_alpha_that_a_material_uses() {
    let there = tempfile::tempdir().unwrap();
    let there = there.path();
    exr(&there.join("a.exr"), &[("R", 0.4), ("G", 0.2), ("B", 0.1), ("A", 0.5)]);
    let mean = |opacity: &str| {
        let scene = format!(
            r#"(camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), parallel: 1),
            background: constant(radiance: (1, 1, 1)), render: (width: 8, height: 8, spp: 256, depth: 3),
            textures: {{"t": image(file: "a.exr")}}, materials: {{"m": lambertian(albedo: "t"{opacity})}},
            primitives: [triangles(vertices: [(-9, -9, 0), (9, -9, 0), (0, 18, 0)], indices: [(0, 1, 2)],
                material: "m")])"#
        );
        fs::write(there.join("a.ron"), scene).unwrap();
        let output = ptfast(there, &["render", "a.ron", "-q", "-o", "a.pfm"]);
        assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
        ptfast::Image::read(&there.join("a.pfm")).unwrap().mean()
    };
    let near = |found: [f64; 3], want: [f64; 3]| {
        assert!(found.iter().zip(want).all(|(a, b)| (a - b).abs() < 0.01), "{found:?} {want:?}");
    };
    near(mean(", opacity: blend(alpha: (texture: \"t\", channel: a))"), [0.9, 0.7, 0.6]);
    near(mean(""), [0.4, 0.2, 0.1]);
}

/// A lossless file of 3 × 2 pixels, as OpenImageIO 3.2 wrote it.
const WEBP: &[u8] = b"\
    \x52\x49\x46\x46\x48\x00\x00\x00\x57\x45\x42\x50\x56\x50\x38\x4c\x3b\x00\
    \x00\x00\x2f\x02\x40\x00\x10\x2f\x40\x90\x6d\x53\x89\x79\xdd\x5f\xe6\x1a\
    \x64\xd2\x36\xed\x5b\xff\x7a\x66\x6d\x64\xd2\x36\xad\x87\xde\xf3\xef\x72\
    \x04\x92\x36\x36\x1f\x4f\xfe\x00\x9c\x9f\xa3\xab\xb5\x05\x02\x12\x32\x25\
    \x8f\x7c\x11\xd1\xff\x88\x05\x00\
    ";

/// Extensions that replace the image of a texture.
#[test]
fn gltf_files_have_webp_and_ktx2_textures() {
    let there = tempfile::tempdir().unwrap();
    let there = there.path();
    fs::write(there.join("a.webp"), WEBP).unwrap();
    let ktx2 = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/images/uastc.ktx2");
    fs::copy(ktx2, there.join("a.ktx2")).unwrap();
    let checked = |extension: &str| {
        let scene = format!(
            r#"{{"asset": {{"version": "2.0"}}, "scenes": [{{"nodes": [0]}}], "nodes": [{{"mesh": 0}}],
            "extensionsUsed": ["{extension}"], "extensionsRequired": ["{extension}"],
            "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "material": 0}}]}}],
            "materials": [{{"pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0}}}}}}],
            "textures": [{{"extensions": {{"{extension}": {{"source": 0}}}}}}],
            "images": [{{"uri": "a.{}"}}], "bufferViews": [{{"buffer": 0, "byteLength": 36}}],
            "buffers": [{{"byteLength": 36, "uri": "a.bin"}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}}]}}"#,
            if extension.ends_with("webp") { "webp" } else { "ktx2" }
        );
        let corners = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        fs::write(there.join("a.bin"), corners.map(f32::to_le_bytes).concat()).unwrap();
        fs::write(there.join("a.gltf"), scene).unwrap();
        let output = ptfast(there, &["scenes", "check", "a.gltf"]);
        let said = stderr(&output);
        assert_eq!(output.status.code(), Some(0), "{said}");
        assert!(!said.contains("grey") && !said.contains("not supported"), "{said}");
        stdout(&output)
    };
    let found = checked("EXT_texture_webp");
    assert!(found.contains(".webp"), "{found}");
    let found = checked("KHR_texture_basisu");
    assert!(found.contains(".ktx2"), "{found}");
}
