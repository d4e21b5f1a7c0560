//! Faulty mesh files.

use super::{Case, Content};

/// The text of a scene that names the mesh `file`.
pub(super) fn scene(file: &str) -> String {
    let file = file.replace('\\', "\\\\");
    format!(
        r#"(
    camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 40),
    materials: {{"grey": lambertian(albedo: (0.5, 0.5, 0.5))}},
    primitives: [mesh(file: "{file}", material: "grey")],
)"#
    )
}

/// A case with a scene that names the mesh `file`.
fn mesh(file: &'static str, content: Content, says: &str) -> Case {
    Case::scene("a.ron", scene(file), says).with(file, content)
}

fn ply(format: &str, elements: &str, rows: &[u8], says: &str) -> Case {
    let mut bytes = format!("ply\nformat {format} 1.0\n{elements}end_header\n").into_bytes();
    bytes.extend(rows);
    let mut case = mesh("m.ply", Content::Bytes(bytes), says);
    case.name = format!("PLY {format}: {elements}");
    case
}

const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";
const FACES: &str = "property list uchar int vertex_indices\n";

pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (text, says) in [
        ("", "the file has no faces"),
        ("f 1 2 3\n", "missing vertex, the file has 0 before"),
        ("v nan 0 0\n", "coordinates must be finite"),
        ("v 1e39 0 0\n", "coordinates must be finite"),
        ("v 0 0 0 0\nf 1 1 2\n", "m.obj"),
        ("v 0 0 0 nan\nf 1 1 2\n", "m.obj"),
        ("v 0 0\n", "a vertex is `v`"),
        ("v a b c\n", "a vertex is `v`"),
        ("\0\0\0", "the file has no faces"),
        ("\u{1b}[31m\nf \u{1b}[31m 1 2\n", "m.obj"),
        ("f 1//\n", "a face is `f`"),
        ("f 1// 1// 1//\n", "a missing vertex"),
        ("mtllib /dev/zero\nusemtl a\n", "the file has no faces"),
    ] {
        cases.push(mesh("m.obj", Content::Bytes(text.into()), says));
    }
    for (face, says) in [
        ("1 2 4", "missing vertex, the file has 3 before"),
        ("0 1 2", "missing vertex, the file has 3 before"),
        ("1 2 -4", "missing vertex, the file has 3 before"),
        ("1 2 4294967297", "missing vertex, the file has 3 before"),
        ("1 2 18446744073709551617", "m.obj"),
        ("1 2 -9223372036854775808", "m.obj"),
        ("1 2 3.5", "a face is `f`"),
        ("1 2", "a face is `f`"),
    ] {
        let text = format!("{vertices}f {face}\n");
        cases.push(mesh("m.obj", Content::Bytes(text.into()), says));
    }
    let much = |part: &str, times: usize| {
        Content::Bytes(format!("{vertices}{}\n", part.repeat(times)).into())
    };
    cases.push(mesh("m.obj", much("f 1 2 3\n", 200_000), "the limit of memory"));
    cases.push(mesh("m.obj", much("v 0 0 0\n", 1_000_000), "the limit of memory"));
    cases.push(mesh("m.obj", much("g\n", 1_000_000), "the file has no faces"));
    let polygon = format!("{vertices}f{}\n", " 1 2 3".repeat(200_000));
    cases.push(mesh("m.obj", Content::Bytes(polygon.into()), "a line may have at most"));
    for (file, length, says) in [
        ("m.obj", (1 << 32) + 1, "the limit of mesh-bytes is 4.0 GiB, this needs 4.1 GiB"),
        ("m.obj", 1 << 26, "the limit of memory"),
        ("m.ply", 1 << 40, "the limit of mesh-bytes"),
        ("m.ply", 1 << 26, "the limit of memory"),
    ] {
        cases.push(mesh(file, Content::Sparse(length), says));
    }

    let (big, little) = ("binary_big_endian", "binary_little_endian");
    let head = |vertices: &str, faces: &str| {
        format!("element vertex {vertices}\n{XYZ}element face {faces}\n{FACES}")
    };
    for format in ["ascii", big, little] {
        for count in
            ["4", "1000000000", "4294967296", "9223372036854775807", "18446744073709551615"]
        {
            let says = "the header says";
            cases.push(ply(format, &head(count, "1"), b"0 0 0\n1 0 0\n", says));
            cases.push(ply(format, &head("0", count), b"", says));
        }
        for (elements, says) in [
            ("", "the file has no faces"),
            ("element vertex 18446744073709551616\n", "PLY syntax"),
            ("element vertex -1\n", "PLY syntax"),
            ("element vertex 1\nproperty list double float x\n", "m.ply"),
            ("element vertex 1\nproperty quad x\n", "PLY syntax"),
            ("property float x\n", "PLY syntax"),
            ("element face 1000000\n", "the header says"),
        ] {
            cases.push(ply(format, elements, b"", says));
        }
    }
    let three = {
        let floats = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        floats.iter().flat_map(|c| c.to_le_bytes()).collect::<Vec<u8>>()
    };
    let face = |count: u8, corners: &[i32]| {
        let corners = corners.iter().flat_map(|c| c.to_le_bytes());
        three.iter().copied().chain([count]).chain(corners).collect::<Vec<u8>>()
    };
    for (rows, says) in [
        (face(3, &[0, 1, 3]), "missing vertex, the file has 3 vertices"),
        (face(3, &[0, 1, -1]), "missing vertex, the file has 3 vertices"),
        (face(3, &[0, 1, i32::MIN]), "missing vertex, the file has 3 vertices"),
        (face(2, &[0, 1]), "needs a list"),
        (face(0, &[0]), "needs a list"),
        (face(255, &[0, 1, 2]), "the file ends before"),
        (face(3, &[0, 1]), "the file ends before"),
    ] {
        cases.push(ply(little, &head("3", "1"), &rows, says));
    }
    let nan: Vec<u8> = [f32::NAN, 0.0, 0.0].iter().flat_map(|c| c.to_le_bytes()).collect();
    cases.push(ply(
        little,
        &format!("element vertex 1\n{XYZ}"),
        &nan,
        "a vertex needs x, y and z, finite",
    ));
    cases.push(ply(
        little,
        "element vertex 1\nproperty float x\n",
        &[0; 4],
        "a vertex needs x, y and z",
    ));
    // A list that claims more than four thousand million corners.
    let lists =
        format!("element vertex 3\n{XYZ}element face 1\nproperty list uint uchar vertex_indices\n");
    let lies = [&three[..], &u32::MAX.to_le_bytes(), &[0; 100]].concat();
    cases.push(ply(little, &lists, &lies, "the file ends before"));
    // A list of two million corners, of one byte each.
    let long = [&three[..], &2_000_000u32.to_le_bytes(), &[0; 2_000_000]].concat();
    cases.push(ply(little, &lists, &long, "the limit of memory"));
    let text = format!("0 0 0\n1 0 0\n0 1 0\n{}{}\n", 600_000, " 1".repeat(600_000));
    cases.push(ply("ascii", &head("3", "1"), text.as_bytes(), "the limit of memory"));
    // A long list in an element that is not a face.
    let other = "element x 1\nproperty list uint uchar vertex_indices\n";
    let long = [&4_000_000u32.to_le_bytes()[..], &[0; 4_000_000]].concat();
    cases.push(ply(little, other, &long, "the limit of memory"));
    // Headers without an end.
    let elements = "element e1 0\n".repeat(100_000);
    cases.push(ply("ascii", &elements, b"", "must end with `end_header` within 65536"));
    let comment = format!("comment end_header\n{elements}");
    cases.push(ply("ascii", &comment, b"", "must end with `end_header` within 65536"));
    let words = [&b"ply\n"[..], &b"a ".repeat(4 << 20)].concat();
    cases.push(mesh("m.ply", Content::Bytes(words), "must end with `end_header` within 65536"));
    cases.push(mesh("m.obj", Content::Bytes(vec![255; 8 << 20]), "a line may have at most"));
    let rows = "0 0 0\n".repeat(1_000_000);
    cases.push(ply(
        "ascii",
        &format!("element vertex 1000000\n{XYZ}"),
        rows.as_bytes(),
        "the file has no faces",
    ));
    cases.push(ply(
        "ascii",
        "element face 1000000\nproperty list uchar int vertex_indices\n",
        "3 0 0 0\n".repeat(1_000_000).as_bytes(),
        "limit of memory",
    ));
    // One mesh named twenty thousand times: reading it each time would mean twenty gigabytes.
    let comments = format!("{vertices}f 1 2 3\n{}", "# a comment\n".repeat(90_000));
    let named = r#"mesh(file: "m.obj", material: "grey")"#;
    let scene = scene("m.obj").replace(named, &[named; 20_000].join(", "));
    let mut many = Case::scene("a.ron", scene, "the limit of primitives is 19999");
    many.name = "one mesh many times".to_owned();
    many.arguments.extend(["--limit", "primitives=19999"]);
    cases.push(many.with("m.obj", Content::Bytes(comments.into())));
    cases
}
