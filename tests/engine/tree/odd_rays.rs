//! Tests of invalid rays, and of rays with extreme origins, directions and intervals.

use glam::Vec3;
use ptfast::Kernel;
use ptfast::internals::{
    Accelerator, Bvh2, Geometry, Hit, HitBatch, Ray, RayBatch, Sphere, Stream, Triangle,
    uniform_sphere,
};

use super::check::{RAYS, bits, check_kernels};
use super::rays::{Bundles, adversarial, soup, vector};

#[test]
fn invalid_rays_miss_quickly() {
    let geometry = soup(7, 300, 1.0, Vec3::ZERO);
    let tree = Bvh2::new(&geometry, 1);
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
    let accelerator = Accelerator::new(geometry.clone());
    for (kernel, any) in
        Kernel::ALL.into_iter().flat_map(|kernel| [(kernel, false), (kernel, true)])
    {
        let mut hits = HitBatch::misses(batch.len());
        let counters = accelerator.count(kernel, any, &batch, 0..batch.len(), &mut hits);
        let steps = counters.node_visits + counters.leaf_tests;
        assert!(steps < 2 * batch.len() as u64, "{kernel:?}, {any}: {steps} steps");
        assert_eq!(hits, HitBatch::misses(batch.len()), "{kernel:?}");
        let left = if kernel == Kernel::Scalar { batch.len() as u64 } else { 0 };
        assert_eq!(
            counters.scalar_rays, left,
            "{kernel:?} must not hand these rays to the reference"
        );
    }
}

/// Kernels write only the hits of rays whose index is in the range. The entries of misses, and of
/// rays outside the range, are left unchanged.
#[test]
fn only_hits_in_the_range_are_written() {
    let geometry = soup(8, 100, 1.0, Vec3::ZERO);
    let accelerator = Accelerator::new(geometry.clone());
    let mut random = Stream::new(3);
    let mut batch = RayBatch::default();
    for i in 0..100 {
        let (ray, t_max) = adversarial(&mut random, i, &geometry, 1.0, Vec3::ZERO);
        batch.push(&ray, 0.0, t_max);
    }
    let sentinel =
        HitBatch { t: vec![-7.0; 100], primitive: vec![12_345; 100], instance: vec![0; 100] };
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
                let any = want.map(|_| Hit::of(0, 0.0)).or(sentinel.get(i));
                assert_eq!(bits(occluded.get(i)), bits(any), "{kernel:?}, {range:?}, ray {i}");
            }
        }
    }
}

/// Rays past corners of triangles, from up to 10^5 times the scene's size away. The padding of
/// boxes that suffices for near rays is too small for these. Some packets contain only such rays;
/// others mix them with invalid or with near rays. A near ray may enter a box that a far ray
/// wrongly misses, and so hide the fault.
#[test]
fn rays_from_far_away() {
    let mut random = Stream::new(6);
    // Each leaf holds equal triangles whose corners are corners of the leaf's box.
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
            let vertices = geometry.triangles.vertices(bundle % geometry.triangles.len());
            let corner = vertices[bundle / 3 % 3];
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
    let oracle = |ray: &Ray, t_min, t_max| geometry.closest_by_brute_force(ray, t_min, t_max);
    check_kernels("far away", &geometry, RAYS, make, oracle);
}

/// Rays with directions and origins outside the range of the vector box tests.
#[test]
fn wild_rays_find_the_right_hits() {
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
    let oracle = |ray: &Ray, t_min, t_max| geometry.closest_by_brute_force(ray, t_min, t_max);
    check_kernels("wild", &geometry, RAYS, make, oracle);

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
    // A huge primitive makes all rays wild, even if it spans the scene and thus is in no tree.
    let mut huge = geometry.clone();
    huge.spheres.push(Sphere::still(Vec3::X * 1e12, 1e12));
    for (geometry, wild) in [(&geometry, 4), (&huge, 5), (&soup(9, 20, 1e12, Vec3::ZERO), 5)] {
        let accelerator = Accelerator::new(geometry.clone());
        for kernel in Kernel::ALL {
            let mut hits = HitBatch::misses(batch.len());
            let counters = accelerator.count(kernel, false, &batch, 0..batch.len(), &mut hits);
            let left = if kernel == Kernel::Scalar { batch.len() as u64 } else { wild };
            assert_eq!(counters.scalar_rays, left, "{kernel:?}");
        }
    }
}

/// Intervals are open: a hit exactly at an end does not count, a hit just inside does.
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
    let accelerator = Accelerator::new(geometry.clone());
    for kernel in Kernel::ALL {
        let (mut hits, mut any) = (HitBatch::misses(batch.len()), HitBatch::misses(batch.len()));
        accelerator.closest(kernel, &batch, 0..batch.len(), &mut hits);
        accelerator.occluded(kernel, &batch, 0..batch.len(), &mut any);
        for i in 0..batch.len() {
            assert_eq!(bits(hits.get(i)), bits(want.get(i)), "{kernel:?} {:?}", batch.get(i));
            assert_eq!(
                any.get(i).is_some(),
                want.get(i).is_some(),
                "{kernel:?} {:?}",
                batch.get(i)
            );
        }
    }
}
