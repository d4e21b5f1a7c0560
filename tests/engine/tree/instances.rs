//! Tests of kernels and the reference on scenes with instances.

use glam::{Mat3, Vec3};
use ptfast::internals::{
    Bvh2, Geometry, Instance, Quad, Ray, Stream, Triangle, Triangles, cross, normalize,
    uniform_sphere,
};
use rayon::prelude::*;

use super::check::{RAYS, bits, check_kernels};
use super::rays::{Bundles, adversarial, soup, vector};

/// The kinds of matrices.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    /// Rotations.
    Rigid,
    /// Rotations and reflections with a scale for each axis.
    Mirrored,
    /// Arbitrary matrices, some nearly as ill-conditioned as allowed.
    Sheared,
    /// Objects a million times larger or smaller in their own space.
    Scaled,
}

fn rotation(random: &mut Stream) -> Mat3 {
    let x = uniform_sphere(random.uniform(), random.uniform());
    let y = normalize(cross(x, uniform_sphere(random.uniform(), random.uniform())));
    Mat3::from_cols(x, y, cross(x, y))
}

/// A matrix that places a mesh of this size in its own space as one of size `scale`.
fn linear(random: &mut Stream, kind: Kind, scale: f32, size: f32) -> Mat3 {
    let diagonal = |random: &mut Stream, low: f32| {
        let mut sign = || if random.uniform() < 0.5 { -1.0 } else { 1.0 };
        let signs = Vec3::new(sign(), sign(), sign());
        let mut factor = || random.between(low, 1.0);
        Mat3::from_diagonal(signs * Vec3::new(factor(), factor(), factor()))
    };
    let shape = match kind {
        Kind::Rigid | Kind::Scaled => rotation(random),
        Kind::Mirrored => rotation(random) * diagonal(random, 0.2),
        Kind::Sheared => {
            let low = [0.3, 0.05, 0.003][random.bits() as usize % 3];
            rotation(random) * diagonal(random, low) * rotation(random)
        }
    };
    shape * (scale / size)
}

/// A soup with instances of meshes, among them equal ones, and the same triangles in world space,
/// at which rays are aimed.
pub(super) fn instanced(seed: u64, kind: Kind, scale: f32, shift: Vec3) -> (Geometry, Geometry) {
    let mut random = Stream::new(seed);
    let mut geometry = soup(seed, 20, scale, shift);
    let mut placed = geometry.clone();
    let mut meshes = Vec::new();
    for number in 0..4 {
        let size = match kind {
            Kind::Scaled => [1e-6, 1e6, 1.0, 30.0][number],
            _ => 1.0,
        };
        // The mesh may be far from the origin of its space.
        let away = vector(&mut random, [0.0, 3.0][number % 2] * size);
        let mesh = soup(seed + 50 + number as u64, 30 << number, size, away).triangles;
        meshes.push((size, away, mesh.clone()));
        geometry.instances.add_mesh(mesh);
    }
    while geometry.instances.len() < 30 {
        let mesh = random.bits() as usize % meshes.len();
        let (size, away, triangles) = &meshes[mesh];
        let linear = linear(&mut random, kind, 0.3 * scale, *size);
        let center = shift + vector(&mut random, scale) - linear * *away;
        let row = |i: usize| {
            let Vec3 { x, y, z } = linear.row(i);
            [x, y, z, center[i]]
        };
        let Ok(instance) = Instance::new(mesh as u32, &[row(0), row(1), row(2)]) else {
            assert!(matches!(kind, Kind::Sheared), "only these can be ill-conditioned");
            continue;
        };
        geometry.instances.push(instance);
        if random.uniform() < 0.1 {
            // Equal hits must go to the first instance.
            geometry.instances.push(instance);
        }
        let place = |vertex: Vec3| linear * vertex + center;
        let few = triangles.iter().take(20);
        placed.triangles.extend(few.map(|t| Triangle { vertices: t.vertices.map(place) }));
    }
    (geometry, placed)
}

#[test]
fn kernels_agree_with_brute_force_on_instances() {
    for (seed, kind, scale, shift) in [
        (1, Kind::Rigid, 1.0, Vec3::ZERO),
        (2, Kind::Rigid, 1.0, Vec3::new(1000.0, -3000.0, 200.0)),
        (3, Kind::Mirrored, 1.0, Vec3::ZERO),
        (4, Kind::Mirrored, 1e4, Vec3::ZERO),
        (5, Kind::Sheared, 1.0, Vec3::ZERO),
        (6, Kind::Sheared, 1e-3, Vec3::new(0.1, 0.0, 0.0)),
        (7, Kind::Scaled, 1.0, Vec3::ZERO),
        (8, Kind::Scaled, 100.0, Vec3::new(1e4, 0.0, 0.0)),
    ] {
        let (geometry, placed) = instanced(seed, kind, scale, shift);
        let name = format!("{kind:?} instances {seed}");
        let mut random = Stream::new(99);
        let make = |i| adversarial(&mut random, i, &placed, scale, shift);
        let oracle = |ray: &Ray, t_min, t_max| geometry.closest_by_brute_force(ray, t_min, t_max);
        check_kernels(&name, &geometry, RAYS / 4, make, oracle);
        let mut bundles = Bundles::new(98, &placed, scale, shift);
        check_kernels(&name, &geometry, RAYS / 4, |i| bundles.next(i), oracle);
    }
}

#[test]
fn the_reference_agrees_with_brute_force_on_instances() {
    for (seed, kind) in
        [Kind::Rigid, Kind::Mirrored, Kind::Sheared, Kind::Scaled].into_iter().enumerate()
    {
        let (geometry, placed) = instanced(20 + seed as u64, kind, 1.0, Vec3::ZERO);
        let tree = Bvh2::new(&geometry, 1);
        let mut random = Stream::new(7);
        let make = |i| adversarial(&mut random, i, &placed, 1.0, Vec3::ZERO);
        let rays: Vec<_> = (0..20_000).map(make).collect();
        let meets_instance = |&(ray, t_max): &(Ray, f32)| {
            let want = geometry.closest_by_brute_force(&ray, 0.0, t_max);
            let found = tree.closest(&geometry, &ray, 0.0, t_max);
            assert_eq!(bits(found), bits(want), "{kind:?} {ray:?}");
            assert_eq!(tree.occluded(&geometry, &ray, 0.0, t_max), want.is_some());
            want.is_some_and(|hit| hit.primitive >= geometry.len() as u32)
        };
        let instances = rays.par_iter().filter(|ray| meets_instance(ray)).count();
        assert!(instances > 4000, "only {instances} rays hit instances");
    }
}

/// A mesh that is long in its own space. Errors of the ray test along its length are not covered by
/// the slack of world space, but by the boxes of instances.
#[test]
fn flattened_meshes_are_not_skipped() {
    let mut random = Stream::new(3);
    for stretch in [1e2, 1e4, 1e6] {
        let mut geometry = Geometry::default();
        let mut placed = Geometry::default();
        for _ in 0..40 {
            let center = Vec3::new(1.0, 0.0, 0.0) + vector(&mut random, 0.02);
            let mut corner = || vector(&mut random, 1.0);
            // Nearly perpendicular to the x-axis, so that boxes are thin.
            let flat = Vec3::new(1e-3, 1.0, 1.0);
            let vertices = [corner(), corner(), corner()].map(|v| v * flat + center);
            let axis = random.bits() as usize % 2 + 1;
            let mut long = Vec3::ONE;
            long[axis] = stretch;
            let mesh = [Triangle { vertices: vertices.map(|v| v * long) }].into_iter().collect();
            let mesh = geometry.instances.add_mesh(mesh);
            let Vec3 { x, y, z } = 1.0 / long;
            let matrix = [[x, 0.0, 0.0, 0.0], [0.0, y, 0.0, 0.0], [0.0, 0.0, z, 0.0]];
            geometry.instances.push(Instance::new(mesh, &matrix).unwrap());
            placed.triangles.push(Triangle { vertices });
        }
        let make = |_| {
            let origin = vector(&mut random, 0.01);
            let target = placed.triangles.get(random.bits() as usize % 40).unwrap().vertices;
            let (s, t) = (random.uniform(), random.uniform());
            let target = target[0] + (target[1] - target[0]) * s + (target[2] - target[0]) * t;
            (Ray { origin, direction: target - origin, time: 0.0 }, f32::INFINITY)
        };
        let oracle = |ray: &Ray, t_min, t_max| geometry.closest_by_brute_force(ray, t_min, t_max);
        check_kernels(&format!("stretched by {stretch}"), &geometry, RAYS / 4, make, oracle);
    }
    // A ray of which the sheared vertices are rounded by almost 1. The triangle is not quite level.
    let mut geometry = Geometry::default();
    let x: f32 = 1.007_812_5;
    let vertices = [[x, -1_048_576.0, -1.0], [x, 1_048_576.0, -1.0], [x.next_up(), 0.0, 2.0]];
    let mesh = [Triangle { vertices: vertices.map(Vec3::from_array) }].into_iter().collect();
    geometry.instances.add_mesh(mesh);
    let small = 1.0 / 1_048_576.0;
    let matrix = [[1.0, 0.0, 0.0, 0.0], [0.0, small, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    geometry.instances.push(Instance::new(0, &matrix).unwrap());
    let corner = Vec3::new(1.005, -1.0, -1.0);
    geometry.quads.extend(Quad::new(corner, Vec3::Y * 2.0, Vec3::Z * 2.0));
    let direction = Vec3::new(1.0, 2.0 * small, 0.0);
    let ray = Ray { origin: Vec3::ZERO, direction, time: 0.0 };
    let hit = geometry.closest_by_brute_force(&ray, 0.0, f32::INFINITY).unwrap();
    assert!(hit.primitive == 1 && hit.t < 1.004, "{hit:?}");
    let oracle = |ray: &Ray, t_min, t_max| geometry.closest_by_brute_force(ray, t_min, t_max);
    check_kernels("sheared", &geometry, 100, |_| (ray, f32::INFINITY), oracle);
}

/// Rays that overflow or underflow in some object space, and rays that are not finite.
#[test]
fn wild_rays_find_instances() {
    let (geometry, placed) = instanced(31, Kind::Scaled, 1.0, Vec3::ZERO);
    let mut random = Stream::new(5);
    let make = |i: usize| {
        let (mut ray, t_max) = adversarial(&mut random, i, &placed, 1.0, Vec3::ZERO);
        let power = [1e-17, 1e-14, 1e-9, 1.0, 1e9, 1e14, 1e17][i % 7];
        ray.direction *= power;
        if i.is_multiple_of(5) {
            ray.origin *= [1e3, 1e7, 1e12, f32::NAN][i / 5 % 4];
        }
        (ray, t_max)
    };
    let oracle = |ray: &Ray, t_min, t_max| geometry.closest_by_brute_force(ray, t_min, t_max);
    check_kernels("wild", &geometry, RAYS / 4, make, oracle);
}

/// Trees that are larger than the fast caches, for which brute force takes too long: of instances
/// among triangles, of the mesh that they place, and of enough instances for clusters.
#[test]
fn large_trees_of_instances() {
    let scene = ptfast::Scene::load("mesh:40960").unwrap();
    let triangles = &scene.geometry().triangles;
    let mut random = Stream::new(41);
    for (name, world, count) in [("triangles", 61_440, 300), ("clusters", 0, 140_000)] {
        let mesh = triangles.iter().take(20_480).collect();
        let mut geometry = Geometry::default();
        geometry.instances.add_mesh(mesh);
        geometry.triangles = triangles.iter().take(world).collect();
        for _ in 0..count {
            let linear = linear(&mut random, Kind::Mirrored, 0.3, 1.0);
            let center = vector(&mut random, 20.0);
            let row = |i: usize| {
                let Vec3 { x, y, z } = linear.row(i);
                [x, y, z, center[i]]
            };
            let instance = Instance::new(0, &[row(0), row(1), row(2)]).unwrap();
            geometry.instances.push(instance);
        }
        let tree = Bvh2::new(&geometry, 2);
        let oracle = |ray: &Ray, t_min, t_max| tree.closest(&geometry, ray, t_min, t_max);
        let guide = Geometry { triangles: triangles.clone(), ..Geometry::default() };
        let make = |i| adversarial(&mut random, i, &guide, 20.0, Vec3::ZERO);
        check_kernels(name, &geometry, RAYS / 4, make, oracle);
        let mut bundles = Bundles::new(18, &guide, 20.0, Vec3::ZERO);
        check_kernels(name, &geometry, RAYS / 4, |i| bundles.next(i), oracle);
    }
}

#[test]
fn equal_instances_tie_in_favour_of_the_first() {
    let vertices = [Vec3::Z, Vec3::Z + Vec3::X, Vec3::Z + Vec3::Y];
    let mesh: Triangles = [Triangle { vertices }].into_iter().collect();
    let place = |z: f32| {
        let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, z]];
        Instance::new(0, &rows).unwrap()
    };
    let mut geometry = Geometry::default();
    geometry.instances.add_mesh(mesh.clone());
    [3.0, 2.0, 2.0, 5.0].into_iter().for_each(|z| geometry.instances.push(place(z)));
    let ray = Ray { origin: Vec3::new(0.2, 0.2, 0.0), direction: Vec3::Z, time: 0.0 };
    let hit = |geometry: &Geometry| {
        let make = |_| (ray, f32::INFINITY);
        let oracle = |ray: &Ray, t_min, t_max| geometry.closest_by_brute_force(ray, t_min, t_max);
        check_kernels("ties", geometry, 100, make, oracle);
        let hit = geometry.closest_by_brute_force(&ray, 0.0, f32::INFINITY).unwrap();
        (hit.t, hit.primitive, hit.instance)
    };
    assert_eq!(hit(&geometry), (3.0, 0, 1));
    // A triangle outside instances comes before all that are in instances.
    geometry.triangles.push(Triangle { vertices: vertices.map(|v| v + Vec3::Z * 2.0) });
    assert_eq!(hit(&geometry), (3.0, 0, 0));
}

/// Trees of meshes are built in another order than that of the meshes if some are large.
#[test]
fn small_and_large_meshes_keep_their_numbers() {
    let mut geometry = Geometry::default();
    let side = 265;
    let at = |x: u32, y: u32| Vec3::new(x as f32 / side as f32, y as f32 / side as f32, 0.0);
    let cell = |i: u32| {
        let (x, y) = (i % side, i / side);
        let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
        [Triangle { vertices: [a, b, c] }, Triangle { vertices: [b, d, c] }]
    };
    let large: Triangles = (0..side * side).flat_map(cell).collect();
    assert!(large.len() > 131_072);
    let one = Triangle { vertices: [Vec3::ZERO, Vec3::X, Vec3::Y] };
    let small = || Triangles::from_iter([one]);
    for (index, mesh) in [small(), large, small()].into_iter().enumerate() {
        let mesh = geometry.instances.add_mesh(mesh);
        let rows =
            [[1.0, 0.0, 0.0, 2.0 * index as f32], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        geometry.instances.push(Instance::new(mesh, &rows).unwrap());
    }
    let mut random = Stream::new(12);
    let tree = Bvh2::new(&geometry, 2);
    let make = |_| {
        let target = Vec3::new(random.between(-0.5, 4.5), random.between(-0.5, 1.0), 0.0);
        let origin = vector(&mut random, 1.0) + Vec3::new(2.0, 0.0, 4.0);
        (Ray { origin, direction: target - origin, time: 0.0 }, f32::INFINITY)
    };
    let oracle = |ray: &Ray, t_min, t_max| tree.closest(&geometry, ray, t_min, t_max);
    check_kernels("small and large meshes", &geometry, 4096, make, oracle);
}
