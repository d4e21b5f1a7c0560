//! Surfaces that scatter and emit light, beside closed forms. Light of textures is found only by paths that
//! hit the surface.

use ptfast::{Engine, ImageSettings, Roulette, Sampling, Scene};

use super::{Known, compare};
use crate::common::{SAMPLINGS, render_by};

/// A camera that looks down from (`x`, 0, 0.5), and these elements.
fn scene(x: f32, more: &str, primitives: &str) -> String {
    format!(
        r#"(camera: (look_from: ({x}, 0, 0.5), look_at: ({x}, -1, 0.5), up: (0.1, 1, 0.2), vfov: 0.02),
            textures: {{
                "cells": checker(odd: (0.1, 0.1, 0.1), even: (0.5, 0.5, 0.5), scale: 3.1415927),
                "even": checker(odd: (0.5, 0.5, 0.5), even: (0.5, 0.5, 0.5), scale: 1),
            }},
            materials: {{
                "glow": principled(base_color: (0, 0, 0), specular: 0, emission: (texture: "cells", factor: (4, 4, 4))),
                "dome": principled(base_color: (0, 0, 0), specular: 0, emission: "even"),
                "floor": lambertian(albedo: (0.6, 0.6, 0.6)),
                "lamp": light(radiance: (1, 1, 1)),
            }},
            {more}
            primitives: [{primitives}])"#
    )
}

#[test]
fn glowing_surfaces_shine_as_their_textures_say() {
    // Cells have sides of 1. The camera looks at the cell (0, −1, 0), or at (−1, −1, 0).
    let corners =
        "vertices: [(-0.9, -0.5, 0.1), (-0.9, -0.5, 0.9), (0.9, -0.5, 0.1), (0.9, -0.5, 0.9)]";
    let card =
        format!(r#"triangles({corners}, indices: [(0, 1, 2), (1, 3, 2)], material: "glow")"#);
    let meshes = format!(r#"meshes: {{"cards": [{card}]}},"#);
    let instance = r#"instance(mesh: "cards", matrix: ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0)))"#;
    // Paths sample the lamp, but it does not light the camera's side of the card.
    let lamp = r#"sphere(center: (0, -9, 0), radius: 0.1, material: "lamp")"#;
    let floor = r#"sphere(center: (0, 0, 0), radius: 9, material: "dome"),
        quad(q: (-0.1, -1, 0.4), u: (0, 0, 0.2), v: (0.2, 0, 0), material: "floor")"#;
    compare(
        "glowing textures",
        &[
            Known::new("an odd cell", &scene(0.5, "", &card), 0.4),
            Known::new("an even cell", &scene(-0.5, "", &card), 2.0),
            Known::new("in an instance", &scene(-0.5, &meshes, instance), 2.0),
            Known::new("beside a lamp", &scene(-0.5, "", &format!("{card}, {lamp}")), 2.0),
            Known::new("a floor in a dome", &scene(0.0, "", floor), 0.6 * 0.5),
        ],
    );
}

/// Inside a sphere of albedo a that emits radiance L everywhere, the radiance is L / (1 − a).
#[test]
fn surfaces_scatter_and_emit() {
    let text = r#"(camera: (look_from: (0.2, 0.1, 0), look_at: (0, 0, 1), vfov: 90),
        materials: {"glow": principled(base_color: (0.5, 0.5, 0.5), specular: 0, emission: (1, 1, 1))},
        primitives: [sphere(center: (0, 0, 0), radius: 1, material: "glow")])"#;
    let scene = Scene::from_ron(text).unwrap();
    for sampling in SAMPLINGS {
        let images = Engine::ALL.map(|engine| {
            let (width, height, spp, roulette) = (32, 32, 64, Roulette::Off);
            let base = ImageSettings::of(&scene);
            let settings = ImageSettings { width, height, spp, sampling, roulette, ..base };
            render_by(&scene, settings, engine)
        });
        assert_eq!(images[0].hash(), images[1].hash(), "{sampling:?}");
        let pixels = images[0].pixels();
        let mean =
            pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / pixels.len() as f64;
        println!("{sampling:?}: {mean:.5}");
        // If only the BSDF is sampled, all paths have the same radiance.
        let bound = if sampling == Sampling::Bsdf { 1e-5 } else { 0.01 };
        assert!((mean - 2.0).abs() < bound, "{sampling:?}: {mean}");
    }
}
