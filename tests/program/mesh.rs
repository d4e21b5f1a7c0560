//! Tests of scene files that name mesh files.

use std::fs;
use std::path::Path;

use ptfast::Scene;

use crate::common::{ptfast, stderr, stdout};

/// A tetrahedron.
const VERTICES: [[f32; 3]; 4] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.25, 1.0]];
const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

fn obj() -> String {
    let vertices = VERTICES.map(|[x, y, z]| format!("v {x} {y} {z}\n")).concat();
    let faces = FACES.map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1)).concat();
    vertices + &faces
}

fn ply() -> String {
    let vertices = VERTICES.map(|[x, y, z]| format!("{x} {y} {z}\n")).concat();
    let faces = FACES.map(|[a, b, c]| format!("3 {a} {b} {c}\n")).concat();
    format!(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
         property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n\
         {vertices}{faces}"
    )
}

fn scene(primitive: &str) -> String {
    format!(
        r#"(
    camera: (look_from: (3, 2, 4), look_at: (0, 0, 0), vfov: 40),
    background: constant(radiance: (1, 1, 1)),
    render: (width: 40, height: 30, spp: 2),
    materials: {{"grey": lambertian(albedo: (0.5, 0.5, 0.5))}},
    primitives: [{primitive}],
)"#
    )
}

/// A folder with both mesh files, and a scene file for each name and primitive.
fn folder(scenes: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| fs::write(folder.path().join(name), text).unwrap();
    fs::create_dir(folder.path().join("meshes")).unwrap();
    write("meshes/a.obj", obj());
    write("meshes/a.PLY", ply());
    for (name, primitive) in scenes {
        write(name, scene(primitive));
    }
    folder
}

fn load(folder: &Path, name: &str) -> Scene {
    Scene::load(folder.join(name).to_str().unwrap()).unwrap()
}

#[test]
fn files_and_lists_of_equal_triangles_give_the_same_scene() {
    let list = format!("triangles(vertices: {VERTICES:?}, indices: {FACES:?}, material: \"grey\")")
        .replace('[', "(")
        .replace(']', ")");
    // The outer lists keep their square brackets.
    let list = list.replace("vertices: (", "vertices: [").replace("), indices: (", "], indices: [");
    let list = list.replace("), material", "], material");
    let folder = folder(&[
        ("list.ron", &list),
        ("obj.ron", r#"mesh(file: "meshes/a.obj", material: "grey")"#),
        ("ply.ron", r#"mesh(file: "meshes/a.PLY", material: "grey")"#),
    ]);
    let list = load(folder.path(), "list.ron");
    assert_eq!(list.geometry().triangles.len(), 4);
    for name in ["obj.ron", "ply.ron"] {
        let mesh = load(folder.path(), name);
        let triangles = |scene: &Scene| scene.geometry().triangles.iter().collect::<Vec<_>>();
        assert_eq!(triangles(&mesh), triangles(&list), "{name}");
        assert_eq!(mesh.hash(), list.hash(), "{name}");
    }
    // Meshes are found relative to the scene file, so the current folder does not matter.
    let render = |name: &str| {
        let scene = folder.path().join(name);
        let elsewhere = tempfile::tempdir().unwrap();
        let arguments = ["render", "--scene", scene.to_str().unwrap(), "-o", "a.png"];
        let output = ptfast(elsewhere.path(), &arguments);
        assert!(output.status.success(), "{}", stderr(&output));
        let text = stdout(&output);
        text.lines().find(|line| line.starts_with("hash")).unwrap().to_owned()
    };
    assert_eq!(render("obj.ron"), render("list.ron"));
    assert_eq!(render("ply.ron"), render("list.ron"));
}

/// A square with normals and texture coordinates, in three forms.
#[test]
fn normals_and_texture_coordinates_are_read() {
    let list = r#"triangles(
        vertices: [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],
        indices: [(0, 1, 2), (0, 2, 3)],
        normals: [(0, 0, 1), (1, 0, 0), (0, 0, 1), (0, 1, 0)],
        uvs: [(0, 0), (2, 0), (2, 1), (0, 1)], material: "grey")"#;
    let folder = folder(&[
        ("list.ron", list),
        ("obj.ron", r#"mesh(file: "meshes/b.obj", material: "grey")"#),
        ("ply.ron", r#"mesh(file: "meshes/b.ply", smooth: on, material: "grey")"#),
        ("flat.ron", r#"mesh(file: "meshes/b.ply", smooth: off, material: "grey")"#),
        ("hard.ron", r#"mesh(file: "meshes/b.ply", soft_terminator: false, material: "grey")"#),
        ("made.ron", r#"mesh(file: "meshes/a.obj", smooth: on, material: "grey")"#),
        ("none.ron", r#"mesh(file: "meshes/a.obj", smooth: auto, material: "grey")"#),
        ("a.ron", r#"mesh(file: "meshes/a.obj", material: "grey")"#),
    ]);
    let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 2 0\nvt 2 1\nvt 0 1\n\
               vn 0 0 7\nvn 1 0 0\nvn 0 2 0\nf 1/1/1 2/2/2 3/3/1 4/4/3\n";
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
               property float z\nproperty float nx\nproperty float ny\nproperty float nz\n\
               property float s\nproperty float t\nelement face 1\n\
               property list uchar int vertex_indices\nend_header\n0 0 0 0 0 1 0 0\n\
               1 0 0 1 0 0 2 0\n1 1 0 0 0 1 2 1\n0 1 0 0 1 0 0 1\n4 0 1 2 3\n";
    fs::write(folder.path().join("meshes/b.obj"), obj).unwrap();
    fs::write(folder.path().join("meshes/b.ply"), ply).unwrap();
    let hash = |name: &str| load(folder.path(), name).hash();
    assert_eq!(hash("list.ron"), hash("obj.ron"));
    assert_eq!(hash("list.ron"), hash("ply.ron"));
    for name in ["flat.ron", "hard.ron"] {
        assert_ne!(hash("list.ron"), hash(name), "{name}");
    }
    assert_eq!(hash("a.ron"), hash("none.ron"), "the file has no normals");
    assert_ne!(hash("a.ron"), hash("made.ron"));
}

/// Colours in both formats, of integers and of floats, and those that no texture can have.
#[test]
fn colours_and_groups_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let ply = |kind: &str, colors: [&str; 3]| {
        let [a, b, c] = colors;
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
             property float z\nproperty {kind} red\nproperty {kind} green\nproperty {kind} blue\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n\
             0 0 0 {a}\n1 0 0 {b}\n0 1 0 {c}\n3 0 1 2\n"
        )
    };
    file("bytes.ply", &ply("uchar", ["255 0 51", "0 255 0", "0 0 255"]));
    file("words.ply", &ply("ushort", ["65535 0 13107", "0 65535 0", "0 0 65535"]));
    file("floats.ply", &ply("float", ["1 0 0.2", "0 1 0", "0 0 1"]));
    file("range.ply", &ply("float", ["255 0 51", "0 255 0", "0 0 255"]));
    file("a.obj", "v 0 0 0 1 0 0.2\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\ng a\nf 1 2 3\ng b c\nf 1 3 2\n");
    let load_as = |albedo: &str, primitive: &str| {
        let text = format!(
            r#"(camera: (look_from: (0, 0, 5), look_at: (0.3, 0.3, 0), vfov: 10),
                textures: {{"c": vertex_color()}}, materials: {{"m": lambertian(albedo: {albedo})}},
                background: constant(radiance: (1, 1, 1)), primitives: [{primitive}])"#
        );
        file("a.ron", &text);
        let path = folder.path().join("a.ron");
        Scene::load(path.to_str().unwrap()).unwrap()
    };
    let load = |primitive: &str| load_as("\"c\"", primitive);
    let mesh = |file: &str| load(&format!(r#"mesh(file: "{file}", material: "m")"#));
    let bytes = mesh("bytes.ply");
    assert_eq!(bytes.hash(), mesh("words.ply").hash());
    assert_eq!(bytes.hash(), mesh("floats.ply").hash());
    let group =
        |name: &str| load(&format!(r#"mesh(file: "a.obj", group: "{name}", material: "m")"#));
    assert_eq!(bytes.hash(), group("a").hash());
    assert_eq!(mesh("a.obj").geometry().triangles.len(), 2);
    assert_eq!(group("b c").geometry().triangles.len(), 1);
    // 0.2 in sRGB is 0.0331 in linear RGB.
    let list = |blue: &str| {
        let triangle = "vertices: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], indices: [(0, 1, 2)]";
        let colors = format!("colors: [(1, 0, {blue}), (0, 1, 0), (0, 0, 1)]");
        load(&format!(r#"triangles({triangle}, {colors}, material: "m")"#)).hash()
    };
    assert_eq!(bytes.hash(), list("0.033104766"));
    assert_ne!(bytes.hash(), list("0.2"));
    // Without a texture that uses them, colours do not matter.
    let grey = |name: &str| {
        load_as("(0.5, 0.5, 0.5)", &format!(r#"mesh(file: "{name}", material: "m")"#)).hash()
    };
    assert_eq!(grey("bytes.ply"), grey("range.ply"));
    let notice = "range.ply: ignoring colours outside [0, 1]";
    mesh("range.ply");
    let said = stderr(&ptfast(folder.path(), &["scenes", "check", "a.ron"]));
    assert!(said.contains(notice), "{said}");
    // Real scenes have meshes without any area.
    for fields in [
        "scale: 1e-6, translation: (1e9, 1e9, 1e9)",
        "matrix: ((1, 0, 0, 1e9), (0, 1, 0, 1e9), (0, 0, 1, 1e9)), scale: 1e-6",
    ] {
        load_as("(0.5, 0.5, 0.5)", &format!(r#"mesh(file: "range.ply", {fields}, material: "m")"#));
        let said = stderr(&ptfast(folder.path(), &["scenes", "check", "a.ron"]));
        assert!(
            said.contains("range.ply: ignoring all triangles, since they have no area"),
            "{said}"
        );
    }
    // A mesh by itself is shown in its colours.
    for (name, kind) in [("bytes.ply", "texture"), ("range.ply", "colour")] {
        let shown = stdout(&ptfast(folder.path(), &["scenes", "show", name]));
        assert_eq!(shown.contains("vertex_color"), kind == "texture", "{shown}");
    }
}

#[test]
fn meshes_are_scaled_turned_and_moved() {
    let folder = folder(&[
        ("b.ron", r#"mesh(file: "meshes/a.PLY", rotation: (90, 90, 0), material: "grey")"#),
        (
            "a.ron",
            r#"mesh(file: "meshes/a.obj", scale: 2, rotation: (0, 90, 0), translation: (10, 20, 30),
            material: "grey")"#,
        ),
    ]);
    // The rotation about x comes first: y becomes z, which becomes x.
    let turned = load(folder.path(), "b.ron").geometry().triangles.vertices(0)[1];
    assert_eq!(turned.to_array(), [1.0, 0.0, 0.0]);
    let scene = load(folder.path(), "a.ron");
    // Vertices 0, 2, 1: x becomes −z, y stays.
    let vertices = scene.geometry().triangles.vertices(0).map(|v| v.to_array());
    assert_eq!(vertices, [[10.0, 20.0, 30.0], [10.0, 22.0, 30.0], [10.0, 20.0, 28.0]]);
}

#[test]
fn mesh_errors_name_file_and_line() {
    let cases = [
        (r#"file: "meshes/b.obj""#, "meshes/b.obj: cannot read"),
        (r#"file: "meshes""#, "unsupported file extension, meshes are .obj or .ply files"),
        (r#"file: "meshes/folder.ply""#, "meshes/folder.ply: cannot read: is a directory"),
        (r#"file: "meshes/empty.obj""#, "meshes/empty.obj: the file has no faces"),
        (r#"file: "meshes/broken.obj""#, "meshes/broken.obj:7: the face refers to a missing"),
        (r#"file: "meshes/broken.ply""#, "meshes/broken.ply:15: the face refers to a missing"),
        (r#"file: "meshes/a.obj", scale: 0"#, "scale must be above 0 and at most 1e9, is 0.0"),
        (
            r#"file: "meshes/a.obj", scale: 1e9, translation: (1e9, 0, 0)"#,
            "meshes/a.obj: a vertex is placed at",
        ),
        (r#"file: "meshes/a.obj", rotation: (0, 1e9, 0)"#, "rotation must be finite, within"),
        (r#"file: "meshes/a.obj", translation: (0, 1e10, 0)"#, "translation must be finite"),
        (r#"file: "meshes/a.obj", size: 2"#, "unknown field `size`"),
    ];
    for (fields, message) in cases {
        let folder = folder(&[("a.ron", &format!(r#"mesh({fields}, material: "grey")"#))]);
        let write = |name: &str, text: String| fs::write(folder.path().join(name), text).unwrap();
        fs::create_dir(folder.path().join("meshes/folder.ply")).unwrap();
        write("meshes/empty.obj", "v 0 0 0\n".to_owned());
        write("meshes/broken.obj", obj().replace("f 2 3 4", "f 2 3 5"));
        write("meshes/broken.ply", ply().replace("3 0 1 3", "3 0 1 4"));
        let output = ptfast(folder.path(), &["render", "--scene", "a.ron", "-o", "a.png"]);
        let text = stderr(&output);
        let code = if message.contains("cannot read") { 74 } else { 65 };
        assert_eq!(output.status.code(), Some(code), "{text}");
        assert_eq!(text.lines().count(), 1, "{text}");
        assert!(text.starts_with("ptfast: a.ron:") && text.contains(message), "{fields}: {text}");
        assert!(!folder.path().join("a.png").exists());
    }
}
