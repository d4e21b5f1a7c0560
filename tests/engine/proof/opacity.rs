//! HoleTest in triangles: light passes through them as if nothing were there.

use std::f64::consts::PI;

use ptfast::{Engine, Image, ImageSettings, Sampling, Scene};

use super::{Known, compare, compare_in};
use crate::common::{render_by, settings};

/// The opacity of a checker of cells with a side of 1: even cells are opaque.
const CHECKER: &str = "mask(alpha: (texture: \"cells\", factor: 0.9), threshold: 0.6)";

/// A floor at height −1 that the camera at the origin sees, a light, and a black card at height 0.25
/// with this opacity, or none.
fn shadow(light: &str, opacity: Option<&str>, instanced: bool) -> String {
    let corners = "vertices: [(-9, 0.25, -9), (9, 0.25, -9), (9, 0.25, 9), (-9, 0.25, 9)]";
    let card =
        format!(r#"triangles({corners}, indices: [(0, 1, 2), (0, 2, 3)], material: "card")"#);
    let (mesh, placed) = match (opacity, instanced) {
        (None, _) => (String::new(), String::new()),
        (Some(_), false) => (String::new(), card),
        (Some(_), true) => {
            let matrix = "matrix: ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0))";
            let instance = format!(r#"instance(mesh: "cards", {matrix})"#);
            (format!(r#"meshes: {{"cards": [{card}]}},"#), instance)
        }
    };
    let opacity = opacity.map_or(String::new(), |opacity| format!(", opacity: {opacity}"));
    format!(
        r#"(camera: (look_from: (0, 0, 0), look_at: (0, -1, 0), up: (0.1, 1, 0.2), vfov: 0.02),
            textures: {{"cells": checker(odd: (0, 0, 0), even: (1, 1, 1), scale: 3.1415927)}},
            materials: {{"floor": lambertian(albedo: (0.6, 0.6, 0.6)),
                         "card": lambertian(albedo: (0, 0, 0){opacity})}},
            {mesh}
            primitives: [quad(q: (-0.1, -1, -0.1), u: (0, 0, 0.2), v: (0.2, 0, 0), material: "floor"),
                         {placed}],
            lights: [{light}])"#
    )
}

#[test]
fn masks_cast_the_shadow_of_their_texture() {
    let image = |text: &str, engine: Engine| -> Image {
        let scene = Scene::from_ron(text).unwrap_or_else(|error| panic!("{error}: {text}"));
        let base = settings(&scene, Sampling::Light, 16, 1);
        render_by(&scene, ImageSettings { depth: 2, width: 4, height: 4, ..base }, engine)
    };
    // Half-way between the floor and the light, the shadow ray crosses the card at x = 0.5 or 1.5.
    for (x, lit) in [(1.0, false), (3.0, true), (-1.0, true), (-3.0, false)] {
        let light = format!("point(position: ({x}, 1.5, 1), intensity: (9, 9, 9))");
        for instanced in [false, true] {
            for engine in [Engine::Wavefront, Engine::Scalar] {
                let with = image(&shadow(&light, Some(CHECKER), instanced), engine);
                let without = image(&shadow(&light, None, instanced), engine);
                assert!(without.mean()[0] > 0.01);
                if lit {
                    assert_eq!(with.hash(), without.hash(), "{x} {instanced} {engine:?}");
                } else {
                    assert_eq!(with.mean(), [0.0; 3], "{x} {instanced} {engine:?}");
                }
            }
        }
    }
}

#[test]
fn blends_let_their_share_of_light_through() {
    let point = "point(position: (3, 3, 0), intensity: (50, 50, 50))";
    let irradiance = 50.0 / 25.0 * 0.8;
    let known = |name: &str, opacity: &str, instanced: bool, share: f64| {
        let text = shadow(point, Some(opacity), instanced);
        Known::new(name, &text, 0.6 / PI * irradiance * share)
    };
    compare_in(
        &[Sampling::Light, Sampling::Mis],
        "floors behind cards",
        &[
            known("opacity 0.3", "blend(alpha: 0.3)", false, 0.7),
            known("opacity 0.8, placed", "blend(alpha: 0.8)", true, 0.2),
        ],
    );
    // A black card in front of a sky of radiance 2.
    let card = r#"(camera: (look_from: (0, 0, 0), look_at: (0, 0, -1), vfov: 1),
        background: constant(radiance: (2, 2, 2)),
        materials: {"card": lambertian(albedo: (0, 0, 0), opacity: blend(alpha: 0.35))},
        primitives: [triangles(vertices: [(-9, -9, -1), (9, -9, -1), (0, 9, -1)],
                               indices: [(0, 1, 2)], material: "card")])"#;
    compare("a sky behind a card", &[Known::new("opacity 0.35", card, 1.3)]);
}

/// A slanted card that is one hole shows the sky behind it, of radiance 1, whatever its material. Its
/// surface would reflect and refract light from other heights.
#[test]
fn all_materials_can_have_holes() {
    let known = |material: &str| {
        let text = format!(
            r#"(camera: (look_from: (0, 0, 0), look_at: (0, 0, -1), vfov: 0.02),
                background: gradient(bottom: (0, 0, 0), top: (2, 2, 2)),
                materials: {{"card": {material}, opacity: blend(alpha: 0))}},
                primitives: [triangles(vertices: [(-9, -0.9, -1.9), (9, -0.9, -1.9), (0, 0.9, -0.1)],
                                       indices: [(0, 1, 2)], material: "card")])"#
        );
        Known::new(material, &text, 1.0)
    };
    compare(
        "a sky behind a hole",
        &[
            known("lambertian(albedo: (0.5, 0.5, 0.5)"),
            known("metal(albedo: (0.5, 0.5, 0.5)"),
            known("conductor(eta: (1, 1, 1), k: (2, 2, 2)"),
            known("dielectric(ior: 1.5"),
            known("rough_dielectric(ior: 1.5, alpha: 0.1"),
            known("coated_diffuse(reflectance: (0.5, 0.5, 0.5)"),
            known(
                "diffuse_transmission(reflectance: (0.2, 0.2, 0.2), transmittance: (0.1, 0.1, 0.1)",
            ),
            known("principled(transmission: 1"),
        ],
    );
}
