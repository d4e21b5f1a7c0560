//! Tests of the camera and of random numbers: pixels, lens and shutter are sampled uniformly.

use glam::Vec3;

use super::{SAMPLES, Table, randoms, seed};
use crate::math::{PixelKey, cross, dot};
use crate::sampler::{Dimension, Randoms, Sampler};
use crate::scene::Scene;

/// The index of the cell of a 16 × 16 grid over the unit square that contains a point.
fn square(u: f32, v: f32) -> usize {
    let cell = |x: f32| ((x * 16.0) as usize).min(15);
    cell(u) * 16 + cell(v)
}

#[test]
fn rays_fill_pixel_lens_and_shutter() {
    let text = "(camera: (look_from: (1, 2, 3), look_at: (0, 0, 0), vfov: 40, defocus_angle: 8, \
                          focus_distance: 4, shutter: (0.2, 0.7)))";
    let scene = Scene::from_ron(text).expect("the scene is valid");
    let frame = scene.camera().frame(40, 30);
    let (lens_u, lens_v) = frame.lens.expect("the camera has a lens");
    let forward = crate::math::normalize(cross(lens_v, lens_u));
    let (mut pixel, mut lens, mut time) = (vec![0; 256], vec![0; 256], vec![0; 256]);
    for index in 0..SAMPLES {
        let (x, y) = (7.0, 11.0);
        let (ray, _) = frame.ray::<f32, false>(x, y, &randoms(5, index));
        // The point at which the ray crosses the plane in focus. `cell` converts it to pixels.
        let focus = ray.direction * (4.0 / dot(ray.direction, forward)) + ray.origin - frame.origin;
        let (right, down) = frame.pixel_steps;
        let cell = |step: Vec3| dot(focus - frame.corner, step) / dot(step, step);
        pixel[square(cell(right) - x, cell(down) - y)] += 1;
        let on_lens = |axis: Vec3| dot(ray.origin - frame.origin, axis) / dot(axis, axis);
        let (a, b) = (on_lens(lens_u), on_lens(lens_v));
        // If points are uniform in a disk, their squared radius and their angle are uniform.
        let turn = (b.atan2(a) / std::f32::consts::TAU).rem_euclid(1.0);
        lens[square(a * a + b * b, turn)] += 1;
        time[((ray.time - 0.2) / 0.5 * 256.0) as usize] += 1;
    }
    let mut table = Table::new("camera");
    let even = vec![f64::from(SAMPLES) / 256.0; 256];
    table.compare("pixel", &pixel, &even, 1.0, 1.0);
    table.compare("lens", &lens, &even, 1.0, 1.0);
    table.compare("shutter", &time, &even, 1.0, 1.0);
    table.check();
}

/// The random numbers of a path's segment are pairwise independent. The test uses one sample of
/// many pixels, because the samples of one pixel are not independent if they are Sobol' points.
#[test]
fn dimensions_have_nothing_in_common() {
    for sampler in Sampler::ALL {
        pairs_have_nothing_in_common(sampler);
    }
}

fn pairs_have_nothing_in_common(sampler: Sampler) {
    let randoms =
        |pixel: u32| Randoms::new(sampler, sampler.path(PixelKey::new(seed(), pixel, 21), 5), 1);
    let dimensions = [
        Dimension::LIGHT_CHOICE,
        Dimension::LIGHT,
        Dimension::SCATTER,
        Dimension::LOBE,
        Dimension::BALL,
        Dimension::ROULETTE,
        Dimension::medium(0),
        Dimension::medium(1),
    ];
    let mut table = Table::new(&format!("pairs of dimensions, {}", sampler.name()));
    let even = vec![f64::from(SAMPLES) / 256.0; 256];
    for (i, a) in dimensions.into_iter().enumerate() {
        for b in dimensions.into_iter().take(i) {
            let mut counts = vec![0; 256];
            for pixel in 0..SAMPLES {
                let randoms = randoms(pixel);
                counts[square(randoms.one(a), randoms.one(b))] += 1;
            }
            table.compare(&format!("{a:?} {b:?}"), &counts, &even, 1.0, 1.0);
        }
        // Compare the second number of each pair with all other dimensions.
        for pair in [Dimension::LIGHT, Dimension::SCATTER] {
            let mut counts = vec![0; 256];
            for pixel in 0..SAMPLES {
                let randoms = randoms(pixel);
                counts[square(randoms.one(a), randoms.two(pair).1)] += 1;
            }
            table.compare(&format!("{a:?} second of {pair:?}"), &counts, &even, 1.0, 1.0);
        }
    }
    let mut counts = vec![0; 256];
    for pixel in 0..SAMPLES {
        let randoms = randoms(pixel);
        let second = |pair| randoms.two(pair).1;
        counts[square(second(Dimension::LIGHT), second(Dimension::SCATTER))] += 1;
    }
    table.compare("second of light, of scatter", &counts, &even, 1.0, 1.0);
    table.check();
}
