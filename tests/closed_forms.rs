//! Scenes whose radiance is known in closed form.
#![allow(clippy::disallowed_methods)] // the yardstick is libm's f64

mod common;

use std::f64::consts::PI;

use common::{SAMPLINGS, estimate, render, settings};
use ptfast::{RenderSettings, Sampling, Scene};

/// A camera at the origin that looks along `look_at` through a narrow angle.
fn scene(look_at: (f32, f32, f32), rest: &str) -> Scene {
    let text = format!(
        "(camera: (look_from: (0, 0, 0), look_at: {look_at:?}, up: (0.1, 1, 0.2), vfov: 0.02), {rest})"
    );
    Scene::from_ron(&text).unwrap()
}

/// A furnace: under a sky of radiance 1 a convex diffuse body of albedo ρ has the radiance ρ,
/// in every pixel and every sample.
#[test]
fn furnace_of_diffuse_spheres() {
    for material in ["diffuse", "lambertian"] {
        for albedo in [0.0, 0.25, 0.8, 1.0f32] {
            let scene = Scene::from_ron(&format!(
                r#"(camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 10),
                    background: constant(radiance: (1, 1, 1)),
                    materials: {{"m": {material}(albedo: ({albedo}, {albedo}, {albedo}))}},
                    primitives: [sphere(center: (0, 0, 0), radius: 1, material: "m")])"#
            ))
            .unwrap();
            let base = settings(&scene, Sampling::Bsdf, 4, 1);
            let image = render(&scene, RenderSettings { width: 20, height: 20, ..base });
            for pixel in image.pixels() {
                assert!((pixel[0] - albedo).abs() < 1e-6, "{material} {albedo} {pixel:?}");
            }
        }
    }
}

/// Inside a hollow sphere that shines with radiance L, a diffuse sphere has the radiance ρL.
#[test]
fn sphere_in_a_glowing_room() {
    for material in ["diffuse", "lambertian"] {
        let scene = scene(
            (0.0, 0.0, -1.0),
            &format!(
                r#"materials: {{"wall": light(radiance: (3, 3, 3)), "m": {material}(albedo: (0.5, 0.5, 0.5))}},
                   primitives: [sphere(center: (0, 0, 0), radius: 10, material: "wall"),
                                sphere(center: (0, 0, -5), radius: 1, material: "m")]"#
            ),
        );
        for sampling in SAMPLINGS {
            let estimate = estimate(&scene, &settings(&scene, sampling, 4096, 0));
            estimate.assert_is(1.5, 0.02, &format!("{material} {sampling:?}"));
        }
    }
}

/// The integrating sphere: a diffuse hollow sphere of albedo ρ and radius R about a lamp of
/// radius a. The lamp takes the share F = a²/R² of what the wall sends out, so the wall's
/// radiance is ρLF/(1 − ρ(1 − F)) everywhere.
#[test]
fn closed_room_of_known_radiance() {
    let scene = scene(
        (0.0, 1.0, 0.0),
        r#"materials: {"wall": lambertian(albedo: (0.75, 0.75, 0.75)), "lamp": light(radiance: (10, 10, 10))},
           primitives: [sphere(center: (0, 0, 2), radius: 4, material: "wall"),
                        sphere(center: (0, 0, 2), radius: 1, material: "lamp")]"#,
    );
    let share = 1.0 / 16.0;
    let want = 0.75 * 10.0 * share / (1.0 - 0.75 * (1.0 - share));
    for sampling in SAMPLINGS {
        for roulette in [true, false] {
            let base = RenderSettings { roulette, ..settings(&scene, sampling, 16_384, 0) };
            estimate(&scene, &base).assert_is(want, 0.02, &format!("{sampling:?} {roulette}"));
        }
    }
}

/// A plane below a lamp sphere: E = πL (r/d)² cos θ, radiance ρE/π; for the ideal diffuse
/// material ρ/2π times L times the solid angle.
#[test]
fn plane_under_a_sphere_light() {
    // The camera sees the point (0, -1, 0); the lamp's centre is 5 from it, 3 to the side.
    for (material, want) in [
        ("lambertian", 0.6 * 8.0 * (1.0 / 25.0) * 0.8),
        ("diffuse", 0.6 / (2.0 * PI) * 8.0 * 2.0 * PI * (1.0 - (1.0f64 - 1.0 / 25.0).sqrt())),
    ] {
        let scene = scene(
            (0.0, -1.0, 0.0),
            &format!(
                r#"materials: {{"floor": {material}(albedo: (0.6, 0.6, 0.6)), "lamp": light(radiance: (8, 8, 8))}},
                   primitives: [quad(q: (-9, -1, -9), u: (0, 0, 18), v: (18, 0, 0), material: "floor"),
                                sphere(center: (3, 3, 0), radius: 1, material: "lamp")]"#
            ),
        );
        for sampling in SAMPLINGS {
            let estimate = estimate(&scene, &settings(&scene, sampling, 65_536, 0));
            estimate.assert_is(want, 0.02, &format!("{material} {sampling:?}"));
        }
    }
}

/// A plane below a rectangular lamp whose corner is straight above: the form factor of a
/// parallel rectangle (Howell, *A Catalog of Radiation Heat Transfer Configuration Factors*,
/// B-3) and the closed solid angle.
#[test]
fn plane_under_a_quad_light() {
    let (a, b, height) = (3.0f64, 2.0, 1.5);
    let (x, y) = (a / height, b / height);
    let (rx, ry) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    let factor = (x / rx * (y / rx).atan() + y / ry * (x / ry).atan()) / (2.0 * PI);
    let solid_angle = (x * y / (1.0 + x * x + y * y).sqrt()).atan();
    for (material, want) in
        [("lambertian", 0.5 * 4.0 * factor), ("diffuse", 0.5 / (2.0 * PI) * 4.0 * solid_angle)]
    {
        let scene = scene(
            (0.0, -1.0, 0.0),
            &format!(
                r#"materials: {{"floor": {material}(albedo: (0.5, 0.5, 0.5)), "lamp": light(radiance: (4, 4, 4))}},
                   primitives: [quad(q: (-9, -1, -9), u: (0, 0, 18), v: (18, 0, 0), material: "floor"),
                                quad(q: (0, 0.5, 0), u: (3, 0, 0), v: (0, 0, 2), material: "lamp")]"#
            ),
        );
        for sampling in SAMPLINGS {
            let estimate = estimate(&scene, &settings(&scene, sampling, 16_384, 0));
            estimate.assert_is(want, 0.02, &format!("{material} {sampling:?}"));
        }
    }
}

/// A slanted lamp is a parallelogram, sampled by area: as bright as the same lamp found by
/// scattering alone.
#[test]
fn parallelogram_and_triangle_lights_agree_with_scattering() {
    let lamps = [
        r#"quad(q: (-1, 1, 0), u: (2, 0.5, 0), v: (1, 0, 2), material: "lamp")"#,
        r#"triangles(vertices: [(-1, 1, 0), (2, 1, 0), (0, 1, 2)], indices: [(0, 1, 2)], material: "lamp")"#,
    ];
    for lamp in lamps {
        let scene = scene(
            (0.0, -1.0, 0.0),
            &format!(
                r#"materials: {{"floor": lambertian(albedo: (0.5, 0.5, 0.5)), "lamp": light(radiance: (4, 4, 4))}},
                   primitives: [quad(q: (-9, -1, -9), u: (0, 0, 18), v: (18, 0, 0), material: "floor"), {lamp}]"#
            ),
        );
        let want = estimate(&scene, &settings(&scene, Sampling::Bsdf, 65_536, 100));
        for sampling in [Sampling::Light, Sampling::Mis] {
            let got = estimate(&scene, &settings(&scene, sampling, 16_384, 0));
            let bound = 5.0 * (got.error * got.error + want.error * want.error).sqrt();
            assert!((got.mean - want.mean).abs() < bound, "{sampling:?}: {got:?} {want:?}");
            assert!(bound < 0.015 * want.mean, "{got:?} {want:?}");
        }
    }
}

/// A lamp that shines on its front only lights nothing behind it.
#[test]
fn one_sided_lights_are_dark_behind() {
    let scene_with = |u: &str, v: &str| {
        scene(
            (0.0, -1.0, 0.0),
            &format!(
                r#"materials: {{"floor": lambertian(albedo: (0.5, 0.5, 0.5)),
                               "lamp": light(radiance: (4, 4, 4), sides: front)}},
                   primitives: [quad(q: (-9, -1, -9), u: (0, 0, 18), v: (18, 0, 0), material: "floor"),
                                quad(q: (-1, 1, -1), u: {u}, v: {v}, material: "lamp")]"#
            ),
        )
    };
    for sampling in SAMPLINGS {
        let up = scene_with("(0, 0, 2)", "(2, 0, 0)");
        assert_eq!(render(&up, settings(&up, sampling, 1024, 1)).mean(), [0.0; 3], "{sampling:?}");
        let down = scene_with("(2, 0, 0)", "(0, 0, 2)");
        assert!(render(&down, settings(&down, sampling, 1024, 1)).mean()[0] > 0.1, "{sampling:?}");
    }
}

/// No material gives back more than it gets, and clear glass and perfect mirrors all of it.
#[test]
fn energy_is_conserved_by_every_material() {
    for (material, lossless) in [
        ("diffuse(albedo: (1, 1, 1))", true),
        ("lambertian(albedo: (1, 1, 1))", true),
        ("metal(albedo: (1, 1, 1))", true),
        ("metal(albedo: (1, 1, 1), fuzz: 0.3)", false),
        ("metal(albedo: (1, 1, 1), fuzz: 1)", false),
        ("dielectric(ior: 1.5)", true),
        ("dielectric(ior: 0.6)", true),
    ] {
        let scene = Scene::from_ron(&format!(
            r#"(camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 30),
                background: constant(radiance: (1, 1, 1)),
                materials: {{"m": {material}}},
                primitives: [sphere(center: (0, 0, 0), radius: 1, material: "m"),
                             box(min: (-1, -2.5, -1), max: (1, -2, 1), rotation: (10, 20, 30), material: "m")])"#
        ))
        .unwrap();
        let settings = RenderSettings {
            width: 50,
            height: 50,
            roulette: false,
            depth: 1000,
            ..settings(&scene, Sampling::Bsdf, 16, 1)
        };
        let image = render(&scene, settings);
        let largest =
            image.pixels().iter().flatten().fold(0.0, |m: f32, &v| if v > m { v } else { m });
        assert!(largest <= 1.0, "{material}: {largest}");
        let mean = image.mean()[0];
        assert_eq!(mean > 0.999_99, lossless, "{material}: {mean}");
        assert!(mean > 0.7, "{material}: {mean}");
    }
}

/// A gradient sky is the colour of the direction.
#[test]
fn gradient_background() {
    for (look_at, want) in [((0.0, 1.0, 0.3), None), ((0.0, 0.0, -1.0), Some(0.5))] {
        let scene = scene(look_at, "background: gradient(bottom: (0, 0, 0), top: (1, 1, 1))");
        let mean = render(&scene, settings(&scene, Sampling::Bsdf, 16, 1)).mean()[1];
        let want = want.unwrap_or(0.5 * (1.0 + 1.0 / (1.0f64 + 0.09).sqrt()));
        assert!((mean - want).abs() < 1e-3, "{mean} {want}");
    }
}
