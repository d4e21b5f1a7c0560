//! Surfaces that scatter and emit light, and light of textures, beside closed forms.

use std::f64::consts::PI;

use ptfast::glam::DVec3;
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

/// The irradiance at the origin, with the normal y, by a triangle of radiance 1 (Lambert's formula).
fn irradiance(vertices: [DVec3; 3]) -> f64 {
    let edge = |i: usize| {
        let [a, b] = [vertices[i], vertices[(i + 1) % 3]].map(DVec3::normalize);
        let across = a.cross(b);
        across.length().atan2(a.dot(b)) * across.normalize().y
    };
    (0.5 * (edge(0) + edge(1) + edge(2))).abs()
}

/// A floor below a lamp that emits light on one of its sides or has holes. Light samples and paths find the same light.
#[test]
fn lamps_with_sides_and_holes_light_floors() {
    let vertices = [[-2.0, 1.0, -1.5], [2.0, 1.0, -1.5], [0.0, 1.0, 2.0]];
    let all = 0.6 / PI * 2.0 * irradiance(vertices.map(DVec3::from_array));
    let floor = |name: &str, lamp: &str, turned: bool, share: f64| {
        let face = if turned { "(0, 2, 1)" } else { "(0, 1, 2)" };
        let list =
            vertices.map(|v| format!("{v:?}").replace('[', "(").replace(']', ")")).join(", ");
        let text = format!(
            r#"(camera: (look_from: (0, 0.5, 1), look_at: (0, 0, 0), vfov: 0.02), render: (depth: 2),
                textures: {{"grey": checker(odd: (1, 1, 1), even: (1, 1, 1), scale: 1),
                           "bars": uv_checker(odd: (1, 1, 1), even: (0.5, 0.5, 0.5), scale: (90, 90))}},
                materials: {{"floor": lambertian(albedo: (0.6, 0.6, 0.6)),
                            "lamp": principled(base_color: (0, 0, 0), specular: 0, {lamp})}},
                primitives: [quad(q: (-1, 0, -1), u: (0, 0, 2), v: (2, 0, 0), material: "floor"),
                    triangles(vertices: [{list}], indices: [{face}], material: "lamp")])"#
        );
        Known::new(name, &text, share * all)
    };
    let blend = "opacity: blend(alpha: 0.25)";
    let mask = r#"opacity: mask(alpha: (texture: "bars", channel: r), threshold: 0.7)"#;
    let texture = r#"emission: (texture: "grey", factor: (2, 2, 2))"#;
    compare(
        "lamps with sides and holes",
        &[
            floor("both sides", "emission: (2, 2, 2)", true, 1.0),
            floor("front", "emission: (2, 2, 2), emission_sides: front", false, 1.0),
            floor("front of a texture", &format!("{texture}, emission_sides: front"), false, 1.0),
            floor("blend", &format!("emission: (2, 2, 2), {blend}"), true, 0.25),
            floor("blend of a texture", &format!("{texture}, {blend}"), true, 0.25),
            floor("mask", &format!("emission: (2, 2, 2), {mask}"), true, 0.5),
        ],
    );
    for lamp in ["emission: (2, 2, 2)", texture] {
        let Known { scene, .. } =
            floor("back", &format!("{lamp}, emission_sides: front"), true, 0.0);
        for sampling in SAMPLINGS {
            let base = ImageSettings::of(&scene);
            let settings = ImageSettings { width: 8, height: 8, spp: 64, sampling, ..base };
            assert_eq!(render_by(&scene, settings, Engine::Wavefront).mean(), [0.0; 3], "{lamp}");
        }
    }
}

/// The variance of single samples of a floor below lamps of this light relative to the square of their mean, averaged
/// over pixels.
fn variance(emission: &str, lamps: &str) -> f64 {
    let scene = Scene::from_ron(&format!(
        r#"(camera: (look_from: (0, 1.5, 0), look_at: (0, 0, 0), up: (0, 0, -1), parallel: 2), render: (depth: 2),
            textures: {{"bars": uv_checker(odd: (0.5, 0.5, 0.5), even: (1, 1, 1), scale: (7, 5))}},
            materials: {{"floor": lambertian(albedo: (0.5, 0.5, 0.5)),
                         "lamp": principled(base_color: (0, 0, 0), specular: 0, emission: {emission})}},
            primitives: [quad(q: (-9, 0, 9), u: (18, 0, 0), v: (0, 0, -18), material: "floor"), {lamps}])"#
    ))
    .unwrap();
    let pictures: Vec<_> = (0..32)
        .map(|seed| {
            let base = ImageSettings::of(&scene);
            let settings = ImageSettings { width: 16, height: 16, spp: 1, seed, ..base };
            assert_eq!(settings.sampling, Sampling::Mis);
            render_by(&scene, settings, Engine::Wavefront)
        })
        .collect();
    let of = |pixel: usize| {
        let values = pictures.iter().map(|picture| f64::from(picture.pixels()[pixel][0]));
        let (sum, squares) =
            values.fold((0.0, 0.0), |(sum, squares), x| (sum + x, squares + x * x));
        let n = pictures.len() as f64;
        (squares - sum * sum / n) / (n - 1.0) / (sum / n * sum / n)
    };
    (0..256).map(of).sum::<f64>() / 256.0
}

/// Without light samples, the variance is hundreds of times as large.
#[test]
fn lamps_of_textures_are_sampled() {
    let quad = r#"quad(q: (-0.1, 2, -0.1), u: (0.2, 0, 0), v: (0, 0, 0.2), material: "lamp")"#;
    let n = 70;
    let at = |i: usize| i as f64 / n as f64;
    let points = (0..=n).flat_map(|y| (0..=n).map(move |x| (x, y)));
    let (vertices, uvs): (Vec<_>, Vec<_>) = points
        .map(|(x, y)| {
            (format!("({}, 2, {})", at(x) - 0.5, at(y) - 0.5), format!("({}, {})", at(x), at(y)))
        })
        .unzip();
    let faces = (0..n).flat_map(|y| {
        (0..n).map(move |x| {
            let i = y * (n + 1) + x;
            format!("({i}, {}, {}), ({}, {}, {})", i + 1, i + n + 1, i + 1, i + n + 2, i + n + 1)
        })
    });
    let triangles = format!(
        r#"triangles(vertices: [{}], uvs: [{}], indices: [{}], material: "lamp")"#,
        vertices.join(", "),
        uvs.join(", "),
        faces.collect::<Vec<_>>().join(", ")
    );
    // The texels alone vary by 1/9 of their squared mean. Of small triangles, the brighter ones are chosen more often.
    for (name, lamps, factor, texels) in
        [("a quad", quad, 1.1, 1.0 / 9.0), ("9800 triangles", &triangles, 2.0, 0.0)]
    {
        let textured = variance(r#"(texture: "bars", factor: (66.67, 66.67, 66.67))"#, lamps);
        let plain = variance("(50, 50, 50)", lamps);
        println!("{name}: {textured} beside {plain}");
        assert!(textured < factor * (plain + texels), "{name}: {textured} beside {plain}");
    }
}
