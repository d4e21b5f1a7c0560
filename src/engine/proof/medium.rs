//! Tests of media: the distances of collisions, and the transmittance.

use glam::Vec3;

use super::{SAMPLES, Table, randoms};
use crate::geometry::{Hit, Ray};
use crate::scene::Scene;
use crate::shading::SceneTables;

/// Two media along x: a ball from 1 to 3, and a box from 4 to 6.
fn tables() -> SceneTables {
    let text = "(camera: (look_from: (0, 0, 9), look_at: (0, 0, 0), vfov: 40), media: [
        sphere(center: (2, 0, 0), radius: 1, density: 0.6, albedo: (1, 1, 1)),
        box(min: (4, -1, -1), max: (6, 1, 1), density: 0.9, albedo: (0.5, 0.5, 0.5)),
    ])";
    SceneTables::new(Scene::from_ron(text).expect("the scene is valid").world())
}

/// The optical depth along x up to `t`.
fn depth(t: f64) -> f64 {
    0.6 * (t - 1.0).clamp(0.0, 2.0) + 0.9 * (t - 4.0).clamp(0.0, 2.0)
}

#[test]
fn distances_are_exponential() {
    let (tables, mut table) = (tables(), Table::new("distances of collisions"));
    for (case, (from, end)) in
        [(0.0f32, f32::INFINITY), (2.2, 5.0), (-3.0, 8.5), (4.5, 99.0)].into_iter().enumerate()
    {
        const CELLS: usize = 60;
        let ray = Ray { origin: Vec3::new(from, 0.0, 0.0), direction: Vec3::X, time: 0.0 };
        let bin = |x: f64| (x * 10.0) as usize;
        let mut counts = vec![0; CELLS + 1];
        for sample in 0..SAMPLES {
            let (t, what) = tables.media.collide(&ray, (end, Hit::MISS), &randoms(case, sample));
            let cell = match what {
                Hit::MISS => CELLS,
                _ => bin(f64::from(from) + f64::from(t)),
            };
            counts[cell] += 1;
        }
        let last = f64::from(from) + f64::from(end);
        let far = |x: f64| if x < f64::from(from) { f64::from(from) } else { x.min(last) };
        let crosses = |x: f64| (depth(f64::from(from)) - depth(far(x))).exp();
        let n = f64::from(SAMPLES);
        let cell = |i: usize| n * (crosses(i as f64 / 10.0) - crosses((i + 1) as f64 / 10.0));
        let expected: Vec<f64> = (0..CELLS).map(cell).chain([n * crosses(1e9)]).collect();
        let whole = expected.iter().sum::<f64>() / n;
        table.compare(&format!("from {from} to {end}"), &counts, &expected, whole, 1.0);
    }
    table.check();
}

#[test]
fn transmittance_is_that_of_the_depth() {
    let tables = tables();
    for from in [-2.0f32, 0.0, 1.5, 3.5, 5.0, 7.0] {
        for end in [0.1f32, 0.9, 2.0, 4.0, 20.0, f32::INFINITY] {
            let ray = Ray { origin: Vec3::new(from, 0.0, 0.0), direction: Vec3::X, time: 0.0 };
            let got = f64::from(tables.media.transmittance::<f32>(&ray, end));
            let (begin, far) = (f64::from(from), f64::from(from) + f64::from(end));
            let want = (depth(begin) - depth(far)).exp();
            assert!((got - want).abs() < 1e-6, "{from} {end}: {got} {want}");
        }
    }
}
