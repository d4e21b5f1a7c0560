//! Tests of scene files with instances.

use std::fs;

use ptfast::Scene;

use crate::common::{ptfast, stderr, stdout};

const IDENTITY: &str = "((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0))";
const TRIANGLE: &str = r#"triangles(vertices: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], indices: [(0, 1, 2)], material: "grey")"#;
const LIGHT: &str = r#"triangles(vertices: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], indices: [(0, 1, 2)], material: "lamp")"#;

fn scene(meshes: &str, primitives: &str) -> String {
    format!(
        r#"(
    camera: (look_from: (3, 2, 4), look_at: (0, 0, 0), vfov: 40),
    background: constant(radiance: (1, 1, 1)),
    render: (width: 40, height: 30, spp: 2),
    materials: {{
        "grey": lambertian(albedo: (0.5, 0.5, 0.5)),
        "lamp": light(radiance: (1, 1, 1)),
    }},
    meshes: {{{meshes}}},
    primitives: [{primitives}],
)"#
    )
}

fn instance(mesh: &str, matrix: &str) -> String {
    format!(r#"instance(mesh: "{mesh}", matrix: {matrix})"#)
}

/// The number of primitives outside instances, of instances, and of triangles of meshes.
fn counts(scene: &Scene) -> [usize; 3] {
    let geometry = scene.geometry();
    let instances = &geometry.instances;
    [geometry.len(), instances.len(), instances.triangle_count()]
}

#[test]
fn groups_are_flattened() {
    let a = instance("a", IDENTITY);
    let meshes = format!(
        r#""a": [{TRIANGLE}, {TRIANGLE}], "b": [{a}, {a}, {LIGHT}], "c": [{TRIANGLE}, {0}, {0}], "unused": "no.obj""#,
        instance("b", IDENTITY)
    );
    let with = |primitives: &str| Scene::from_ron(&scene(&meshes, primitives)).unwrap();
    assert_eq!(counts(&with(&a)), [0, 1, 2]);
    assert_eq!(counts(&with(&instance("b", IDENTITY))), [1, 2, 2]);
    let all = with(&format!("{}, {a}", instance("c", IDENTITY)));
    assert_eq!(counts(&all), [2, 6, 3]);
    assert_eq!(all.lights(), 2);
    // Groups of nothing do not multiply.
    let empty = TRIANGLE.replace("(0, 1, 0)", "(2, 0, 0)");
    let nested = |i: usize| vec![instance(&format!("e{i}"), IDENTITY); 10].join(", ");
    let groups = (1..40).map(|i| format!(r#", "e{i}": [{}]"#, nested(i - 1)));
    let meshes = format!(r#""e0": [{empty}]{}"#, groups.collect::<String>());
    for meshes in [meshes.clone(), meshes.replace("grey", "lamp")] {
        let nothing = Scene::from_ron(&scene(&meshes, &instance("e39", IDENTITY))).unwrap();
        assert_eq!(counts(&nothing), [0, 0, 0]);
    }
    // A material that replaces those of the parts makes another mesh, which here also has no light.
    let grey = format!(r#"instance(mesh: "b", matrix: {IDENTITY}, material: "grey")"#);
    assert_eq!(counts(&with(&grey)), [0, 3, 3]);
    let lamps = format!(r#"instance(mesh: "c", matrix: {IDENTITY}, material: "lamp")"#);
    assert_eq!(counts(&with(&lamps)), [11, 0, 0]);
}

#[test]
fn files_are_shared_and_scenes_are_written_as_read() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    file("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let place = format!(r#"instance(mesh: "a", matrix: {IDENTITY}, material: "grey")"#);
    file("a.ron", &scene(r#""a": "a.obj""#, &format!("{place}, {place}")));
    let part = r#""a": [mesh(file: "a.obj", material: "grey")]"#;
    let own = instance("a", IDENTITY);
    file("b.ron", &scene(part, &format!("{own}, {own}")));
    let path = |name: &str| folder.path().join(name).display().to_string();
    let [a, b] = ["a.ron", "b.ron"].map(|name| Scene::load(&path(name)).unwrap());
    assert_eq!(counts(&a), [0, 2, 1]);
    let line = stdout(&ptfast(folder.path(), &["scenes", "check", "a.ron"]));
    assert!(line.contains("0 triangles, 2 instances of 1 triangles, 2 materials"), "{line}");
    let sample = ["path", "a.ron", "--pixel", "20,15", "--sample", "0"];
    let paths = stdout(&ptfast(folder.path(), &sample));
    assert!(
        paths.contains("a triangle of a mesh of lambertian `grey` in instance 0, at"),
        "{paths}"
    );
    assert_eq!(a.hash(), b.hash());
    for (form, flags) in [("ron", &[][..]), ("json", &["--json"])] {
        let shown = ptfast(folder.path(), &[&["scenes", "show", "a.ron"], flags].concat());
        let again = path(&format!("again.{form}"));
        fs::write(&again, stdout(&shown)).unwrap();
        assert_eq!(Scene::load(&again).unwrap().hash(), a.hash(), "{form}");
    }
}

#[test]
fn obj_files_name_materials() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\n";
    // The second triangle has no area.
    let faces = "usemtl grey\nf 1 2 3\nf 1 1 2\nf 2 4 3\nusemtl lamp \nf 1 3 2\n";
    file("a.obj", &format!("{corners}{faces}"));
    file("nameless.obj", &format!("{corners}f 1 2 3\n{faces}"));
    file("unknown.obj", &format!("{corners}usemtl dark grey\nf 1 2 3\n"));
    // A material is needed only for triangles with an area.
    file("late.obj", &format!("{corners}f 1 1 2\nusemtl none\nf 1 2 2\nusemtl grey\nf 1 2 3\n"));
    let load = |meshes: &str, primitives: &str| {
        file("a.ron", &scene(meshes, primitives));
        Scene::load(folder.path().join("a.ron").to_str().unwrap())
    };
    let own = load("", r#"mesh(file: "a.obj")"#).unwrap();
    assert_eq!((counts(&own), own.lights()), ([3, 0, 0], 1));
    assert_eq!([0, 1, 2].map(|i| own.material(i).name()), ["lambertian", "lambertian", "light"]);
    assert_eq!(counts(&load("", r#"mesh(file: "late.obj")"#).unwrap()), [1, 0, 0]);
    let one = load("", r#"mesh(file: "a.obj", material: "grey")"#).unwrap();
    assert_eq!((counts(&one), one.lights()), ([3, 0, 0], 0));
    let a = instance("a", IDENTITY);
    // Triangles that emit light are placed on their own.
    let instanced = load(r#""a": "a.obj""#, &format!("{a}, {a}")).unwrap();
    assert_eq!((counts(&instanced), instanced.lights()), ([2, 2, 2], 2));
    let parts = load(r#""a": [mesh(file: "a.obj")]"#, &format!("{a}, {a}")).unwrap();
    assert_eq!(parts.hash(), instanced.hash());
    let grey = format!(r#"instance(mesh: "a", matrix: {IDENTITY}, material: "grey")"#);
    for mesh in [r#""a": "unknown.obj""#, r#""a": [mesh(file: "nameless.obj")]"#] {
        assert_eq!(load(mesh, &grey).unwrap().lights(), 0);
    }
    for (meshes, primitives, want) in [
        (
            "",
            r#"mesh(file: "nameless.obj")"#,
            "has triangles without the name of a material, so add",
        ),
        ("", r#"mesh(file: "unknown.obj")"#, "mesh: unknown material `dark grey`"),
        (r#""a": "nameless.obj""#, &a, "has triangles without the name of a material, so add"),
        (r#""a": "unknown.obj""#, &a, "mesh: unknown material `dark grey`"),
    ] {
        let error = load(meshes, primitives).unwrap_err().to_string();
        assert!(error.contains(want), "{error}");
    }
}

/// Triangles that emit light keep all that their material may use.
#[test]
fn placed_lights_are_those_of_the_list() {
    let lists = [("grey", "(0.5, 0.5, 0.5)"), ("warm", "(1, 0.8, 0.6)")].map(|(name, color)| {
        format!(
            r#"triangles(vertices: [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], indices: [(0, 1, 2), (0, 1, 3)],
               normals: [(0, 0, 1), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
               uvs: [(0, 0), (1, 0), (0, 1), (1, 1)], second_uvs: [(0, 0), (1, 0), (0, 1), (1, 1)],
               colors: [(1, 0, 0), (0, 1, 0), {color}, (0, 0, 1)],
               tangents: [(1, 0, 0), (0, 1, 0), (1, 0, 0), (0, 1, 0)], material: "{name}")"#
        )
    });
    let with = |meshes: &str, primitives: &str| {
        let shining = r#""warm": principled(base_color: "c", emission: (1, 1, 1)), "grey""#;
        let text = scene(meshes, primitives).replacen(r#""grey""#, shining, 1);
        let textures = r#"textures: {"c": vertex_color()}, materials:"#;
        Scene::from_ron(&text.replacen("materials:", textures, 1)).unwrap()
    };
    let listed = with("", &lists[1]);
    let placed = with(&format!(r#""a": [{}]"#, lists.join(", ")), &instance("a", IDENTITY));
    assert_eq!((counts(&placed), placed.lights()), ([2, 1, 2], 2));
    assert_eq!(placed.geometry().triangles, listed.geometry().triangles);
}

#[test]
fn equal_content_has_equal_hashes() {
    let hash = |meshes: &str, primitives: &str| {
        Scene::from_ron(&scene(meshes, primitives)).unwrap().hash()
    };
    let mesh = |name: &str| format!(r#""{name}": [{TRIANGLE}]"#);
    let one = hash(&mesh("a"), &instance("a", IDENTITY));
    assert_eq!(one, hash(&format!("{}, {}", mesh("x"), mesh("b")), &instance("b", IDENTITY)));
    let moved = "((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 1))";
    assert_ne!(one, hash(&mesh("a"), &instance("a", moved)));
    assert_ne!(one, hash(&mesh("a"), TRIANGLE));
}

#[test]
fn bad_instances_are_errors() {
    let mesh = format!(r#""a": [{TRIANGLE}]"#);
    let a = instance("a", IDENTITY);
    let with = |row: &str| format!("({row}, (0, 1, 0, 0), (0, 0, 1, 0))");
    let nested = |count: usize, times: usize| {
        let inner = |i: usize| vec![instance(&format!("m{i}"), IDENTITY); times].join(", ");
        let meshes = (1..count).map(|i| format!(r#", "m{i}": [{}]"#, inner(i - 1)));
        format!(r#""m0": [{TRIANGLE}]{}"#, meshes.collect::<String>())
    };
    let shrunk = "((1e-6, 0, 0, 0), (0, 1e-6, 0, 0), (0, 0, 1e-6, 0))";
    let shrink = format!(r#"{mesh}, "b": [{}]"#, instance("a", shrunk));
    for (meshes, primitive, want) in [
        (&*mesh, &*instance("b", IDENTITY), "instance: unknown mesh `b`"),
        (&mesh, &instance("a", &with("(0, 0, 0, 0)")), "matrix must not be singular"),
        (&mesh, &instance("a", &with("(1e-30, 0, 0, 0)")), "matrix must scale lengths by 1e-9"),
        (&mesh, &instance("a", &with("(1, 1e6, 0, 0)")), "matrix must have a condition number of"),
        (&mesh, &instance("a", &with("(inf, 0, 0, 0)")), "matrix must be finite"),
        (&mesh, &instance("a", &with("(NaN, 0, 0, 0)")), "matrix must be finite"),
        (&mesh, &instance("a", &with("(1, 0, 0, NaN)")), "matrix must be finite"),
        (
            &mesh,
            &instance("a", &with("(1, 0, 0, 1e10)")),
            "matrix must be finite, with a translation",
        ),
        (&mesh, &instance("a", "((1, 0, 0, 0), (0, 1, 0, 0))"), "Expected an array of length 3"),
        (&mesh, &instance("a", &with("(1e9, 0, 0, 9e8)")), "coordinates must be within ±1e9"),
        (
            &mesh,
            &format!(r#"instance(mesh: "a", matrix: {IDENTITY}, material: "gray")"#),
            "unknown material `gray`, did you mean `grey`?",
        ),
        (r#""a": [sphere(center: (0, 0, 0), radius: 1, material: "grey")]"#, &a, "consists of"),
        (r#""a": 3"#, &a, "the path of a mesh file, or a list of parts"),
        (&format!(r#""a": [{a}]"#), &a, "the mesh `a` contains itself"),
        (
            &format!(r#""a": [{}], "b": [{a}]"#, instance("b", IDENTITY)),
            &a,
            "the mesh `a` contains itself",
        ),
        (&format!("{mesh}, {mesh}"), &a, "the name `a` is used twice"),
        (&nested(70, 1), &instance("m69", IDENTITY), "nested at most 64 times"),
        (
            &nested(70, 1),
            &format!("{}, {}", instance("m40", IDENTITY), instance("m69", IDENTITY)),
            "nested at most 64 times",
        ),
        (
            &format!(r#""a": [{}]"#, TRIANGLE.replace("grey", "gray")),
            &format!(r#"instance(mesh: "a", matrix: {IDENTITY}, material: "grey")"#),
            "triangles: unknown material `gray`",
        ),
        (
            &format!(r#""a": [{}]"#, LIGHT.replace("(1, 0, 0)", "(1e9, 0, 0)")),
            &instance("a", "((2, 0, 0, 0), (0, 2, 0, 0), (0, 0, 2, 0))"),
            "coordinates must be within ±1e9",
        ),
        // 10^9 instances, and a number beyond 64 bits.
        (&nested(10, 10), &instance("m9", IDENTITY), "limit of primitives"),
        (&nested(50, 10), &instance("m49", IDENTITY), "limit of primitives"),
        (&shrink, &instance("b", shrunk), "the product of nested matrices must scale lengths"),
    ] {
        let error = Scene::from_ron(&scene(meshes, primitive)).unwrap_err().to_string();
        assert!(error.contains(want), "{error}");
        assert!(!error.contains('\n'), "{error}");
    }
}

#[test]
fn errors_in_parts_are_located() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ron");
    let bad = r#"triangles(vertices: [(0, 0, 0)], indices: [(0, 1, 2)], material: "grey")"#;
    let meshes = format!("\n\"a\": [{TRIANGLE},\n{bad}]");
    fs::write(&path, scene(&meshes, &instance("a", IDENTITY))).unwrap();
    let output = ptfast(folder.path(), &["scenes", "check", "a.ron"]);
    let error = stderr(&output);
    assert!(
        !output.status.success() && error.contains("meshes.a[1]: triangles: indices[0]"),
        "{error}"
    );
    assert!(error.contains("a.ron:11:"), "{error}");
}
