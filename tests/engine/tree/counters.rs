//! Tests of the work counters, on scenes whose work is known in advance or must add up.

use glam::Vec3;
use ptfast::Kernel;
use ptfast::internals::{
    Accelerator, Counters, Geometry, HitBatch, Instance, Quad, Ray, RayBatch, Sphere, Stream,
    Triangle, Triangles,
};

use super::rays::{adversarial, soup};

fn batch(geometry: &Geometry, rays: usize) -> RayBatch {
    let mut random = Stream::new(41);
    let mut batch = RayBatch::default();
    for i in 0..rays {
        let (mut ray, _) = adversarial(&mut random, i, geometry, 1.0, Vec3::ZERO);
        if ray.direction == Vec3::ZERO {
            ray.direction = Vec3::Z;
        }
        batch.push(&ray, 0.0, f32::INFINITY);
    }
    batch
}

/// `flat` tests every ray against every primitive, whether or not the ray hits something.
#[test]
fn flat_tests_everything() {
    let mut geometry = soup(42, 50, 1.0, Vec3::ZERO);
    // Triangles are tested separately for each axis.
    geometry.triangles = Triangles::default();
    let accelerator = Accelerator::new(geometry.clone());
    for rays in [1, 7, 16, 33, 1000] {
        let batch = batch(&geometry, rays);
        let mut hits = HitBatch::misses(rays);
        let count = accelerator.count(Kernel::Flat, false, &batch, 0..rays, &mut hits);
        let primitives = geometry.len() as u64;
        assert_eq!(count.lanes_active, rays as u64 * primitives);
        assert_eq!((count.node_visits, count.scalar_rays), (0, 0));
        // Lanes are issued in whole packets of one or more vectors.
        let vectors = count.leaf_tests / primitives;
        assert_eq!(count.leaf_tests, vectors * primitives);
        let lanes = count.lanes_issued / count.leaf_tests;
        assert_eq!(count.lanes_issued, lanes * count.leaf_tests);
        assert!([8, 16].contains(&lanes), "{lanes} lanes");
        assert!(vectors * lanes >= rays as u64 && vectors * lanes < rays as u64 + 32, "{vectors}");
    }
}

/// Triangle tests run once per axis direction: once for a vector of rays along one direction, six
/// times for a vector with all six directions.
#[test]
fn triangles_are_tested_for_each_axis() {
    let vertices = [Vec3::ZERO, Vec3::X + Vec3::Y, Vec3::Y + Vec3::Z];
    let geometry = Geometry {
        triangles: Triangles::from_iter([Triangle { vertices }]),
        ..Geometry::default()
    };
    let accelerator = Accelerator::new(geometry.clone());
    let count = |ways: usize, rays: usize| {
        let mut batch = RayBatch::default();
        for i in 0..rays {
            let way = i % ways;
            let direction = Vec3::AXES[way % 3] * if way < 3 { 1.0 } else { -1.0 };
            batch.push(&Ray { origin: Vec3::ZERO, direction, time: 0.0 }, 0.0, f32::INFINITY);
        }
        let mut hits = HitBatch::misses(rays);
        accelerator.count(Kernel::Flat, false, &batch, 0..rays, &mut hits)
    };
    for ways in [1, 2, 6] {
        let counters = count(ways, 96);
        let lanes = counters.lanes_issued / counters.leaf_tests;
        assert!([8, 16].contains(&lanes), "{lanes} lanes");
        assert_eq!(counters.leaf_tests, ways as u64 * 96 / lanes, "{ways} ways");
        assert_eq!(counters.lanes_active, 96, "{ways} ways");
    }
}

/// The work of a batch is the sum of the work of its rays, except that the closest hits of a stream
/// are searched in one order for all its rays, which is not quite the best for each of them.
#[test]
fn work_adds_up() {
    let rays = 500;
    for primitives in [1, 50, 3000] {
        let geometry = soup(43, primitives, 1.0, Vec3::ZERO);
        let accelerator = Accelerator::new(geometry.clone());
        let batch = batch(&geometry, rays);
        for (kernel, any) in [
            (Kernel::Stream, false),
            (Kernel::Stream, true),
            (Kernel::Scalar, false),
            (Kernel::Scalar, true),
        ] {
            let count = |range| {
                let mut hits = HitBatch::misses(rays);
                accelerator.count(kernel, any, &batch, range, &mut hits)
            };
            let each: Vec<Counters> = (0..rays).map(|i| count(i..i + 1)).collect();
            let sum = |of: fn(&Counters) -> u64| each.iter().map(of).sum::<u64>();
            let all = count(0..rays);
            assert_eq!(all.scalar_rays, sum(|c| c.scalar_rays), "{kernel:?}");
            assert!(all.lanes_active > 0 && all.lanes_active <= all.lanes_issued, "{kernel:?}");
            if kernel == Kernel::Stream && !any {
                let most = |alone: u64| 2 * alone;
                let alone = sum(|c| c.node_visits);
                assert!(all.node_visits <= most(alone), "{} {alone}", all.node_visits);
                let alone = sum(|c| c.leaf_tests);
                assert!(all.leaf_tests <= most(alone), "{} {alone}", all.leaf_tests);
                continue;
            }
            assert_eq!(all.node_visits, sum(|c| c.node_visits), "{kernel:?}");
            assert_eq!(all.lanes_active, sum(|c| c.lanes_active), "{kernel:?}");
            // Primitives that span the scene are tested against whole vectors of rays, so a batch
            // needs fewer tests of them than its rays need one by one.
            assert!(all.leaf_tests <= sum(|c| c.leaf_tests), "{kernel:?}");
        }
    }
}

/// Rays at a sphere, with a quad far away in another leaf: each ray visits one node and one leaf.
#[test]
fn a_node_and_a_leaf() {
    let quad = Quad::new(Vec3::splat(10.0), Vec3::X, Vec3::Y).unwrap();
    let spheres = vec![Sphere::still(Vec3::ZERO, 0.5)];
    let geometry = Geometry { spheres, quads: vec![quad], ..Geometry::default() };
    let accelerator = Accelerator::new(geometry.clone());
    let mut batch = RayBatch::default();
    for i in 0..64 {
        let origin = Vec3::new(0.001 * i as f32, 0.0, -5.0);
        batch.push(&Ray { origin, direction: Vec3::Z, time: 0.0 }, 0.0, f32::INFINITY);
    }
    let count = |kernel| {
        let mut hits = HitBatch::misses(64);
        let count = accelerator.count(kernel, false, &batch, 0..64, &mut hits);
        assert_eq!(hits.primitive, [0; 64]);
        count
    };
    for kernel in [Kernel::Packet, Kernel::Scalar] {
        let count = count(kernel);
        // Each ray is tested against two boxes, enters one, and is tested against its primitive.
        assert_eq!((count.lanes_issued, count.lanes_active), (64 * 3, 128), "{kernel:?}");
        assert!((1..=64).contains(&count.node_visits), "{kernel:?}: {}", count.node_visits);
    }
    assert_eq!(count(Kernel::Scalar).node_visits, 64);
    let stream = count(Kernel::Stream);
    assert_eq!((stream.node_visits, stream.leaf_tests), (64, 64));
    // The ray enters one of many children, whose block holds one primitive.
    assert_eq!(stream.lanes_active, 128);
    let beam = count(Kernel::Beam);
    assert_eq!(beam.node_visits, 1, "one beam");
    // The beam enters one of many children and one of many primitive boxes. Then each ray is
    // tested.
    assert_eq!(beam.lanes_active, 1 + 1 + 64);
    let boxes = beam.lanes_issued - 64;
    assert!([2 * 8, 2 * 16].contains(&boxes), "{boxes} lanes of boxes");
}

/// Rays at an instance of a triangle: each visits a node and a leaf on both levels.
#[test]
fn both_levels_of_instances_are_counted() {
    let vertices = [Vec3::new(-1.0, -1.0, 0.0), Vec3::X * 2.0, Vec3::Y * 2.0];
    let mut geometry = Geometry::default();
    geometry.instances.add_mesh([Triangle { vertices }].into_iter().collect());
    let matrix = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 3.0]];
    geometry.instances.push(Instance::new(0, &matrix).unwrap());
    let accelerator = Accelerator::new(geometry);
    let mut batch = RayBatch::default();
    for i in 0..64 {
        let origin = Vec3::new(0.001 * i as f32, 0.0, -5.0);
        batch.push(&Ray { origin, direction: Vec3::Z, time: 0.0 }, 0.0, f32::INFINITY);
    }
    for (kernel, nodes) in [(Kernel::Stream, 2 * 64), (Kernel::Scalar, 0)] {
        for any in [false, true] {
            let mut hits = HitBatch::misses(64);
            let count = accelerator.count(kernel, any, &batch, 0..64, &mut hits);
            assert_eq!((count.node_visits, count.leaf_tests), (nodes, 2 * 64), "{kernel:?}");
        }
    }
}

/// In a large tree, the work of a beam is limited, and diverging rays are a stream from the start.
#[test]
fn wide_beams_do_limited_work() {
    let scene = ptfast::Scene::load("mesh:61440").unwrap();
    let accelerator = Accelerator::new(scene.geometry().clone());
    // All rays are in one octant. In the first round their spread shows that they are incoherent. In the
    // second only the work of their beam does: without a limit, it was 740 times that of a stream.
    for (least, reach, most) in [(0.01, 2.0, 2), (0.95, 1.0, 20)] {
        let mut random = Stream::new(44);
        let mut batch = RayBatch::default();
        for _ in 0..640 {
            let mut point = |low: f32, high: f32| {
                glam::Vec3::from_array([(); 3].map(|()| random.between(low, high)))
            };
            let ray = Ray { origin: point(-reach, reach), direction: point(least, 1.0), time: 0.0 };
            batch.push(&ray, 0.0, f32::INFINITY);
        }
        let count = |kernel| {
            let mut hits = HitBatch::misses(640);
            accelerator.count(kernel, false, &batch, 0..640, &mut hits).lanes_issued
        };
        let (beam, stream) = (count(Kernel::Beam), count(Kernel::Stream));
        assert!(beam < most * stream, "{beam} lanes as a beam, {stream} lanes as a stream");
    }
}
