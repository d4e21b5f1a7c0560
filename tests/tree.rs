//! Every kernel finds what trying every primitive finds: same primitive, same distance bits.
//!
//! With the feature `slow-tests` over ten million rays of each kind, else over a share.

use glam::Vec3;
use ptfast::accel::{Accelerator, Bvh2, HitBatch, Kernel, RayBatch};
use ptfast::geometry::{Geometry, Hit, Quad, Ray, Sphere, Triangle};
use ptfast::math::random::Stream;
use ptfast::math::warp::uniform_sphere;
use ptfast::math::{cross, length, normalize};

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
                let center1 = center + motion;
                let radius = scale * random.between(0.01, 0.2);
                geometry.spheres.push(Sphere { center, center1, radius });
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

/// Ray number `i`: aimed at what is hard to hit, from where it is hard, or in a hard direction.
fn adversarial(
    random: &mut Stream,
    i: usize,
    geometry: &Geometry,
    scale: f32,
    shift: Vec3,
) -> (Ray, f32) {
    let mut origin = match i % 3 {
        0 => shift + uniform_sphere(random.uniform(), random.uniform()) * (scale * 4.0),
        1 => shift + vector(random, scale),
        _ => target(random, geometry, shift, scale, shift),
    };
    let mut direction = target(random, geometry, origin, scale, shift) - origin;
    match i % 11 {
        0 => direction *= 1e-6,
        1 => direction *= 1e6,
        2 => direction[i % 3] = 0.0,
        3 => direction[i % 3] = -0.0,
        4 => {
            let axis = i % 3;
            direction = Vec3::ZERO;
            direction[axis] = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
            // In the very plane of some box face.
            if let Some(sphere) = geometry.spheres.first() {
                let other = (axis + 1) % 3;
                origin[other] = sphere.center[other] + sphere.radius;
            }
        }
        _ => {}
    }
    if i.is_multiple_of(13) && !geometry.triangles.is_empty() {
        // In the plane of a triangle, or along one of its edges.
        let triangle = geometry.triangles[i / 13 % geometry.triangles.len()];
        let [a, b, c] = triangle.vertices;
        let at = |s: f32, t: f32| a + (b - a) * s + (c - a) * t;
        origin = at(random.between(-2.0, 3.0), random.between(-2.0, 3.0));
        direction = at(random.uniform(), random.uniform() * 0.5) - origin;
    }
    if i.is_multiple_of(17) && !geometry.quads.is_empty() {
        // Past a corner of a quad, from in front of it.
        let quad = geometry.quads[i / 17 % geometry.quads.len()];
        let corner = quad.q + (quad.u + quad.v) * random.between(0.999_999, 1.000_001);
        origin = corner + quad.normal * scale + vector(random, scale);
        direction = corner - origin;
    }
    let t_max = if i.is_multiple_of(7) { random.uniform() } else { f32::INFINITY };
    (Ray { origin, direction, time: random.uniform() }, t_max)
}

/// Rays of one test.
const RAYS: usize = if cfg!(feature = "slow-tests") { 10_000_000 } else { 60_000 };
/// Rays of one batch.
const ROUND: usize = 20_000;

fn bits(hit: Option<Hit>) -> Option<(u32, u32)> {
    hit.map(|hit| (hit.primitive, hit.t.to_bits()))
}

/// Compares every kernel with `oracle`, over rays that `make` makes.
fn check_kernels(
    name: &str,
    geometry: &Geometry,
    rays: usize,
    mut make: impl FnMut(usize) -> (Ray, f32),
    oracle: impl Fn(&Ray, f32) -> Option<Hit>,
) {
    let accelerator = Accelerator::new(geometry, (0.0, 1.0));
    let kernels: Vec<Kernel> = Kernel::ALL
        .into_iter()
        .filter(|kernel| *kernel != Kernel::Flat || geometry.len() <= 1000)
        .collect();
    let mut hit = 0;
    for first in (0..rays).step_by(ROUND) {
        let (mut batch, mut want) = (RayBatch::default(), HitBatch::default());
        for i in first..rays.min(first + ROUND) {
            let (ray, t_max) = make(i);
            batch.push(&ray, 0.0, t_max);
            want.push(oracle(&ray, t_max));
        }
        let each = 0..batch.len();
        for &kernel in &kernels {
            let (mut closest, mut any) =
                (HitBatch::misses(batch.len()), HitBatch::misses(batch.len()));
            accelerator.closest(kernel, &batch, each.clone(), &mut closest);
            accelerator.occluded(kernel, &batch, each.clone(), &mut any);
            for i in each.clone() {
                let told = || format!("{name}, {kernel:?}: {:?}", batch.get(i));
                assert_eq!(bits(closest.get(i)), bits(want.get(i)), "{}", told());
                let occluded = want.get(i).map(|_| Hit { t: 0.0, primitive: 0 });
                assert_eq!(any.get(i), occluded, "{}", told());
            }
        }
        hit += want.primitive.iter().filter(|p| **p != HitBatch::MISS).count();
    }
    assert!(hit > rays / 20, "{name}: only {hit} of {rays} rays hit anything");
}

/// Rays of which the neighbours are as the kernels for coherent rays want them: bundles of
/// like rays, by turns from one point, and side by side along one of the axes.
struct Bundles<'a> {
    random: Stream,
    geometry: &'a Geometry,
    scale: f32,
    shift: Vec3,
    base: Ray,
}

impl<'a> Bundles<'a> {
    const SIZE: usize = 64;

    fn new(seed: u64, geometry: &'a Geometry, scale: f32, shift: Vec3) -> Self {
        let base = Ray { origin: Vec3::ZERO, direction: Vec3::Z, time: 0.0 };
        Self { random: Stream::new(seed), geometry, scale, shift, base }
    }

    fn next(&mut self, i: usize) -> (Ray, f32) {
        let Self { random, geometry, scale, shift, base } = self;
        let bundle = i / Self::SIZE;
        if i.is_multiple_of(Self::SIZE) {
            *base = adversarial(random, bundle, geometry, *scale, *shift).0;
        }
        let wide = [1e-6, 1e-3, 0.1][bundle % 3];
        let mut ray = *base;
        let length = length(ray.direction);
        if bundle.is_multiple_of(2) {
            // To a target near the first ray's, often the very corner of something.
            let near = target(random, geometry, ray.origin, *scale, *shift) - ray.origin;
            let to = near * (length / (1e-30 + near.length_squared().sqrt()));
            ray.direction += (to - ray.direction) * (wide * random.uniform());
            ray.direction += vector(random, wide * length);
        } else {
            ray.origin += vector(random, wide * *scale);
        }
        ray.time = random.uniform();
        // Among them rays that go along an axis or across it, and some that go nowhere.
        match i {
            // A zero of the other sign makes a packet of mixed octants: in some bundles only.
            i if i.is_multiple_of(19) => {
                let sign = if bundle.is_multiple_of(3) {
                    i as f32 % 2.0 - 0.5
                } else {
                    base.direction[i % 3]
                };
                ray.direction[i % 3] = 0.0f32.copysign(sign);
            }
            i if i.is_multiple_of(23) => ray.direction = Vec3::ZERO,
            i if i.is_multiple_of(29) => ray.origin.y = f32::NAN,
            // Half a packet without rays.
            i if bundle.is_multiple_of(7) && i % Self::SIZE < 20 => ray.direction = Vec3::ZERO,
            _ => {}
        }
        let t_max = match i % 31 {
            0 => f32::NAN,
            1 => 0.0,
            2 => random.uniform(),
            _ => f32::INFINITY,
        };
        (ray, t_max)
    }
}

fn check(name: &str, geometry: &Geometry, rays: usize, scale: f32, shift: Vec3) {
    let mut random = Stream::new(99);
    let make = |i| adversarial(&mut random, i, geometry, scale, shift);
    let oracle = |ray: &Ray, t_max| geometry.closest_by_brute_force(ray, 0.0, t_max);
    check_kernels(name, geometry, rays, make, oracle);
    let mut bundles = Bundles::new(98, geometry, scale, shift);
    check_kernels(name, geometry, rays, |i| bundles.next(i), oracle);
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
    batch.push(&Ray { origin: Vec3::ONE, direction: Vec3::NEG_ONE, time: f32::NAN }, 0.0, 9.0);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
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
        accelerator.closest(kernel, &batch, 0..batch.len(), &mut hits);
        assert_eq!(hits, HitBatch::misses(batch.len()), "{kernel:?}");
    }
}

/// Scenes of which brute force takes too long: the oracle is the reference tree, which is
/// itself compared with brute force on some rays of the same scene.
#[test]
fn generated_scenes() {
    for (name, scale) in [("cloud:20000", 30.0), ("mesh:61440", 4.0)] {
        let scene = ptfast::Scene::load(name).unwrap();
        let geometry = scene.geometry();
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
        for kernel in [Kernel::Packet, Kernel::Beam, Kernel::Single, Kernel::Scalar] {
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
            for i in 0..100 {
                let (ray, t_min, t_max) = batch.get(i);
                let hit = geometry.closest_by_brute_force(&ray, t_min, t_max);
                let want = hit.filter(|_| range.contains(&i)).or(sentinel.get(i));
                assert_eq!(bits(hits.get(i)), bits(want), "{kernel:?}, {range:?}, ray {i}");
            }
        }
    }
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
            _ => {}
        }
        (ray, t_max)
    };
    let oracle = |ray: &Ray, t_max| geometry.closest_by_brute_force(ray, 0.0, t_max);
    check_kernels("wild", &geometry, RAYS / 10, make, oracle);
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
