//! The tree finds what trying every primitive finds: same primitive, same distance bits.

use glam::Vec3;
use ptfast::accel::Bvh2;
use ptfast::geometry::{Geometry, Quad, Ray, Sphere, Triangle};
use ptfast::math::random::Stream;
use ptfast::math::warp::uniform_sphere;
use ptfast::math::{cross, normalize};

fn vector(random: &mut Stream, size: f32) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| random.between(-size, size)))
}

/// Spheres (some moving), quads and meshes of triangles that share edges, in a box of side
/// `2 scale` about `shift`; some of the primitives are there twice.
fn soup(seed: u64, primitives: usize, scale: f32, shift: Vec3) -> Geometry {
    let mut random = Stream::new(seed);
    let mut geometry = Geometry::default();
    while geometry.len() < primitives {
        let center = shift + vector(&mut random, scale);
        let again = random.uniform() < 0.1;
        let kind = random.uniform();
        {
            if kind < 0.4 {
                let motion = if kind < 0.1 { vector(&mut random, 0.2 * scale) } else { Vec3::ZERO };
                let radius = scale * random.between(0.01, 0.2);
                geometry.spheres.push(Sphere { center, motion, radius });
            } else if kind < 0.7 {
                let u = vector(&mut random, 0.3 * scale);
                // Some thin to the limit of what is allowed.
                let thin = if kind < 0.5 { 0.02 } else { 1.0 };
                let v = u * (1.0 - thin) + vector(&mut random, 0.3 * scale) * thin;
                geometry.quads.extend(Quad::new(center, u, v));
            } else {
                // A fan about `center`: neighbours share edges and all share a vertex.
                let rim: Vec<Vec3> =
                    (0..6).map(|_| center + vector(&mut random, 0.3 * scale)).collect();
                for i in 0..6 {
                    let vertices = [center, rim[i], rim[(i + 1) % 6]];
                    geometry.triangles.push(Triangle { vertices });
                }
            }
        }
        if again {
            // Coincident to the bit: the tie goes to the lower index.
            let Geometry { spheres, quads, triangles } = &mut geometry;
            spheres.extend_from_within(spheres.len().saturating_sub(1)..);
            quads.extend_from_within(quads.len().saturating_sub(1)..);
            triangles.extend_from_within(triangles.len().saturating_sub(3)..);
        }
    }
    geometry
}

/// A point that rays are aimed at: somewhere, or a vertex, an edge, a silhouette.
fn target(random: &mut Stream, geometry: &Geometry, origin: Vec3, scale: f32, shift: Vec3) -> Vec3 {
    let pick = |random: &mut Stream, n: usize| (random.bits() % n as u64) as usize;
    match pick(random, 6) {
        0 if !geometry.triangles.is_empty() => {
            let [a, b, c] = geometry.triangles[pick(random, geometry.triangles.len())].vertices;
            let t = random.uniform();
            match pick(random, 3) {
                0 => a,
                1 => a * (1.0 - t) + b * t,
                _ => b * (1.0 - t) + c * t,
            }
        }
        1 if !geometry.quads.is_empty() => {
            let quad = geometry.quads[pick(random, geometry.quads.len())];
            quad.q + quad.u * random.uniform() + quad.v * (pick(random, 2) as f32)
        }
        2 if !geometry.spheres.is_empty() => {
            let sphere = geometry.spheres[pick(random, geometry.spheres.len())];
            let to = sphere.center - origin;
            let side = normalize(cross(to, vector(random, 1.0)));
            sphere.center + side * sphere.radius
        }
        _ => shift + vector(random, scale),
    }
}

fn check(name: &str, geometry: &Geometry, rays: usize, scale: f32, shift: Vec3) {
    let tree = Bvh2::new(geometry, (0.0, 1.0));
    let mut random = Stream::new(99);
    let mut hits = 0;
    for i in 0..rays {
        let mut origin = match i % 3 {
            0 => shift + uniform_sphere(random.uniform(), random.uniform()) * (scale * 4.0),
            1 => shift + vector(&mut random, scale),
            _ => target(&mut random, geometry, shift, scale, shift),
        };
        let mut direction = target(&mut random, geometry, origin, scale, shift) - origin;
        match i % 11 {
            0 => direction *= 1e-6,
            1 => direction *= 1e6,
            2 => direction[i % 3] = 0.0,
            3 => direction[i % 3] = -0.0,
            4 => {
                let axis = i % 3;
                direction = Vec3::ZERO;
                direction[axis] = if i % 2 == 0 { 1.0 } else { -1.0 };
                // In the very plane of some box face.
                if let Some(sphere) = geometry.spheres.first() {
                    let other = (axis + 1) % 3;
                    origin[other] = sphere.center[other] + sphere.radius;
                }
            }
            _ => {}
        }
        if i % 13 == 0 && !geometry.triangles.is_empty() {
            // In the plane of a triangle, or along one of its edges.
            let triangle = geometry.triangles[i / 13 % geometry.triangles.len()];
            let [a, b, c] = triangle.vertices;
            let at = |s: f32, t: f32| a + (b - a) * s + (c - a) * t;
            origin = at(random.between(-2.0, 3.0), random.between(-2.0, 3.0));
            direction = at(random.uniform(), random.uniform() * 0.5) - origin;
        }
        if i % 17 == 0 && !geometry.quads.is_empty() {
            // Past a corner of a quad, from in front of it.
            let quad = geometry.quads[i / 17 % geometry.quads.len()];
            let corner = quad.q + (quad.u + quad.v) * random.between(0.999_999, 1.000_001);
            origin = corner + quad.normal * scale + vector(&mut random, scale);
            direction = corner - origin;
        }
        let ray = Ray { origin, direction, time: random.uniform() };
        let t_max = if i % 7 == 0 { random.uniform() } else { f32::INFINITY };
        let want = geometry.closest_by_brute_force(&ray, 0.0, t_max);
        let got = tree.closest(geometry, &ray, 0.0, t_max);
        assert_eq!(
            got.map(|hit| (hit.primitive, hit.t.to_bits())),
            want.map(|hit| (hit.primitive, hit.t.to_bits())),
            "{name}: {ray:?} {t_max}"
        );
        assert_eq!(tree.occluded(geometry, &ray, 0.0, t_max), want.is_some(), "{name}: {ray:?}");
        hits += usize::from(want.is_some());
    }
    assert!(hits > rays / 8, "{name}: only {hits} of {rays} rays hit anything");
}

#[test]
fn random_and_adversarial_rays() {
    for (seed, primitives, scale, shift) in [
        (1, 3, 1.0, Vec3::ZERO),
        (2, 60, 1.0, Vec3::ZERO),
        (3, 300, 100.0, Vec3::new(5.0, 3.0, -2.0)),
        (4, 300, 1e-3, Vec3::ZERO),
        (5, 300, 1e5, Vec3::ZERO),
        (6, 300, 1.0, Vec3::new(1000.0, -3000.0, 200.0)),
    ] {
        let geometry = soup(seed, primitives, scale, shift);
        check(&format!("soup {seed}"), &geometry, 60_000, scale, shift);
    }
}

#[test]
fn built_in_scenes() {
    for name in ptfast::scene::BUILTIN_NAMES {
        let scene = ptfast::Scene::load(name).unwrap();
        let (scale, shift) = match name {
            "cornell" => (300.0, Vec3::splat(278.0)),
            _ => (8.0, Vec3::Y),
        };
        check(name, scene.geometry(), 60_000, scale, shift);
    }
}

#[test]
fn odd_geometry() {
    let ray = Ray { origin: Vec3::ZERO, direction: Vec3::Z, time: 0.0 };
    let empty = Geometry::default();
    let tree = Bvh2::new(&empty, (0.0, 0.0));
    assert_eq!(tree.closest(&empty, &ray, 0.0, f32::INFINITY), None);
    assert!(!tree.occluded(&empty, &ray, 0.0, f32::INFINITY));

    let sphere = Sphere { center: Vec3::Z * 5.0, motion: Vec3::ZERO, radius: 1.0 };
    let line = Triangle { vertices: [Vec3::Z, Vec3::Z * 2.0, Vec3::Z * 3.0] };
    let point = Triangle { vertices: [Vec3::Z * 2.0; 3] };
    let same = Geometry {
        spheres: vec![sphere; 100_000],
        quads: Vec::new(),
        triangles: vec![line, point],
    };
    let tree = Bvh2::new(&same, (0.0, 0.0));
    let hit = tree.closest(&same, &ray, 0.0, f32::INFINITY).unwrap();
    assert_eq!((hit.primitive, hit.t), (0, 4.0), "of 100 000 equal spheres the first");
}

/// Small triangles seen from far away, where their coordinates hardly differ in f32.
#[test]
fn triangles_smaller_than_rounding() {
    let mut random = Stream::new(12);
    for (size, distance) in [(1e-3f32, 3e4f32), (2e-3, 1e3), (1.0, 1e6)] {
        let triangles = (0..200).map(|_| {
            let middle = vector(&mut random, 20.0 * size);
            Triangle { vertices: [(); 3].map(|()| middle + vector(&mut random, size)) }
        });
        let geometry = Geometry { triangles: triangles.collect(), ..Geometry::default() };
        let tree = Bvh2::new(&geometry, (0.0, 0.0));
        for _ in 0..20_000 {
            let origin = uniform_sphere(random.uniform(), random.uniform()) * distance;
            let direction = vector(&mut random, 20.0 * size) - origin;
            let ray = Ray { origin, direction, time: 0.0 };
            let want = geometry.closest_by_brute_force(&ray, 0.0, f32::INFINITY);
            assert_eq!(tree.closest(&geometry, &ray, 0.0, f32::INFINITY), want, "{ray:?}");
            // And no hit far beside the triangle.
            if let Some(hit) = want {
                let middle = geometry.triangles[hit.primitive as usize].vertices[0];
                let miss = ray.origin + ray.direction * hit.t - middle;
                assert!(miss.length_squared().sqrt() < 4.0 * size + 1e-5 * distance, "{miss}");
            }
        }
    }
}

/// Rows and grids of equal primitives tie in every comparison of the builder; primitives in
/// geometric progression make the deepest trees. Both in one test's patience.
#[test]
fn regular_and_deep_geometry() {
    let sphere = |center, radius| Sphere { center, motion: Vec3::ZERO, radius };
    let row = (0..100_000u32).map(|i| sphere(Vec3::X * i as f32, 0.4)).collect();
    let grid =
        (0..90_000u32).map(|i| sphere(Vec3::new((i % 300) as f32, (i / 300) as f32, 0.0), 0.4));
    let powers = (-600..210i32).map(|k| {
        let x = (0..k.abs()).fold(1.0, |x: f32, _| if k < 0 { x / 1.1 } else { x * 1.1 });
        sphere(Vec3::X * x, 0.04 * x)
    });
    for (spheres, first) in [(row, 0), (grid.collect::<Vec<_>>(), 0), (powers.collect(), 0)] {
        let geometry = Geometry { spheres, ..Geometry::default() };
        let tree = Bvh2::new(&geometry, (0.0, 0.0));
        let ray = Ray { origin: Vec3::X * -10.0, direction: Vec3::X, time: 0.0 };
        let hit = tree.closest(&geometry, &ray, 0.0, f32::INFINITY).unwrap();
        assert_eq!(hit.primitive, first);
        assert!(!tree.occluded(&geometry, &ray, 0.0, 9.5));
    }
}

#[test]
fn rays_that_are_no_rays_end_quickly_as_misses() {
    let geometry = soup(7, 300, 1.0, Vec3::ZERO);
    let tree = Bvh2::new(&geometry, (0.0, 1.0));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for (origin, direction) in [
            (Vec3::splat(bad), Vec3::Z),
            (Vec3::ZERO, Vec3::new(0.0, bad, 0.0)),
            (Vec3::new(0.0, bad, 0.0), Vec3::ONE),
        ] {
            let ray = Ray { origin, direction, time: 0.0 };
            assert_eq!(tree.closest(&geometry, &ray, 0.0, f32::INFINITY), None, "{ray:?}");
            assert_eq!(geometry.closest_by_brute_force(&ray, 0.0, f32::INFINITY), None, "{ray:?}");
        }
    }
    let still = Ray { origin: Vec3::ZERO, direction: Vec3::ZERO, time: 0.0 };
    assert_eq!(tree.closest(&geometry, &still, 0.0, f32::INFINITY), None);
    assert_eq!(geometry.closest_by_brute_force(&still, 0.0, f32::INFINITY), None);
}
