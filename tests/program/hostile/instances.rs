//! Faulty instances, and faulty attributes of vertices.

use super::{Case, Content};

const TRIANGLE: &str = r#"triangles(vertices: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], indices: [(0, 1, 2)], material: "grey")"#;
const ONE: &str = "((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0))";

fn scene(meshes: &str, primitives: &str) -> String {
    format!(
        r#"(
    camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 40),
    materials: {{"grey": lambertian(albedo: (0.5, 0.5, 0.5))}},
    meshes: {{{meshes}}},
    primitives: [{primitives}],
)"#
    )
}

fn instance(mesh: &str, matrix: &str) -> String {
    format!(r#"instance(mesh: "{mesh}", matrix: {matrix})"#)
}

/// Meshes m0 to m`last`, of which each has `times` instances of the one before.
fn nested(last: usize, times: usize) -> String {
    let inner = |i: usize| vec![instance(&format!("m{i}"), ONE); times].join(", ");
    let groups = (1..=last).map(|i| format!(r#", "m{i}": [{}]"#, inner(i - 1)));
    format!(r#""m0": [{TRIANGLE}]{}"#, groups.collect::<String>())
}

pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let mut case = |meshes: &str, primitives: &str, says: &str| {
        cases.push(Case::scene("a.ron", scene(meshes, primitives), says));
    };
    let mesh = format!(r#""a": [{TRIANGLE}]"#);
    let a = instance("a", ONE);
    for (number, says) in [
        ("NaN", "must be finite"),
        ("-inf", "must be finite"),
        ("1e39", "must be finite"),
        ("0", "must not be singular"),
        ("1e-44", "must"),
        ("1e30", "must"),
    ] {
        case(&mesh, &instance("a", &ONE.replacen('1', number, 1)), &format!("matrix {says}"));
    }
    let nowhere = ONE.replacen("0)", "NaN)", 1);
    case(&mesh, &instance("a", &nowhere), "matrix must be finite");
    case(&mesh, &instance("b", ONE), "unknown mesh `b`");
    case(&format!(r#""a": [{a}]"#), &a, "contains itself");
    case(&nested(9, 10), &instance("m9", ONE), "the limit of primitives");
    case(&nested(63, 200), &instance("m63", ONE), "the limit of");
    case(&nested(70, 1), &instance("m70", ONE), "nested at most 64 times");
    // Each of a million instances takes memory.
    case(&nested(6, 10), &instance("m6", ONE), "the limit of memory");
    case(r#""a": "/dev/zero""#, &a, "is outside the folder of the scene");
    case(r#""a": "../a.obj""#, &a, "a.ron");
    case(&"\"a\": [".repeat(2000), &a, "a.ron");
    for (field, says) in [
        ("normals: [(0, 0, 1)]", "normals must be as many as vertices, which are 3"),
        ("uvs: [(0, 0), (0, NaN), (0, 0)]", "uvs[1] must be finite"),
        ("second_uvs: [(0, 0), (0, 0)]", "second_uvs must be as many as vertices"),
        ("tangents: [(0, 0, 1), (inf, 0, 0), (0, 0, 1)]", "tangents[1] must be finite"),
        ("colors: [(0, 0, 1), (0, 0, 1), (0, 2, 1)]", "colors[2] must be in [0, 1]"),
        ("colors: [(0, 0, 1), (0, 0, -1), (0, 0, 1)]", "colors[1] must be in [0, 1]"),
        ("colours: []", "unknown field `colours`"),
    ] {
        let triangle = TRIANGLE.replace("material", &format!("{field}, material"));
        case("", &triangle, says);
        case(&format!(r#""a": [{triangle}]"#), &a, says);
    }
    let must = "normal must be the name of an `image` texture with `encoding: linear` and `uv: 0`";
    for (normal, says) in [
        ("\"n\"", "unknown texture `n`"),
        ("\"plain\"", must),
        ("\"second\"", must),
        ("\"colors\"", must),
        ("(0, 0, 1)", "expected the name of a texture in quotes"),
    ] {
        let textures = r#"textures: {"plain": image(file: "n.ppm"), "colors": vertex_color(),
            "second": image(file: "n.ppm", encoding: linear, uv: 1)}, materials"#;
        let text = scene("", TRIANGLE)
            .replace("materials", textures)
            .replace("0.5)", &format!("0.5), normal: {normal}"));
        let image = Content::Bytes(b"P6 1 1 255\n\x80\x80\xff".to_vec());
        cases.push(Case::scene("a.ron", text, says).with("n.ppm", image));
    }
    let text = scene("", r#"mesh(file: "a.obj", group: "b", material: "grey")"#);
    let obj = Content::Bytes(b"v 0 0 0\nv 1 0 0\nv 0 1 0\ng a\nf 1 2 3\n".to_vec());
    let says = "no triangle belongs to a group `b`";
    cases.push(Case::scene("a.ron", text, says).with("a.obj", obj));
    cases
}
