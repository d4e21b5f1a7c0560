//! Tests of lights: their samples follow the density that `pdf` reports for hits on them.

use std::f64::consts::PI;

use glam::Vec3;

use super::{Cone, SAMPLES, Table, randoms};
use crate::engine::SHADOW_REACH;
use crate::geometry::{PreparedRay, Primitive, Ray};
use crate::math::{Stream, length, normalize};
use crate::sampler::Dimension;
use crate::scene::Scene;
use crate::shading::SceneTables;
use crate::shading::light::LightSample;

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
    Scene::from_ron(text).expect("the scene is valid")
}

/// Points at various distances from the lights; one is inside a sphere, another edge-on to the
/// quad.
const FROM: [Vec3; 6] = [
    Vec3::new(0.1, 0.2, -0.3),
    Vec3::new(0.3, 1.8, 0.2),
    Vec3::new(1.1, 1.2, 0.9),
    Vec3::new(9.0, -7.0, 4.0),
    Vec3::new(3.0, 2.3, 0.0),
    Vec3::new(60.0, -50.0, 30.0),
];

/// The primitives that are lights, with the index of each light.
fn lights(scene: &Scene, tables: &SceneTables) -> Vec<(u32, u32)> {
    let light = |primitive: u32| {
        let shape = scene.geometry().get(primitive).shape();
        let (light, is_light) = tables.looks.lights::<f32>(shape, primitive);
        is_light.then_some((primitive, light))
    };
    (0..scene.geometry().len() as u32).filter_map(light).collect()
}

fn sample(
    tables: &SceneTables,
    light: u32,
    from: Vec3,
    time: f32,
    numbers: (f32, f32),
) -> Option<LightSample<f32>> {
    let sample = tables.lights.get::<f32>(light).sample(from, time, numbers);
    sample.visible.then_some(sample)
}

/// A cone that contains the light as seen from `from`.
fn cone(scene: &Scene, primitive: u32, from: Vec3) -> Cone {
    let bounds = scene.geometry().get(primitive).bounds();
    let (middle, half) = ((bounds.min + bounds.max) * 0.5, (bounds.max - bounds.min) * 0.5);
    let (distance, radius) = (f64::from(length(middle - from)), f64::from(length(half)));
    // 1% more allows for rounding errors at the rim.
    let sin = 1.01 * radius / distance;
    Cone::new(normalize(middle - from), if sin < 1.0 { sin.asin() } else { PI })
}

#[test]
fn samples_have_their_density() {
    let (scene, mut table) = (scene(), Table::new("directions to lights"));
    let tables = SceneTables::new(scene.world());
    for (index, (primitive, light)) in lights(&scene, &tables).into_iter().enumerate() {
        for (at, from) in FROM.into_iter().enumerate() {
            let case = FROM.len() * index + at;
            let time = 0.3;
            let sample = |sample| {
                let numbers = randoms(case, sample).two(Dimension::LIGHT);
                Some(super::light::sample(&tables, light, from, time, numbers)?.direction)
            };
            let pdf = |direction| {
                let ray = Ray { origin: from, direction, time };
                let primitive = scene.geometry().get(primitive);
                let hit = primitive.intersect(&PreparedRay::new(&ray), 0.0, f32::INFINITY);
                hit.map_or(0.0, |t| f64::from(tables.lights.get::<f32>(light).pdf(&ray, t)))
            };
            let shape = ["sphere", "moving sphere", "rectangle", "quad", "triangle"][index];
            let name = format!("{shape} {index} from {from}");
            table.directions(&name, &cone(&scene, primitive, from), sample, pdf);
        }
    }
    table.check();
}

/// The density for a hit on a light equals that of a sample with the same direction, and samples
/// lie on their light.
#[test]
fn samples_and_hits_agree() {
    let scene = scene();
    let tables = SceneTables::new(scene.world());
    for (index, (primitive, light)) in lights(&scene, &tables).into_iter().enumerate() {
        for (at, from) in FROM.into_iter().enumerate() {
            let mut missed = 0;
            for number in 0..10_000 {
                let numbers = randoms(FROM.len() * index + at, number).two(Dimension::LIGHT);
                let Some(sample) = sample(&tables, light, from, 0.3, numbers) else { continue };
                let ray = Ray { origin: from, direction: sample.direction, time: 0.3 };
                let primitive = scene.geometry().get(primitive);
                let hit = primitive.intersect(&PreparedRay::new(&ray), 0.0, f32::INFINITY);
                let Some(t) = hit else {
                    missed += 1;
                    continue;
                };
                let pdf = tables.lights.get::<f32>(light).pdf(&ray, t);
                assert!(
                    (pdf - sample.pdf).abs() < 1e-3 * pdf,
                    "{index} {from}: {pdf} {}",
                    sample.pdf
                );
                assert!((t - sample.distance).abs() < 1e-3 * t, "{t} {}", sample.distance);
            }
            // Samples near the edges may miss by rounding errors.
            assert!(missed < 50, "{index} {from}: {missed}");
        }
    }
}

#[test]
fn lights_are_chosen_by_their_power() {
    let (scene, mut table) = (scene(), Table::new("choice of lights"));
    let tables = SceneTables::new(scene.world());
    let chance = |light: u32| tables.lights.get::<f32>(light).chance(Vec3::ZERO);
    let chances: Vec<f64> = (0..scene.lights()).map(|light| f64::from(chance(light))).collect();
    let mut counts = vec![0; chances.len()];
    for sample in 0..SAMPLES {
        // Every light has a different chance, which identifies it.
        let chosen = f64::from(
            tables.lights.choose::<f32>(&randoms(77, sample), Vec3::ZERO).chance(Vec3::ZERO),
        );
        counts[chances.iter().position(|&chance| chance == chosen).unwrap()] += 1;
    }
    let whole: f64 = chances.iter().sum();
    assert!((whole - 1.0).abs() < 1e-6, "{whole}");
    let expected: Vec<f64> = chances.iter().map(|chance| chance * f64::from(SAMPLES)).collect();
    table.compare("by power", &counts, &expected, whole, 1.0);
    table.check();
    // Areas: spheres with 4π · 0.5² and 4π · 0.8², a rectangle with 2, and the quad's cross
    // product.
    let areas = [PI, 2.56 * PI, 2.0, 4.5f64.sqrt()];
    for (pair, areas) in chances.windows(2).zip(areas.windows(2)) {
        assert!((pair[1] / pair[0] - areas[1] / areas[0]).abs() < 1e-4, "{pair:?} {areas:?}");
    }
}

/// Shadow rays end before their light even if a program with other rounding computes its distance.
#[test]
fn shadow_rays_end_just_before_their_light() {
    let mut random = Stream::new(3);
    let tilted = r#"(
        camera: (look_from: (0, 0, 9), look_at: (0, 0, 0), vfov: 40),
        materials: {"lamp": light(radiance: (1, 1, 1))},
        primitives: [
            quad(q: (343, 300, 332), u: (-130, 37, 11), v: (13, 20, -105), material: "lamp"),
            moving_sphere(center: (50, 40, 30), center1: (60, 45, 30), radius: 40, material: "lamp"),
            triangles(vertices: [(300, 200, 400), (420, 230, 380), (350, 310, 420)], indices: [(0, 1, 2)],
                      material: "lamp"),
        ],
    )"#;
    let scenes = [
        ("cornell", Scene::load("cornell"), 555.0),
        ("checker", Scene::load("checker"), 20.0),
        ("tilted", Scene::from_ron(tilted), 555.0),
    ];
    for (name, scene, extent) in scenes {
        let scene = scene.unwrap();
        let mut checked = 0;
        let tables = SceneTables::new(scene.world());
        for (primitive, light) in lights(&scene, &tables) {
            for _ in 0..100_000 {
                let [x, y, z, u, v, time] = [(); 6].map(|()| random.uniform());
                let from = Vec3::new(x, y, z) * extent;
                let Some(sample) = sample(&tables, light, from, time, (u, v)) else { continue };
                let (origin, direction) = (from.as_dvec3(), sample.direction.as_dvec3());
                let on_plane = |point: Vec3, u: Vec3, v: Vec3| {
                    let normal = u.as_dvec3().cross(v.as_dvec3()).normalize();
                    let slope = normal.dot(direction);
                    // Skip grazing rays, which magnify the rounding errors of the plane.
                    (slope.abs() > 0.01).then(|| normal.dot(point.as_dvec3() - origin) / slope)
                };
                let distance = match scene.geometry().get(primitive) {
                    Primitive::Quad(quad) => on_plane(quad.q, quad.u, quad.v),
                    Primitive::Triangle(triangle) => {
                        let [a, b, c] = triangle.vertices;
                        on_plane(a, b - a, c - a)
                    }
                    Primitive::Sphere(sphere) => {
                        let to_center = sphere.center_at(time).as_dvec3() - origin;
                        let ahead = to_center.dot(direction);
                        let distance2 = to_center.dot(to_center);
                        let aside2 = distance2 - ahead * ahead;
                        let radius2 = f64::from(sphere.radius) * f64::from(sphere.radius);
                        // Skip points inside the sphere, and rays near the silhouette, whose
                        // rounding error is √ε.
                        (distance2 > radius2 && radius2 - aside2 > 0.01 * radius2)
                            .then(|| ahead - (radius2 - aside2).sqrt())
                    }
                };
                let Some(distance) = distance else { continue };
                let short = 1.0 - f64::from(sample.distance * SHADOW_REACH) / distance;
                assert!((short - 1e-4).abs() < 5e-5, "{name} {from}: {short:e}");
                checked += 1;
            }
        }
        assert!(checked > 50_000, "{name}: {checked}");
    }
}
