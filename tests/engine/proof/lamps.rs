//! Compares floors lit by lamps with form factors and solid angles in closed form.

use std::f64::consts::PI;

use super::{Known, compare};

/// A floor at height −1 and lamps. The camera at the origin looks at the middle of the floor.
fn floor(material: &str, lamps: &str) -> String {
    format!(
        r#"(camera: (look_from: (0, 0, 0), look_at: (0, -1, 0), up: (0.1, 1, 0.2), vfov: 0.02),
            materials: {{"floor": {material}(albedo: (0.6, 0.6, 0.6)), "lamp": light(radiance: (8, 8, 8)),
                         "front": light(radiance: (8, 8, 8), sides: front)}},
            primitives: [quad(q: (-9, -1, -9), u: (0, 0, 18), v: (18, 0, 0), material: "floor"), {lamps}])"#
    )
}

#[test]
fn floors_are_lit_as_they_should() {
    // A sphere of radius r = 1, whose centre is at a distance of d = 5 and 3 to the side. It gives
    // the irradiance πL (r/d)² cos θ.
    let sphere = r#"sphere(center: (3, 3, 0), radius: 1, material: "lamp")"#;
    let (lambert_sphere, solid_sphere) =
        (0.6 * 8.0 / 25.0 * 0.8, 0.6 * 8.0 * (1.0 - (1.0f64 - 1.0 / 25.0).sqrt()));
    // A rectangle parallel to the floor, with one corner above the middle of the floor (Howell, *A
    // Catalog of Radiation Heat Transfer Configuration Factors*, B-3), and its solid angle.
    let (a, b, height) = (3.0f64, 2.0, 1.5);
    let (x, y) = (a / height, b / height);
    let (rx, ry) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    let factor = (x / rx * (y / rx).atan() + y / ry * (x / ry).atan()) / (2.0 * PI);
    let solid_angle = (x * y / (1.0 + x * x + y * y).sqrt()).atan();
    let (lambert_quad, diffuse_quad) = (0.6 * 8.0 * factor, 0.6 * 8.0 * solid_angle / (2.0 * PI));
    let quad = r#"quad(q: (0, 0.5, 0), u: (3, 0, 0), v: (0, 0, 2), material: "front")"#;
    // The same rectangle as two triangles.
    let triangles = r#"triangles(vertices: [(0, 0.5, 0), (3, 0.5, 0), (0, 0.5, 2), (3, 0.5, 2)],
                                 indices: [(0, 1, 2), (1, 3, 2)], material: "front")"#;
    // Many triangles are chosen by a light tree.
    let (columns, rows) = (12, 8);
    let place = |i: u32, n: u32, size: f32| i as f32 * size / n as f32;
    let vertices: String = (0..(columns + 1) * (rows + 1))
        .map(|i| {
            let (x, z) =
                (place(i % (columns + 1), columns, 3.0), place(i / (columns + 1), rows, 2.0));
            format!("({x}, 0.5, {z}),")
        })
        .collect();
    let indices: String = (0..columns * rows)
        .map(|i| {
            let a = i / columns * (columns + 1) + i % columns;
            let [b, c, d] = [a + 1, a + columns + 1, a + columns + 2];
            format!("({a}, {b}, {c}), ({b}, {d}, {c}),")
        })
        .collect();
    let many =
        format!(r#"triangles(vertices: [{vertices}], indices: [{indices}], material: "front")"#);
    let many_and_sphere =
        format!("{many}, {}", r#"sphere(center: (-3, 3, 0), radius: 1, material: "lamp")"#);
    let both = format!("{quad}, {}", r#"sphere(center: (-3, 3, 0), radius: 1, material: "lamp")"#);
    let known = |name: &str, material: &str, lamps: &str, want: f64| {
        Known::new(name, &floor(material, lamps), want)
    };
    compare(
        "floors under lamps",
        &[
            known("lambertian, sphere", "lambertian", sphere, lambert_sphere),
            known("diffuse, sphere", "diffuse", sphere, solid_sphere),
            known("lambertian, rectangle", "lambertian", quad, lambert_quad),
            known("diffuse, rectangle", "diffuse", quad, diffuse_quad),
            known("lambertian, triangles", "lambertian", triangles, lambert_quad),
            known("diffuse, triangles", "diffuse", triangles, diffuse_quad),
            known("lambertian, 192 triangles", "lambertian", &many, lambert_quad),
            known("diffuse, 192 triangles", "diffuse", &many, diffuse_quad),
            known(
                "lambertian, 192 triangles and a sphere",
                "lambertian",
                &many_and_sphere,
                lambert_quad + lambert_sphere,
            ),
            known("lambertian, two lamps", "lambertian", &both, lambert_quad + lambert_sphere),
            known(
                "behind a one-sided lamp",
                "lambertian",
                &format!(
                    "{}, {sphere}",
                    r#"quad(q: (-3, 0.5, -2), u: (0, 0, 2), v: (3, 0, 0), material: "front")"#,
                ),
                lambert_sphere,
            ),
        ],
    );
}

/// The integrating sphere: a hollow diffuse sphere of albedo ρ and radius R around a lamp of radius
/// a. The lamp absorbs the share F = a²/R² of the light that leaves the wall, so the wall's radiance
/// is ρLF/(1 − ρ(1 − F)) everywhere.
#[test]
fn closed_room_has_its_radiance() {
    let text = r#"(camera: (look_from: (0, 0, 0), look_at: (0, 1, 0), up: (0.1, 1, 0.2), vfov: 0.02),
        materials: {"wall": lambertian(albedo: (0.75, 0.75, 0.75)), "lamp": light(radiance: (10, 10, 10))},
        primitives: [sphere(center: (0, 0, 2), radius: 4, material: "wall"),
                     sphere(center: (0, 0, 2), radius: 1, material: "lamp")])"#;
    let share = 1.0 / 16.0;
    let want = 0.75 * 10.0 * share / (1.0 - 0.75 * (1.0 - share));
    compare("integrating sphere", &[Known::new("rho 0.75", text, want)]);
}
