//! Every kernel finds what trying every primitive finds: same primitive, same distance bits.
//!
//! With the feature `slow-tests` over ten million rays of each kind, else over a share.

mod check;
mod rays;

use glam::Vec3;
use ptfast::accel::{Accelerator, Bvh2, HitBatch, Kernel, RayBatch};
use ptfast::geometry::{Geometry, Hit, Quad, Ray, Sphere, Triangle};
use ptfast::math::random::Stream;
use ptfast::math::warp::uniform_sphere;

use check::{RAYS, ROUND, bits, check, check_kernels};
use rays::{Bundles, adversarial, soup, vector};

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
        check(&format!("soup {seed}"), &geometry, RAYS, scale, shift);
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
        check(name, scene.geometry(), RAYS, scale, shift);
    }
}

#[test]
fn odd_geometry() {
    let ray = Ray { origin: Vec3::ZERO, direction: Vec3::Z, time: 0.0 };
    let empty = Geometry::default();
    let tree = Bvh2::new(&empty, (0.0, 0.0));
    assert_eq!(tree.closest(&empty, &ray, 0.0, f32::INFINITY), None);
    assert!(!tree.occluded(&empty, &ray, 0.0, f32::INFINITY));

    let sphere = Sphere::still(Vec3::Z * 5.0, 1.0);
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

/// The numbers that say where on a thin quad a ray is are off by the more roundings the thinner it
/// is, so rays hit a little beyond its tips, outside its box. The slack is for the worst case: what
/// this finds is one that is smaller than a roundoff; 32 without the condition pass 10^7 rays.
#[test]
fn tips_of_thin_quads() {
    let mut random = Stream::new(21);
    for _ in 0..100 {
        // Alone of its kind, a quad has a box of its own.
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
        let oracle = |ray: &Ray, t_max| geometry.closest_by_brute_force(ray, 0.0, t_max);
        check_kernels("thin quads", &geometry, RAYS / 50, make, oracle);
    }
}

/// Rows and grids of equal primitives tie in every comparison of the builder; primitives in
/// geometric progression make the deepest trees. Both in one test's patience.
#[test]
fn regular_and_deep_geometry() {
    let sphere = Sphere::still;
    let row = (0..100_000u32).map(|i| sphere(Vec3::X * i as f32, 0.4)).collect();
    let grid =
        (0..90_000u32).map(|i| sphere(Vec3::new((i % 300) as f32, (i / 300) as f32, 0.0), 0.4));
    let powers = (-600..210i32).map(|k| {
        let x = (0..k.abs()).fold(1.0, |x: f32, _| if k < 0 { x / 1.1 } else { x * 1.1 });
        sphere(Vec3::X * x, 0.04 * x)
    });
    for (spheres, first) in [(row, 0), (grid.collect::<Vec<_>>(), 0), (powers.collect(), 0)] {
        let geometry = Geometry { spheres, ..Geometry::default() };
        let accelerator = Accelerator::new(&geometry, (0.0, 0.0));
        let ray = Ray { origin: Vec3::X * -10.0, direction: Vec3::X, time: 0.0 };
        let mut batch = RayBatch::default();
        batch.push(&ray, 0.0, f32::INFINITY);
        batch.push(&ray, 0.0, 9.5);
        for kernel in Kernel::ALL {
            let (mut closest, mut any) = (HitBatch::misses(2), HitBatch::misses(2));
            accelerator.closest(kernel, &batch, 0..2, &mut closest);
            accelerator.occluded(kernel, &batch, 0..2, &mut any);
            let told = [closest.primitive[0], closest.primitive[1], any.primitive[1]];
            assert_eq!(told, [first, HitBatch::MISS, HitBatch::MISS], "{kernel:?}");
        }
    }
}

#[test]
fn rays_that_are_no_rays_end_quickly_as_misses() {
    let geometry = soup(7, 300, 1.0, Vec3::ZERO);
    let tree = Bvh2::new(&geometry, (0.0, 1.0));
    let mut batch = RayBatch::default();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        batch.push(&Ray { origin: Vec3::ONE, direction: Vec3::NEG_ONE, time: bad }, 0.0, 9.0);
        for (origin, direction) in [
            (Vec3::splat(bad), Vec3::Z),
            (Vec3::ZERO, Vec3::new(0.0, bad, 0.0)),
            (Vec3::new(0.0, bad, 0.0), Vec3::ONE),
        ] {
            let ray = Ray { origin, direction, time: 0.0 };
            batch.push(&ray, 0.0, f32::INFINITY);
            assert_eq!(tree.closest(&geometry, &ray, 0.0, f32::INFINITY), None, "{ray:?}");
            assert_eq!(geometry.closest_by_brute_force(&ray, 0.0, f32::INFINITY), None, "{ray:?}");
        }
    }
    let still = Ray { origin: Vec3::ZERO, direction: Vec3::ZERO, time: 0.0 };
    assert_eq!(tree.closest(&geometry, &still, 0.0, f32::INFINITY), None);
    assert_eq!(geometry.closest_by_brute_force(&still, 0.0, f32::INFINITY), None);
    batch.push(&still, 0.0, f32::INFINITY);
    let accelerator = Accelerator::new(&geometry, (0.0, 1.0));
    for kernel in Kernel::ALL {
        let mut hits = HitBatch::misses(batch.len());
        let counters = accelerator.count(kernel, false, &batch, 0..batch.len(), &mut hits);
        assert_eq!(hits, HitBatch::misses(batch.len()), "{kernel:?}");
        let left = if kernel == Kernel::Scalar { batch.len() as u64 } else { 0 };
        assert_eq!(counters.scalar_rays, left, "{kernel:?} leaves none of them to the reference");
    }
}

/// Scenes of which brute force takes too long: the oracle is the reference tree, which is
/// itself compared with brute force on some rays of the same scene.
#[test]
fn generated_scenes() {
    for (name, scale) in [("cloud:20000", 30.0), ("mesh:61440", 4.0)] {
        let scene = ptfast::Scene::load(name).unwrap();
        let mut geometry = scene.geometry().clone();
        if name.starts_with("mesh") {
            // Single rays take turns there, and meet blocks of every kind.
            let others = soup(11, 300, 0.5 * scale, Vec3::ZERO);
            geometry.spheres.extend(others.spheres);
            geometry.quads.extend(others.quads);
        }
        let geometry = &geometry;
        let tree = Bvh2::new(geometry, (0.0, 1.0));
        let mut random = Stream::new(17);
        for i in 0..RAYS / 100 {
            let (ray, t_max) = adversarial(&mut random, i, geometry, scale, Vec3::ZERO);
            let want = geometry.closest_by_brute_force(&ray, 0.0, t_max);
            assert_eq!(bits(tree.closest(geometry, &ray, 0.0, t_max)), bits(want), "{ray:?}");
        }
        let make = |i| adversarial(&mut random, i, geometry, scale, Vec3::ZERO);
        let oracle = |ray: &Ray, t_max| tree.closest(geometry, ray, 0.0, t_max);
        check_kernels(name, geometry, RAYS, make, oracle);
        let mut bundles = Bundles::new(18, geometry, scale, Vec3::ZERO);
        check_kernels(name, geometry, RAYS, |i| bundles.next(i), oracle);
    }
}

/// Rays from within a closed mesh, aimed at its vertices and edges as well.
#[test]
fn no_ray_escapes_a_closed_mesh() {
    let scene = ptfast::Scene::load("mesh:1").unwrap();
    // All but the floor: one icosphere.
    let triangles = scene.geometry().triangles[..20_480].to_vec();
    let geometry = Geometry { triangles, ..Geometry::default() };
    let middle = geometry.triangles.iter().fold(Vec3::ZERO, |sum, t| sum + t.vertices[0])
        / geometry.triangles.len() as f32;
    let accelerator = Accelerator::new(&geometry, (0.0, 0.0));
    let mut random = Stream::new(31);
    for _ in (0..RAYS).step_by(ROUND) {
        let mut batch = RayBatch::default();
        for i in 0..ROUND {
            let origin = middle + vector(&mut random, 0.2);
            let [a, b, c] = geometry.triangles[(random.bits() % 20_480) as usize].vertices;
            let target = match i % 3 {
                0 => a,
                1 => b + (c - b) * random.uniform(),
                _ => middle + vector(&mut random, 1.0),
            };
            batch.push(&Ray { origin, direction: target - origin, time: 0.0 }, 0.0, f32::INFINITY);
        }
        for kernel in Kernel::ALL.into_iter().filter(|&kernel| kernel != Kernel::Flat) {
            let mut hits = HitBatch::misses(ROUND);
            accelerator.closest(kernel, &batch, 0..ROUND, &mut hits);
            let escaped = (0..ROUND).find(|&i| hits.get(i).is_none());
            assert_eq!(escaped, None, "{kernel:?}: {:?}", escaped.map(|i| batch.get(i)));
        }
    }
}

/// Rays that hit nothing, rays outside the range and the ends of batches leave hits as they are.
#[test]
fn only_hits_in_the_range_are_written() {
    let geometry = soup(8, 100, 1.0, Vec3::ZERO);
    let accelerator = Accelerator::new(&geometry, (0.0, 1.0));
    let mut random = Stream::new(3);
    let mut batch = RayBatch::default();
    for i in 0..100 {
        let (ray, t_max) = adversarial(&mut random, i, &geometry, 1.0, Vec3::ZERO);
        batch.push(&ray, 0.0, t_max);
    }
    let sentinel = HitBatch { t: vec![-7.0; 100], primitive: vec![12_345; 100] };
    for range in [0..0, 0..1, 3..4, 5..40, 31..64, 99..100, 0..100] {
        for kernel in Kernel::ALL {
            let mut hits = sentinel.clone();
            accelerator.closest(kernel, &batch, range.clone(), &mut hits);
            let mut occluded = sentinel.clone();
            accelerator.occluded(kernel, &batch, range.clone(), &mut occluded);
            for i in 0..100 {
                let (ray, t_min, t_max) = batch.get(i);
                let hit = geometry.closest_by_brute_force(&ray, t_min, t_max);
                let want = hit.filter(|_| range.contains(&i));
                let closest = want.or(sentinel.get(i));
                assert_eq!(bits(hits.get(i)), bits(closest), "{kernel:?}, {range:?}, ray {i}");
                let any = want.map(|_| Hit { t: 0.0, primitive: 0 }).or(sentinel.get(i));
                assert_eq!(bits(occluded.get(i)), bits(any), "{kernel:?}, {range:?}, ray {i}");
            }
        }
    }
}

/// From up to 10^5 times the scene's size away, where boxes that are large enough for rays from
/// near are not: past corners of triangles. Packets of such a ray and others, which hide what it
/// misses, and of its like alone.
#[test]
fn rays_from_far_away() {
    let mut random = Stream::new(6);
    // A leaf each, the triangle's corners being the box's.
    let triangles = (0..20).flat_map(|_| {
        let corner = vector(&mut random, 1.0);
        let edges = [Vec3::ZERO, Vec3::X, Vec3::Y + Vec3::Z];
        [Triangle { vertices: edges.map(|edge| corner + edge * 0.05) }; 8]
    });
    let geometry = Geometry { triangles: triangles.collect(), ..Geometry::default() };
    let mut far = Ray { origin: Vec3::ZERO, direction: Vec3::ZERO, time: 0.0 };
    let make = |i: usize| {
        let bundle = i / Bundles::SIZE;
        if i.is_multiple_of(Bundles::SIZE) {
            let triangle = geometry.triangles[bundle % geometry.triangles.len()];
            let corner = triangle.vertices[bundle / 3 % 3];
            let distance = [30.0, 1e2, 1e3, 1e5][random.bits() as usize % 4];
            let from = uniform_sphere(random.uniform(), random.uniform());
            far.origin = corner + from * (distance * random.between(0.5, 1.0));
            far.direction = (corner - far.origin) * [1.0, 1e-3][bundle % 2];
        }
        match bundle % 3 {
            0 => (far, f32::INFINITY),
            _ if i.is_multiple_of(8) => (far, f32::INFINITY),
            1 => (Ray { direction: Vec3::ZERO, ..far }, f32::INFINITY),
            _ => adversarial(&mut random, i, &geometry, 1.0, Vec3::ZERO),
        }
    };
    let oracle = |ray: &Ray, t_max| geometry.closest_by_brute_force(ray, 0.0, t_max);
    check_kernels("far away", &geometry, 2 * RAYS, make, oracle);
}

/// Directions and origins beyond what the vector box tests can do.
#[test]
fn wild_rays_hit_what_they_should() {
    let geometry = soup(9, 200, 1.0, Vec3::ZERO);
    let mut random = Stream::new(4);
    let make = |i| {
        let (mut ray, t_max) = adversarial(&mut random, i, &geometry, 1.0, Vec3::ZERO);
        match i % 5 {
            0 => ray.direction *= 1e-17,
            1 => ray.direction *= 1e16,
            2 => ray.direction[i / 5 % 3] *= 1e-30,
            3 => ray.origin -= ray.direction.normalize_or(Vec3::X) * 1e11,
            _ => {}
        }
        (ray, t_max)
    };
    let oracle = |ray: &Ray, t_max| geometry.closest_by_brute_force(ray, 0.0, t_max);
    check_kernels("wild", &geometry, RAYS / 10, make, oracle);

    let tame = Ray { origin: Vec3::ZERO, direction: Vec3::Z, time: 0.0 };
    let mut batch = RayBatch::default();
    for ray in [
        tame,
        Ray { direction: Vec3::Z * 1e16, ..tame },
        Ray { direction: Vec3::Z * 1e-16, ..tame },
        Ray { origin: Vec3::Y * 1e11, ..tame },
        Ray { time: -1e11, ..tame },
    ] {
        batch.push(&ray, 0.0, f32::INFINITY);
    }
    // What spans the scene counts too.
    let mut huge = geometry.clone();
    huge.spheres.push(Sphere::still(Vec3::X * 1e12, 1e12));
    for (geometry, wild) in [(&geometry, 4), (&huge, 5), (&soup(9, 20, 1e12, Vec3::ZERO), 5)] {
        let accelerator = Accelerator::new(geometry, (0.0, 1.0));
        for kernel in Kernel::ALL {
            let mut hits = HitBatch::misses(batch.len());
            let counters = accelerator.count(kernel, false, &batch, 0..batch.len(), &mut hits);
            let left = if kernel == Kernel::Scalar { batch.len() as u64 } else { wild };
            assert_eq!(counters.scalar_rays, left, "{kernel:?}");
        }
    }
}

/// A million equal spheres, one primitive, none: no kernel hangs or fails.
#[test]
fn kernels_on_odd_geometry() {
    let sphere = Sphere::still(Vec3::Z * 5.0, 1.0);
    let ray = Ray { origin: Vec3::ZERO, direction: Vec3::Z, time: 0.0 };
    let mut batch = RayBatch::default();
    batch.push(&ray, 0.0, f32::INFINITY);
    batch.push(&Ray { direction: Vec3::NEG_Z, ..ray }, 0.0, f32::INFINITY);
    batch.push(&Ray { direction: Vec3::ZERO, ..ray }, 0.0, f32::INFINITY);
    for count in [0, 1, 1_000_000] {
        let geometry = Geometry { spheres: vec![sphere; count], ..Geometry::default() };
        let accelerator = Accelerator::new(&geometry, (0.0, 0.0));
        for kernel in Kernel::ALL {
            let mut hits = HitBatch::misses(3);
            accelerator.closest(kernel, &batch, 0..3, &mut hits);
            let first = (count > 0).then_some(Hit { t: 4.0, primitive: 0 });
            assert_eq!([hits.get(0), hits.get(1), hits.get(2)], [first, None, None], "{kernel:?}");
        }
    }
}

/// A hit at the very end of the interval does not count, one just before it does.
#[test]
fn intervals_are_open() {
    let geometry = soup(10, 60, 1.0, Vec3::ZERO);
    let mut random = Stream::new(5);
    let closest = |ray: &Ray, t_min, t_max| geometry.closest_by_brute_force(ray, t_min, t_max);
    let (mut batch, mut want) = (RayBatch::default(), HitBatch::default());
    while batch.len() < 20_000 {
        let (ray, _) = adversarial(&mut random, batch.len(), &geometry, 1.0, Vec3::ZERO);
        let Some(Hit { t, .. }) = closest(&ray, 0.0, f32::INFINITY) else { continue };
        for (t_min, t_max) in [(0.0, t), (0.0, t.next_up()), (t, f32::INFINITY), (t, t)] {
            batch.push(&ray, t_min, t_max);
            want.push(closest(&ray, t_min, t_max));
        }
    }
    let accelerator = Accelerator::new(&geometry, (0.0, 1.0));
    for kernel in Kernel::ALL {
        let mut hits = HitBatch::misses(batch.len());
        accelerator.closest(kernel, &batch, 0..batch.len(), &mut hits);
        for i in 0..batch.len() {
            assert_eq!(bits(hits.get(i)), bits(want.get(i)), "{kernel:?} {:?}", batch.get(i));
        }
    }
}

/// A primitive that spans the scene, and one other: a tree of one leaf.
#[test]
fn one_primitive_beside_one_that_spans_the_scene() {
    let ground = Sphere::still(Vec3::Y * -1000.0, 1000.0);
    let vertices = [Vec3::Y, Vec3::Y + Vec3::X * 0.1, Vec3::Y + Vec3::Z * 0.1];
    let small = [
        Geometry { spheres: vec![ground, Sphere::still(Vec3::Y, 0.1)], ..Geometry::default() },
        Geometry {
            spheres: vec![ground],
            quads: vec![Quad::new(Vec3::Y, Vec3::X * 0.1, Vec3::Z * 0.1).unwrap()],
            ..Geometry::default()
        },
        Geometry {
            spheres: vec![ground],
            triangles: vec![Triangle { vertices }],
            ..Geometry::default()
        },
    ];
    for geometry in &small {
        check("one", geometry, 20_000, 1.0, Vec3::Y);
    }
}
