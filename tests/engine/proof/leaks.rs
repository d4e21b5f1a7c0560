//! Closed meshes never leak: inside them, no bounced path finds the sky.
//!
//! Closed boxes 1000 of their sizes away from the origin let Cycles 5.2.3 and Mitsuba 3.9.1 see the sky in 42 of
//! 10⁶ units of its light, and ptfast in 30 until spawn points kept away from edges.

use ptfast::glam::{DMat3, DVec3};
use ptfast::{ImageSettings, Roulette, Scene};

use super::smooth::sphere;
use crate::common;

type Solid = (Vec<DVec3>, Vec<[u32; 3]>);

/// Two copies of a convex polygon, and the walls between them.
fn prism(polygon: &[DVec3], up: DVec3) -> Solid {
    let n = polygon.len() as u32;
    let vertices = polygon.iter().map(|&v| v - up).chain(polygon.iter().map(|&v| v + up));
    let ends = (1..n - 1).flat_map(|i| [[0, i, i + 1], [n, n + i, n + i + 1]]);
    let walls = (0..n).flat_map(|i| {
        let next = (i + 1) % n;
        [[i, next, n + next], [i, n + next, n + i]]
    });
    (vertices.collect(), ends.chain(walls).collect())
}

/// A regular polygon with `n` corners in the plane z = 0.
fn polygon(n: u32) -> Vec<DVec3> {
    let at = |i: u32| DMat3::from_rotation_z(f64::from(i) / f64::from(n) * std::f64::consts::TAU);
    (0..n).map(|i| at(i) * DVec3::X).collect()
}

/// Solids around the origin whose faces meet at angles of at least 60°.
fn solids() -> Vec<(&'static str, Solid)> {
    let corners = [DVec3::ONE, DVec3::new(1.0, -1.0, -1.0)];
    let mut tetrahedron = corners.to_vec();
    tetrahedron.extend(corners.map(|v| DVec3::new(-v.x, v.y, -v.z)));
    let (vertices, faces) = sphere(3);
    let ball = vertices.iter().map(|v| DVec3::from_array(v.map(f64::from))).collect();
    vec![
        ("box", prism(&polygon(4), DVec3::Z)),
        ("hall", prism(&polygon(4), DVec3::Z * 20.0)),
        ("three walls", prism(&polygon(3), DVec3::Z)),
        ("eight walls", prism(&polygon(8), DVec3::Z * 0.5)),
        ("tetrahedron", (tetrahedron, vec![[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]])),
        ("ball", (ball, faces)),
    ]
}

/// The inside of a solid, turned and moved, under a sky of radiance 10⁶.
fn scene((vertices, faces): &Solid, turn: DMat3, offset: DVec3, instanced: bool) -> Scene {
    let list = |vertices: &[DVec3], place: &dyn Fn(DVec3) -> DVec3| {
        let vertex = |&v: &DVec3| format!("{:?}", place(v).as_vec3().to_array());
        vertices
            .iter()
            .map(vertex)
            .collect::<Vec<_>>()
            .join(",")
            .replace('[', "(")
            .replace(']', ")")
    };
    let indices = faces.iter().map(|face| format!("{face:?}")).collect::<Vec<_>>().join(",");
    let indices = indices.replace('[', "(").replace(']', ")");
    let place = |v: DVec3| turn * v + offset;
    let mesh = |vertices: String| {
        format!(r#"triangles(vertices: [{vertices}], indices: [{indices}], material: "m")"#)
    };
    let (meshes, primitive) = if instanced {
        let row = |i: usize| {
            let [x, y, z] = turn.row(i).as_vec3().to_array();
            format!("({x}, {y}, {z}, {})", offset[i] as f32)
        };
        let instance =
            format!(r#"instance(mesh: "s", matrix: ({}, {}, {}))"#, row(0), row(1), row(2));
        (format!(r#"meshes: {{"s": [{}]}},"#, mesh(list(vertices, &|v| v))), instance)
    } else {
        (String::new(), mesh(list(vertices, &place)))
    };
    let at = |v: DVec3| format!("({}, {}, {})", v.x as f32, v.y as f32, v.z as f32);
    let (from, to) = (at(place(DVec3::ZERO)), at(place(DVec3::new(1.0, 0.3, 0.2))));
    Scene::from_ron(&format!(
        r#"(camera: (look_from: {from}, look_at: {to}, vfov: 120),
            background: constant(radiance: (1e6, 1e6, 1e6)), render: (depth: 16),
            materials: {{"m": lambertian(albedo: (0.8, 0.8, 0.8))}},
            {meshes} primitives: [{primitive}])"#
    ))
    .unwrap()
}

/// Traces some ten million bounces.
#[test]
fn no_path_leaves_a_closed_mesh() {
    let turns = [
        DMat3::IDENTITY,
        DMat3::from_axis_angle(DVec3::new(0.6, 0.8, 0.0), 1.0),
        DMat3::from_axis_angle(DVec3::new(0.0, 0.28, 0.96), 2.5),
    ];
    let spp = if cfg!(feature = "slow-tests") { 320 } else { 16 };
    let mut leaks = Vec::new();
    for (name, solid) in solids() {
        for (number, turn) in turns.into_iter().enumerate() {
            for (offset, instanced) in [
                (0.0, false),
                (16.0, false),
                (1000.0, false),
                (0.0, true),
                (16.0, true),
                (1000.0, true),
            ] {
                let scene = scene(&solid, turn, DVec3::new(1.0, 0.7, -0.4) * offset, instanced);
                let (width, height, roulette) = (32, 32, Roulette::Off);
                let settings =
                    ImageSettings { width, height, spp, roulette, ..ImageSettings::of(&scene) };
                let mean = common::render(&scene, settings).mean()[0];
                if mean != 0.0 {
                    leaks.push(format!("{name}, turn {number}, {offset} {instanced}: {mean}"));
                }
            }
        }
    }
    assert!(leaks.is_empty(), "{leaks:#?}");
}
