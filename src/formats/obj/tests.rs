//! Tests of the reader.

use super::lines::{FACE, LONG, NORMAL, RANGE, UV, VERTEX};
use crate::formats::obj::*;
use crate::limits::{Limit, Limits};
use crate::math::cross;

fn read(text: &[u8]) -> Result<IndexedMesh> {
    parse("a.obj", text, DVec3::ZERO, &Budget::new(&Limits::default(), 0))
}

fn message(text: &str) -> String {
    read(text.as_bytes()).unwrap_err().to_string()
}

#[test]
fn groups_polygons_and_relative_indices() {
    let text = "\u{feff}v 0 0 0 # first\n# caf\u{e9}\nmtllib none.mtl\no one\r\nv 1 0 0 1\nv 1 1 0 0.1 0.2 0.3\n\
                usemtl red\nf 1 2 3 # top\ng two\nv 0 2 0 2\n\
                f -4 -3 -2 -1\nl 1 2\np 1\n";
    let mesh = read(text.as_bytes()).unwrap();
    let at = |t: [u32; 3]| t.map(|i| mesh.vertices.positions[i as usize].to_array());
    let (a, b, c, d) = ([0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]);
    let triangles: Vec<_> = mesh.triangles.iter().map(|t| at(*t)).collect();
    assert_eq!(triangles, [[a, b, c], [a, b, c], [a, c, d]]);
    assert!(mesh.vertices.normals.is_empty() && mesh.vertices.uvs.is_empty());
    let [groups, objects] = &mesh.groups;
    assert_eq!((&groups.names[..], &objects.names[..]), (&["two".into()][..], &["one".into()][..]));
    assert_eq!((&groups.ranges[1], &objects.ranges[..]), (&(3, 0), &[(3, 0)][..]));
    assert_eq!(mesh.materials, Labels { names: vec!["red".into()], ranges: vec![(3, 0)] });
    assert_eq!(mesh.group("one").unwrap().triangles.len(), 3);
    assert_eq!(mesh.group("two").unwrap().triangles.len(), 2);
    // The other vertices are white.
    assert_eq!(mesh.vertices.colors[2].to_array(), [0.1, 0.2, 0.3]);
    assert_eq!(mesh.vertices.colors[0], Vec3::ONE);
}

#[test]
fn a_group_keeps_its_vertices_and_materials() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red\ng a\nf 1 2 3\n\
                g b\nf 2 3 4\nusemtl blue\nf 1 3 4\nf 1 2 4\ng a\nf 2 3 4\n";
    let mesh = read(text.as_bytes()).unwrap();
    let a = mesh.group("a").unwrap();
    assert_eq!(a.vertices.positions, [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y]);
    assert_eq!(
        (a.triangles, a.materials.ranges),
        (vec![[0, 1, 2], [1, 2, 3]], vec![(1, 0), (2, 1)])
    );
    let b = mesh.group("b").unwrap();
    assert_eq!((b.triangles.len(), b.materials.ranges), (3, vec![(1, 0), (3, 1)]));
    assert_eq!(b.materials.names, ["red", "blue"]);
    let error = mesh.group("c").unwrap_err();
    assert!(error.starts_with("no triangle belongs to a group `c`"), "{error}");
}

#[test]
fn corners_with_equal_data_share_a_vertex() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nvt 0.5\nvt 0 1 0\nvn 0 0 2\nvn 1 0 0\n\
                f 1/1/1 2/2/1 3//2\nf 1/1/-2 3//2 2/1/1\n";
    let IndexedMesh { vertices, triangles, .. } = read(text.as_bytes()).unwrap();
    assert_eq!(triangles, [[0, 1, 2], [0, 2, 3]]);
    let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
    assert_eq!(vertices.positions, [Vec3::ZERO, x, y, x]);
    assert_eq!(vertices.normals, [z * 2.0, z * 2.0, x, z * 2.0]);
    assert_eq!(vertices.uvs, [Vec2::X * 0.5, Vec2::Y, Vec2::ZERO, Vec2::X * 0.5]);
}

#[test]
fn errors_name_the_line() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let wrong = format!("a.obj:3: {VERTEX}");
    assert_eq!(message("v 0 0 0\nv 1 0 0\nv 0 x 0\nf 1 2 3"), wrong);
    assert_eq!(message("v 0 0 0\nv 1 0 0\nv 0 1\nf 1 2 3\n"), wrong);
    for bad in ["1 2 x", "", "1 2", "1 2 3 /4", "1 2 /3", "1 2 3/1/1/1"] {
        let text = format!("{vertices}vt 0 0\nvn 1 0 0\nf {bad}\nf 1 2 3");
        assert_eq!(message(&text), format!("a.obj:6: {FACE}"));
    }
    for (line, says) in [("vn 1 0", NORMAL), ("vn 1 0 inf", NORMAL), ("vt", UV), ("vt x", UV)] {
        assert_eq!(message(&format!("{vertices}{line}\n")), format!("a.obj:4: {says}"));
    }
    // An error of a continued line names its first line, and later lines keep their numbers.
    assert_eq!(message(&format!("{vertices}f 1 2 \\\n\\\n x\n")), format!("a.obj:4: {FACE}"));
    let later = format!("{vertices}f 1 \\\n2 \\\r\n3 # all\nvn 1\n");
    assert_eq!(message(&later), format!("a.obj:7: {NORMAL}"));
    let beyond = "the face refers to a missing vertex, the file has 3 before this line";
    for face in ["1 2 4", "0 1 2", "1 2 -4", "1 2 99999999999"] {
        let text = format!("{vertices}\no a\nf 1 2 3\nf {face}\no b\nf 1 2 3\n");
        assert_eq!(message(&text), format!("a.obj:7: {beyond}"));
    }
    for (face, what) in [("1/1 2 3", "texture coordinate"), ("1//2 2 3", "normal")] {
        let message = message(&format!("{vertices}f {face}\n"));
        assert!(message.contains(&format!("a missing {what}, the file has 0")), "{message}");
    }
    for bad in ["nan 0", "inf 0", "1e39 0", "2e9 0", "5e8 0 0.25", "0 0 nan", "0 1 1e-45"] {
        let text = format!("{vertices}v 0 {bad}\nf 1 2 4\n");
        assert_eq!(message(&text), format!("a.obj:4: {RANGE}"));
    }
}

/// Wavefront's *Advanced Visualizer Manual*, appendix B: a backslash before the line break continues a line.
#[test]
fn continued_lines_are_joined() {
    let text =
        "\u{feff}v 0 0 \\\n0\nv 1 0 0\nv 0 1 0 # C:\\\ng a\\\nf 1 2 \\\r\n \\  \n3\nf 1 \\\n2 3\\";
    let mesh = read(text.as_bytes()).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2]; 2]);
    assert_eq!(mesh.groups[0].names, ["a\\"]);
    let long = format!("v 0 0 0\nf{}\n", " 1 \\\n".repeat(20_000));
    assert_eq!(message(&long), format!("a.obj:2: {LONG}"));
    // Parts of a file do not end within a line.
    let many = "v 0 0 \\\n0\n".repeat(20_000);
    assert_eq!(read(format!("{many}f 1 2 \\\n20000").as_bytes()).unwrap().triangles.len(), 1);
}

/// Blender 5.2 gives this L, and three.js with earcut, an area of 3; a fan about the first corner 3.5.
#[test]
fn concave_faces_are_clipped_and_others_keep_their_fan() {
    let corners = "v 1 0 0\nv 0 0 0\nv 0 1 0\nv -1 1 0\nv -1 -1 0\nv 1 -1 0\nv 1 0.5 0\n";
    let area = |faces: &str| {
        let mesh = read(format!("{corners}{faces}").as_bytes()).unwrap();
        let at = |i: u32| mesh.vertices.positions[i as usize];
        let twice = |t: &[u32; 3]| cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0]));
        let all = mesh.triangles.iter().map(twice);
        (all.clone().sum::<Vec3>().z / 2.0, all.map(|cross| cross.z.abs()).sum::<f32>() / 2.0)
    };
    assert_eq!(area("f 1 2 3 4 5 6\n"), (3.0, 3.0));
    assert_eq!(area("f 6 5 4 3 2 1\n"), (-3.0, 3.0));
    let fan =
        |face: &str| read(format!("{corners}f 1 2 3\nf {face}\n").as_bytes()).unwrap().triangles;
    // A convex face, one with a corner on an edge, and a concave one whose first corner sees all others.
    assert_eq!(fan("5 6 7 4")[1..], [[3, 4, 5], [3, 5, 6]]);
    assert_eq!(fan("4 5 6 1 7")[1..], [[3, 4, 5], [3, 5, 0], [3, 0, 6]]);
    assert_eq!(fan("2 3 4 5 6 1")[1..], [[1, 2, 3], [1, 3, 4], [1, 4, 5], [1, 5, 0]]);
}

/// Many vertices at one position must not take quadratic time.
#[test]
fn many_vertices_at_one_position_are_read() {
    let count = 200_000;
    let faces: String = (0..count / 3)
        .map(|i| format!("f 1/{} 1/{} 1/{}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3))
        .collect();
    let text = format!("v 0 0 0\n{}{faces}", "vt 0\n".repeat(count));
    assert_eq!(read(text.as_bytes()).unwrap().triangles.len(), count / 3);
}

#[test]
fn memory_is_limited() {
    let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{}", "f 1 2 3\n".repeat(100_000));
    let within = |bytes| {
        let budget = Budget::new(&Limits::default().with(Limit::Memory, bytes), 0);
        parse("a.obj", text.as_bytes(), DVec3::ZERO, &budget)
    };
    assert!(within(8 << 20).is_ok());
    let error = within(1 << 20).unwrap_err().to_string();
    assert!(error.contains("the limit of memory is"), "{error}");
    let polygon = format!("v 0 0 0\nf{}\nf 1 2 3", " 1".repeat(600_000));
    assert_eq!(message(&polygon), format!("a.obj:2: {LONG}"));
}

#[test]
fn damaged_files_are_errors_not_panics() {
    let text =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 1\nvn 0 0 1\nf 1/1/1 2//1 3/1\nf -4 -3 -2 -1\n";
    let mut random = crate::math::random::Stream::new(6);
    let mut read_well = 0;
    for _ in 0..20_000 {
        let mut bytes = text.as_bytes().to_vec();
        for _ in 0..1 + random.bits() % 4 {
            let place = (random.bits() % bytes.len() as u64) as usize;
            bytes[place] = b"0123456789 -/.\nvfe\xff"[(random.bits() % 19) as usize];
        }
        if let Ok(IndexedMesh { vertices, triangles, .. }) = read(&bytes) {
            let count = vertices.positions.len();
            assert!(triangles.iter().flatten().all(|i| (*i as usize) < count));
            assert!([0, count].contains(&vertices.normals.len()));
            assert!([0, count].contains(&vertices.uvs.len()));
            read_well += 1;
        }
    }
    assert!(read_well > 1000);
}

/// Parts of a file end anywhere between lines, and each begins where the one before it ended.
#[test]
fn parts_join_to_the_whole_file() {
    let strip = |i: usize| {
        let name = ["g left", "g right", "usemtl red", "# between"][i % 4];
        let color = if i % 1000 == 777 { " 0.5 0 1" } else { "" };
        format!("v {i} 0 1{color}\nvn 0 0 {i}\n{name}\nf -1//-1 {}//1 1//{}\n", i / 2 + 1, i + 1)
    };
    let count = 4 * PARTS * PART / strip(10_000).len();
    let text: String = (0..count).map(strip).collect();
    let IndexedMesh { vertices, triangles, materials, groups, .. } = read(text.as_bytes()).unwrap();
    assert_eq!(triangles.len(), count);
    for (i, corners) in triangles.iter().enumerate() {
        let x = |corner: usize| vertices.positions[corners[corner] as usize].x as usize;
        let z = |corner: usize| vertices.normals[corners[corner] as usize].z as usize;
        assert_eq!([x(0), x(1), x(2)], [i, i / 2, 0]);
        assert_eq!([z(0), z(1), z(2)], [i, 0, i]);
        let color = if i % 1000 == 777 { Vec3::new(0.5, 0.0, 1.0) } else { Vec3::ONE };
        assert_eq!(vertices.colors[corners[0] as usize], color);
    }
    assert_eq!(materials.ranges, [(2, NONE), (count as u32, 0)]);
    // Lines 1 to 3 of every four belong to the group on the right.
    let ends = (1..).map(|i| if i % 2 == 0 { 2 * i } else { 2 * i - 1 });
    let names = (0..).map(|i| i % 2);
    let expected: Vec<_> = ends.take_while(|end| *end < count as u32).zip(names).collect();
    assert_eq!(groups[0].ranges[..expected.len()], expected);
    let wrong = format!("{text}f 1//1 2//2 3//{}\n", count + 1);
    assert!(message(&wrong).starts_with(&format!("a.obj:{}: the face refers", 4 * count + 1)));
}
