//! Lights: their samples have the densities that hits on them are told.

use glam::Vec3;
use std::f64::consts::PI;

use super::{Cone, SAMPLES, Table, randoms};
use crate::engine::dimension::Dimension;
use crate::engine::scalar::light;
use crate::geometry::{PreparedRay, Ray};
use crate::math::{length, normalize};
use crate::scene::{Light, Scene};

fn scene() -> Scene {
    let text = r#"(
        camera: (look_from: (0, 0, 9), look_at: (0, 0, 0), vfov: 40),
        materials: {"lamp": light(radiance: (1, 2, 3))},
        primitives: [
            sphere(center: (1, 1, 1), radius: 0.5, material: "lamp"),
            moving_sphere(center: (0, 3, 0), center1: (1, 3, 0), radius: 0.8, material: "lamp"),
            quad(q: (-1, 2, -1), u: (2, 0, 0), v: (0, 0, 1), material: "lamp"),
            quad(q: (-1, 2, -1), u: (2, 0.5, 0), v: (1, 0, 1), material: "lamp"),
            triangles(vertices: [(-1, 2, -1), (1, 2.5, -1), (0, 2, 1)], indices: [(0, 1, 2)], material: "lamp"),
        ],
    )"#;
    Scene::from_ron(text).expect("a scene")
}

/// Points from near to far; inside a sphere; edge-on to the quad.
const FROM: [Vec3; 6] = [
    Vec3::new(0.1, 0.2, -0.3),
    Vec3::new(0.3, 1.8, 0.2),
    Vec3::new(1.1, 1.2, 0.9),
    Vec3::new(9.0, -7.0, 4.0),
    Vec3::new(3.0, 2.3, 0.0),
    Vec3::new(60.0, -50.0, 30.0),
];

/// A cone that holds the light as seen from `from`.
fn cone(scene: &Scene, light: &Light, from: Vec3) -> Cone {
    let bounds = scene.geometry().get(light.primitive).bounds();
    let (middle, half) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min) * 0.5);
    let (distance, radius) = (f64::from(length(middle - from)), f64::from(length(half)));
    // A little more, for rims that are rounded.
    let sin = 1.01 * radius / distance;
    Cone::new(normalize(middle - from), if sin < 1.0 { sin.asin() } else { PI })
}

#[test]
fn samples_have_their_density() {
    let (scene, mut table) = (scene(), Table::new("directions to lights"));
    for (index, light) in scene.lights().all().iter().enumerate() {
        for (place, from) in FROM.into_iter().enumerate() {
            let case = FROM.len() * index + place;
            let time = 0.3;
            let sample = |sample| {
                let numbers = randoms(case, sample).two(Dimension::LIGHT);
                Some(light::sample(light, from, time, numbers)?.direction)
            };
            let pdf = |direction| {
                let ray = Ray { origin: from, direction, time };
                let primitive = scene.geometry().get(light.primitive);
                let hit = primitive.intersect(&PreparedRay::new(&ray), 0.0, f32::INFINITY);
                hit.map_or(0.0, |t| f64::from(light::pdf(light, &ray, t)))
            };
            let shape = format!("{:?}", light.shape);
            let shape = shape.split('(').next().unwrap_or_default();
            let name = format!("{shape} {index} from {from}");
            table.directions(&name, &cone(&scene, light, from), sample, pdf);
        }
    }
    table.check();
}

/// A hit on a light is told the density that a sample of that direction has, and samples are on
/// their light.
#[test]
fn samples_and_hits_agree() {
    let scene = scene();
    for (index, light) in scene.lights().all().iter().enumerate() {
        for (place, from) in FROM.into_iter().enumerate() {
            let mut missed = 0;
            for sample in 0..10_000 {
                let numbers = randoms(FROM.len() * index + place, sample).two(Dimension::LIGHT);
                let Some(sample) = light::sample(light, from, 0.3, numbers) else { continue };
                let ray = Ray { origin: from, direction: sample.direction, time: 0.3 };
                let primitive = scene.geometry().get(light.primitive);
                let hit = primitive.intersect(&PreparedRay::new(&ray), 0.0, f32::INFINITY);
                let Some(t) = hit else {
                    missed += 1;
                    continue;
                };
                let pdf = light::pdf(light, &ray, t);
                assert!(
                    (pdf - sample.pdf).abs() < 1e-3 * pdf,
                    "{index} {from}: {pdf} {}",
                    sample.pdf
                );
                assert!((t - sample.distance).abs() < 1e-3 * t, "{t} {}", sample.distance);
            }
            // At the edges, by rounding.
            assert!(missed < 50, "{index} {from}: {missed}");
        }
    }
}

#[test]
fn lights_are_chosen_by_their_power() {
    let (scene, mut table) = (scene(), Table::new("choice of lights"));
    let lights = scene.lights().all();
    let mut counts = vec![0; lights.len()];
    for sample in 0..SAMPLES {
        let light = scene.lights().choose(randoms(77, sample).bits(Dimension::LIGHT_CHOICE));
        counts[light.primitive as usize] += 1;
    }
    let chances: Vec<f64> = lights.iter().map(|light| f64::from(light.chance)).collect();
    let whole: f64 = chances.iter().sum();
    assert!((whole - 1.0).abs() < 1e-6, "{whole}");
    let expected: Vec<f64> = chances.iter().map(|chance| chance * f64::from(SAMPLES)).collect();
    table.compare("by power", &counts, &expected, whole, 1.0);
    table.check();
    // 4π (0.5² and 0.8²), 2, and the others' cross products.
    let areas = [PI, 2.56 * PI, 2.0, 4.5f64.sqrt()];
    for (pair, areas) in chances.windows(2).zip(areas.windows(2)) {
        assert!((pair[1] / pair[0] - areas[1] / areas[0]).abs() < 1e-4, "{pair:?} {areas:?}");
    }
}
