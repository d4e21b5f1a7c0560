//! Tests that every kernel finds bit for bit the same hits as brute force.
//!
//! With the feature `slow-tests` they trace ten million rays per kind of scene, otherwise fewer. For
//! scenes of more than ten thousand primitives the oracle is the reference tree, see
//! [`generated_scenes`].

mod check;
mod counters;
mod holes;
mod instances;
mod odd_geometry;
mod odd_rays;
mod rays;

use glam::Vec3;
use ptfast::Kernel;
use ptfast::internals::{
    Accelerator, Bvh2, Geometry, HitBatch, Quad, Ray, RayBatch, Sphere, Stream, Triangle,
    uniform_sphere,
};
use rayon::prelude::*;

use self::check::{RAYS, ROUND, bits, check, check_kernels, rounds};
use self::rays::{Bundles, adversarial, soup, vector};

#[test]
fn random_and_adversarial_rays() {
    // Plain, scaled and shifted scenes, with at least `RAYS` rays for each kind of scene.
    for (seed, primitives, scale, shift) in [
        (1, 3, 1.0, Vec3::ZERO),
        (2, 60, 1.0, Vec3::ZERO),
        (4, 300, 1e-3, Vec3::ZERO),
        (5, 300, 1e5, Vec3::ZERO),
        (7, 100, 1e-6, Vec3::ZERO),
        (8, 100, 1e6, Vec3::ZERO),
        (3, 300, 100.0, Vec3::new(5.0, 3.0, -2.0)),
        (6, 300, 1.0, Vec3::new(1000.0, -3000.0, 200.0)),
        (9, 100, 1.0, Vec3::new(-1e5, 3e4, 0.0)),
        (10, 100, 1.0, Vec3::new(1e6, 1e6, -1e6)),
    ] {
        let geometry = soup(seed, primitives, scale, shift);
        check(&format!("soup {seed}"), &geometry, RAYS / 2, scale, shift);
    }
}

#[test]
fn built_in_scenes() {
    for name in ptfast::BUILTIN_NAMES {
        let scene = ptfast::Scene::load(name).unwrap();
        let (scale, shift) = match name {
            "cornell" => (300.0, Vec3::splat(278.0)),
            _ => (8.0, Vec3::Y),
        };
        check(name, scene.geometry(), RAYS, scale, shift);
    }
}

/// Small triangles seen from so far away that their coordinates hardly differ in f32.
#[test]
fn triangles_smaller_than_rounding() {
    let mut random = Stream::new(12);
    for (size, distance) in [(1e-3f32, 3e4f32), (2e-3, 1e3), (1.0, 1e6)] {
        let triangles = (0..200).map(|_| {
            let middle = vector(&mut random, 20.0 * size);
            Triangle { vertices: [(); 3].map(|()| middle + vector(&mut random, size)) }
        });
        let geometry = Geometry { triangles: triangles.collect(), ..Geometry::default() };
        let tree = Bvh2::new(&geometry, 1);
        let mut make = |i: usize| {
            let origin = uniform_sphere(random.uniform(), random.uniform()) * distance;
            let [a, b, c] = geometry.triangles.vertices(i % 200);
            let to = match i % 2 {
                0 => vector(&mut random, 20.0 * size),
                // The middle of an edge.
                _ => [a, b, c][i / 2 % 3] * 0.5 + [b, c, a][i / 2 % 3] * 0.5,
            };
            (Ray { origin, direction: to - origin, time: 0.0 }, f32::INFINITY)
        };
        let rays: Vec<_> = (0..20_000).map(|i| make(i).0).collect();
        rays.par_iter().for_each(|ray| {
            let want = geometry.closest_by_brute_force(ray, 0.0, f32::INFINITY);
            assert_eq!(tree.closest(&geometry, ray, 0.0, f32::INFINITY), want, "{ray:?}");
            // A hit must not lie far beside the triangle.
            if let Some(hit) = want {
                let middle = geometry.triangles.vertices(hit.primitive as usize)[0];
                let miss = ray.origin + ray.direction * hit.t - middle;
                assert!(miss.length_squared().sqrt() < 4.0 * size + 1e-5 * distance, "{miss}");
            }
        });
        let oracle = |ray: &Ray, t_min, t_max| geometry.closest_by_brute_force(ray, t_min, t_max);
        check_kernels("smaller than rounding", &geometry, RAYS / 4, make, oracle);
    }
}

/// The rounding error of a hit's coordinates on a quad grows as the quad becomes thinner, so rays
/// can hit slightly beyond its tips, outside its box. The slack of the box tests
/// (`src/accel/slab.rs`) covers the worst case. This test detects only a slack below one roundoff:
/// even without the factor of the condition number, the slack of 32 roundoffs passes 10^7 rays.
#[test]
fn tips_of_thin_quads() {
    let mut random = Stream::new(21);
    for _ in 0..100 {
        // The only quad of a scene has a box of its own.
        let sphere = Sphere::still(Vec3::splat(-1.7), 0.1);
        let edge = |random: &mut Stream| Vec3::splat(0.5) + vector(random, 0.008);
        let quad = loop {
            let (u, v) = (edge(&mut random), edge(&mut random));
            let quad = Quad::new(vector(&mut random, 0.1), u, v);
            if let Some(quad) = quad.filter(|quad| quad.condition() > 90.0) {
                break quad;
            }
        };
        let geometry = Geometry { spheres: vec![sphere], quads: vec![quad], ..Geometry::default() };
        let make = |_| {
            let tip = quad.q + quad.u + quad.v;
            let origin = tip + quad.normal * random.between(0.1, 0.5) + vector(&mut random, 0.2);
            let beside = (quad.u + quad.v) * random.between(-1e-5, 1e-5);
            (Ray { origin, direction: tip + beside - origin, time: 0.0 }, f32::INFINITY)
        };
        let oracle = |ray: &Ray, t_min, t_max| geometry.closest_by_brute_force(ray, t_min, t_max);
        check_kernels("thin quads", &geometry, RAYS / 40, make, oracle);
    }
}

/// Scenes for which brute force takes too long. The oracle is the reference tree, which is itself
/// compared with brute force on some rays of the same scene.
#[test]
fn generated_scenes() {
    for (name, scale, shift) in [
        // The trees of scenes above 131072 primitives are built from clusters.
        ("cloud:140000", 40.0, Vec3::ZERO),
        ("mesh:61440", 4.0, Vec3::ZERO),
        ("mesh:143360", 5.0, Vec3::new(700.0, -30.0, 9000.0)),
    ] {
        let scene = ptfast::Scene::load(name).unwrap();
        let mut geometry = Geometry::clone(scene.geometry());
        geometry.triangles.map_vertices(|vertex| vertex + shift);
        if name.starts_with("mesh") {
            // Rays must also meet blocks of the other shapes.
            let others = soup(11, 300, 0.5 * scale, shift);
            geometry.spheres.extend(others.spheres);
            geometry.quads.extend(others.quads);
        }
        let geometry = &geometry;
        // Trees of more than 2^20 bytes are traced in other ways, so require 1.5 times as much.
        let layout = Accelerator::new(geometry.clone()).prepare(Kernel::Stream, 2);
        assert!(layout.bytes > 3 << 19, "{name}: {} bytes", layout.bytes);
        let tree = Bvh2::new(geometry, 2);
        let mut random = Stream::new(17);
        let mut make = |i| adversarial(&mut random, i, geometry, scale, shift);
        let rays: Vec<_> = (0..RAYS / 100).map(&mut make).collect();
        rays.par_iter().for_each(|(ray, t_max)| {
            let want = geometry.closest_by_brute_force(ray, 0.0, *t_max);
            assert_eq!(bits(tree.closest(geometry, ray, 0.0, *t_max)), bits(want), "{ray:?}");
        });
        let oracle = |ray: &Ray, t_min, t_max| tree.closest(geometry, ray, t_min, t_max);
        check_kernels(name, geometry, RAYS / 2, make, oracle);
        let mut bundles = Bundles::new(18, geometry, scale, shift);
        check_kernels(name, geometry, RAYS / 2, |i| bundles.next(i), oracle);
    }
}

/// Rays from inside closed meshes must hit them. One mesh is regular, the other has thin and tiny
/// triangles. Rays come singly and in bundles, and are also aimed at vertices and edges.
#[test]
fn no_ray_escapes_a_closed_mesh() {
    let scene = ptfast::Scene::load("mesh:1").unwrap();
    // All triangles except the floor: one icosphere.
    let regular = scene.geometry().triangles.iter().take(20_480).collect::<Vec<_>>();
    let middle =
        regular.iter().fold(Vec3::ZERO, |sum, t| sum + t.vertices[0]) / regular.len() as f32;
    // Move each vertex at random, equally in all triangles that share it, and scale the axes
    // unequally.
    let pushed = |vertex: Vec3| {
        let words = vertex.to_array().map(|x| u64::from(x.to_bits()));
        let mut random =
            Stream::new(words[0] ^ words[1].rotate_left(20) ^ words[2].rotate_left(40));
        let away = (vertex - middle) * random.between(0.8, 1.25);
        middle + away * Vec3::new(1.0, 0.7, 1.9)
    };
    let irregular = regular.iter().map(|t| Triangle { vertices: t.vertices.map(pushed) }).collect();
    for (name, triangles) in [("regular", regular), ("irregular", irregular)] {
        escapes(
            name,
            Geometry { triangles: triangles.into_iter().collect(), ..Geometry::default() },
            middle,
        );
    }
}

fn escapes(name: &str, geometry: Geometry, middle: Vec3) {
    let accelerator = Accelerator::new(geometry.clone());
    let mut random = Stream::new(31);
    let (mut origin, mut target) = (middle, middle);
    let make = |i: usize| {
        // Bundles alternate with independent rays.
        let bundled = (i / Bundles::SIZE).is_multiple_of(2);
        if !bundled || i.is_multiple_of(Bundles::SIZE) {
            origin = middle + vector(&mut random, 0.2);
            let [a, b, c] = geometry.triangles.vertices((random.bits() % 20_480) as usize);
            target = match i / Bundles::SIZE % 3 {
                0 => a,
                1 => b + (c - b) * random.uniform(),
                _ => middle + vector(&mut random, 1.0),
            };
        }
        let wide = bundled && !i.is_multiple_of(4);
        let beside = vector(&mut random, if wide { 0.01 } else { 0.0 });
        let direction = target + beside - origin;
        (Ray { origin, direction, time: 0.0 }, f32::INFINITY)
    };
    rounds(RAYS, make).for_each(|rays| {
        let mut batch = RayBatch::default();
        rays.iter().for_each(|(ray, t_max)| batch.push(ray, 0.0, *t_max));
        for kernel in Kernel::ALL {
            // `flat` takes too long for all rays.
            let share = if kernel == Kernel::Flat { ROUND / 100 } else { ROUND };
            let each = 0..batch.len().min(share);
            let (mut closest, mut any) =
                (HitBatch::misses(batch.len()), HitBatch::misses(batch.len()));
            accelerator.closest(kernel, &batch, each.clone(), &mut closest);
            accelerator.occluded(kernel, &batch, each.clone(), &mut any);
            for hits in [closest, any] {
                let escaped = each.clone().find(|&i| hits.get(i).is_none());
                let told = escaped.map(|i| batch.get(i));
                assert_eq!(escaped, None, "{name}, {kernel:?}: {told:?}");
            }
        }
    });
}
