//! Tests of the reader.

use glam::Vec3;

use super::*;
use crate::limits::{Limit, Limits};
use crate::math::{cross, length};

const HEADER: &str = "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\n\
    property float x\nproperty double y\nproperty int z\nproperty uchar red\n\
    element face 2\nproperty list uchar int vertex_indices\nend_header\n";
const VERTICES: &str = "0 0 0 255\n1 0.5 0 255\n1 1 0 255\n0 1 2 255\n";

fn budget() -> Budget {
    Budget::new(&Limits::default(), 0)
}

fn message(text: &str) -> String {
    let message = parse("a.ply", text.as_bytes(), &budget()).unwrap_err().to_string();
    assert!(!message.contains('\n') && message.len() < 300);
    message
}

#[test]
fn text_of_any_types_with_polygons() {
    let text = format!("{HEADER}{VERTICES}3 0 1 2\n4 0 1 2 3\n");
    let mesh = parse("a.ply", text.as_bytes(), &budget()).unwrap();
    assert_eq!(mesh.vertices.positions[1], Vec3::new(1.0, 0.5, 0.0));
    assert_eq!(mesh.vertices.positions[3], Vec3::new(0.0, 1.0, 2.0));
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 1, 2], [0, 2, 3]]);
}

#[test]
fn binary_of_both_orders() {
    for (format, little) in [("binary_little_endian", true), ("binary_big_endian", false)] {
        let header = format!(
            "ply\nformat {format} 1.0\nelement vertex 3\nproperty float x\n\
             property float y\nproperty float z\nelement face 1\n\
             property list uchar uint vertex_index\nend_header\n"
        );
        let mut bytes = header.into_bytes();
        for c in [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.5] {
            bytes.extend(if little { c.to_le_bytes() } else { c.to_be_bytes() });
        }
        bytes.push(3);
        for i in [2u32, 0, 1] {
            bytes.extend(if little { i.to_le_bytes() } else { i.to_be_bytes() });
        }
        let mesh = parse("a.ply", &bytes, &budget()).unwrap();
        assert_eq!(mesh.vertices.positions[2], Vec3::new(0.0, 1.0, 0.5));
        assert_eq!(mesh.triangles, [[2, 0, 1]]);
        let cut = parse("a.ply", &bytes[..bytes.len() - 2], &budget()).unwrap_err().to_string();
        assert!(cut.starts_with("a.ply:face: the file ends before the last of 1 rows"), "{cut}");
        let last = bytes.len() - 1;
        bytes[if little { last - 3 } else { last }] = 3;
        let wrong = parse("a.ply", &bytes, &budget()).unwrap_err().to_string();
        assert_eq!(
            wrong,
            "a.ply:face[0]: the face refers to a missing vertex, the file has 3 vertices"
        );
    }
}

#[test]
fn errors_name_the_line() {
    let faces = "3 0 1 2\n3 0 2 3\n";
    let beyond = "the face refers to a missing vertex, the file has 4 vertices";
    let text = format!("{HEADER}{VERTICES}3 0 1 2\n3 0 2 4\n");
    assert_eq!(message(&text), format!("a.ply:17: {beyond}"));
    let text = format!("{HEADER}{VERTICES}3 0 -1 2\n3 0 2 3\n");
    assert_eq!(message(&text), format!("a.ply:16: {beyond}"));
    let text = format!("{HEADER}{VERTICES}2 0 1\n3 0 2 3\n");
    assert!(message(&text).starts_with("a.ply:16: a face needs"));
    let text = format!("{HEADER}{}{faces}", VERTICES.replace("0.5", "2e9"));
    assert!(message(&text).starts_with("a.ply:13: a vertex needs x, y and z"));
    let text = format!("{}{VERTICES}{faces}", HEADER.replace("float x", "float u"));
    assert!(message(&text).starts_with("a.ply:12: a vertex needs x, y and z"));
    let text = format!("{HEADER}{}{faces}", VERTICES.replace("0.5", "half"));
    assert!(message(&text).starts_with("a.ply:13: PLY syntax"), "{}", message(&text));
    let text = format!("{}{VERTICES}{faces}", HEADER.replace("vertex 4", "vertex four"));
    assert!(message(&text).starts_with("a.ply:4: PLY syntax"), "{}", message(&text));
    let cut = format!("{HEADER}{VERTICES}3 0 1 2    \n");
    assert_eq!(message(&cut), "a.ply:face: the file ends before the last of 2 rows");
    assert!(message("solid cube\n").starts_with("a.ply:1: PLY syntax"));
    assert!(message("").starts_with("a.ply"));
}

#[test]
fn headers_alone_allocate_nothing() {
    for (format, properties, count) in [
        ("binary_little_endian", "", 1_000_000_000_000u64),
        ("binary_big_endian", "", 1),
        ("binary_big_endian", "property uchar x\nelement face 2\nproperty uchar y\n", 0),
        ("binary_little_endian", "property uchar x\n", 1_000_000_000_000),
        ("ascii", "", 1_000_000_000_000),
    ] {
        let text =
            format!("ply\nformat {format} 1.0\nelement vertex {count}\n{properties}end_header\n");
        let error = message(&text);
        let element = if count == 0 { "face" } else { "vertex" };
        assert!(error.starts_with(&format!("a.ply:{element}: the header says")), "{error}");
    }
}

/// The limit is checked before memory is allocated. Typical meshes need little memory, but
/// polygons with many corners need much.
#[test]
fn memory_is_limited() {
    let text = format!("{HEADER}{VERTICES}3 0 1 2\n4 0 1 2 3\n");
    let least = (0..).find(|&bytes| {
        let budget = Budget::new(&Limits::default().with(Limit::Memory, bytes), 0);
        parse("a.ply", text.as_bytes(), &budget).is_ok()
    });
    // Four vertices, at most five triangles, and lines of at most 9 bytes.
    assert!((84..2000).contains(&least.unwrap()), "{least:?}");
    let budget = Budget::new(&Limits::default().with(Limit::Memory, 10), 0);
    let error = parse("a.ply", text.as_bytes(), &budget).unwrap_err().to_string();
    assert!(error.starts_with("a.ply: the limit of memory is 10 bytes, this needs"), "{error}");
}

#[test]
fn damaged_files_are_errors_not_panics() {
    let text = format!("{HEADER}{VERTICES}3 0 1 2\n4 0 1 2 3\n").into_bytes();
    let mut random = crate::math::random::Stream::new(5);
    for _ in 0..20_000 {
        let mut bytes = text.clone();
        bytes.truncate(bytes.len() - (random.bits() % 40) as usize);
        for _ in 0..random.bits() % 4 {
            let place = (random.bits() % bytes.len() as u64) as usize;
            bytes[place] = random.bits() as u8;
        }
        if let Ok(mesh) = parse("a.ply", &bytes, &budget()) {
            let count = mesh.vertices.positions.len() as u32;
            assert!(mesh.triangles.iter().flatten().all(|i| *i < count));
        }
    }
}

fn read(text: &str) -> IndexedMesh {
    parse("a.ply", text.as_bytes(), &budget()).unwrap()
}

/// Blender writes attributes by their own names, and reads them again; MeshLab and three.js do, too.
#[test]
fn names_may_have_blanks_and_other_letters() {
    let header = HEADER
        .replace(
            "property uchar red",
            "property float temp erature\nproperty float 2nd\nproperty uchar \u{e4}",
        )
        .replace("property list", "property list uchar int list of parts\nproperty list");
    let vertices = VERTICES.replace(" 255", " 7 8 255");
    let mesh = read(&format!("\u{feff}{header}{vertices}2 7 7 3 0 1 2\n0 4 0 1 2 3\n"));
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 1, 2], [0, 2, 3]]);
    let text = format!("{header}{vertices}2 7 7 3 0 1 2\n0 4 0 1 2 4\n");
    assert!(message(&text).starts_with("a.ply:20: the face refers"), "{}", message(&text));
}

const FACES: &str = "element face 2\nproperty list uchar int vertex_indices\n";
const SQUARE: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

fn square(properties: &str, faces: &str) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
         property float z\n{FACES}{properties}end_header\n{SQUARE}{faces}"
    )
}

/// pymeshlab writes `texcoord` by default, and three.js reads it (pull request 14923).
#[test]
fn faces_have_texture_coordinates_for_each_corner() {
    let list = "property list uchar float texcoord\n";
    let faces = "3 0 1 2 6 0 0 1 0 1 1\n4 0 1 2 3 8 0 0 1 0 0.5 1 0 1\n";
    let mesh = read(&square(list, faces));
    // The corners at vertex 2 differ.
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 1, 3], [0, 3, 4]]);
    let uvs = mesh.vertices.uvs.iter().map(|uv| uv.to_array()).collect::<Vec<_>>();
    assert_eq!(uvs, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.5, 1.0], [0.0, 1.0]]);
    assert_eq!(mesh.vertices.positions[3], Vec3::new(1.0, 1.0, 0.0));
    let double = square(&list.replace("float", "double"), faces);
    assert_eq!(read(&double).vertices.uvs, mesh.vertices.uvs);
    let none = read(&square(list, "3 0 1 2 0\n3 0 2 3 6 0 0 1 1 0 1\n"));
    assert_eq!(none.vertices.uvs.len(), 5);
    let few = message(&square(list, "3 0 1 2 4 0 0 1 0\n3 0 2 3 6 0 0 1 1 0 1\n"));
    assert!(few.starts_with("a.ply:15: `texcoord` must have two finite numbers"), "{few}");
}

/// trimesh writes colours of faces by default, and pymeshlab reads them; MeshLab also writes those of corners.
#[test]
fn faces_and_their_corners_have_colors() {
    let channels = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    let mesh = read(&square(channels, "3 0 1 2 255 0 0\n3 0 2 3 0 0 255\n"));
    let (red, blue) = (Vec3::X, Vec3::Z);
    assert_eq!(mesh.vertices.colors, [red, red, red, blue, blue, blue]);
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
    let list = "property list uchar float color\n";
    let mesh = read(&square(list, "3 0 1 2 9 1 0 0 0 0 1 1 0 0\n3 0 2 3 0\n"));
    assert_eq!(mesh.vertices.colors, [red, blue, red, Vec3::ONE, Vec3::ONE, Vec3::ONE]);
}

/// The Stanford repository's strips begin anew after -1, and alternate their sides.
#[test]
fn strips_become_triangles() {
    let head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
                property float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n";
    let mesh = read(&format!("{head}{SQUARE}9 0 1 3 2 2 -1 1 2 3\n"));
    assert_eq!(mesh.triangles, [[0, 1, 3], [3, 1, 2], [1, 2, 3]]);
    let wrong = message(&format!("{head}{SQUARE}3 0 1 4\n"));
    assert_eq!(wrong, "a.ply:14: the strip refers to a missing vertex, the file has 4 vertices");
}

/// Blender gives the L an area of 3.
#[test]
fn concave_faces_are_clipped() {
    let head = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\n\
                property float z\nelement face 1\nproperty list uchar int vertex_indices\n";
    let vertices = "1 0 0\n0 0 0\n0 1 0\n-1 1 0\n-1 -1 0\n1 -1 0\n";
    let area = |list: &str, face: &str| {
        let mesh = read(&format!("{head}{list}end_header\n{vertices}{face}"));
        let at = |i: u32| mesh.vertices.positions[i as usize];
        let twice = |t: &[u32; 3]| length(cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0])));
        mesh.triangles.iter().map(twice).sum::<f32>() / 2.0
    };
    assert_eq!(area("", "6 0 1 2 3 4 5\n"), 3.0);
    let corners = "property list uchar float texcoord\n";
    assert_eq!(area(corners, "6 0 1 2 3 4 5 12 0 0 0 1 0 2 0 3 0 4 0 5\n"), 3.0);
}

#[test]
fn messages_have_no_names_of_types() {
    let text = format!("{HEADER}{VERTICES}3 0 1 2\n4 0 1 2 3\n");
    let changed = |from: &str, to: &str| message(&text.replacen(from, to, 1));
    assert_eq!(changed("ply\n", "plx\n"), "a.ply:1: PLY syntax: the first line must be `ply`");
    assert_eq!(
        changed("element face", "elements\u{1b} face"),
        "a.ply:9: PLY syntax: `elements\\u{1b} face 2` is not a line of a header"
    );
    let row = "PLY syntax: the row must have a number for each property in the header";
    for (from, to, line) in
        [("0.5", "half", 13), (" 255", "", 12), ("3 0 1 2", "3 0 1", 16), ("255", "300", 12)]
    {
        assert_eq!(changed(from, to), format!("a.ply:{line}: {row}"));
    }
    assert!(
        changed("format ascii 1.0\n", "").contains("the header needs a line `format ascii 1.0`")
    );
    assert_eq!(message(&text[..48]), "a.ply:4: PLY syntax: `elemen` is not a line of a header");
    assert_eq!(message(&text[..59]), "a.ply:5: PLY syntax: the header must end with `end_header`");
}
