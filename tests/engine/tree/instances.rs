//! Tests of kernels and the reference on scenes with instances.

use glam::{Mat3, Vec3};
use ptfast::internals::{
    Bvh2, Geometry, Instance, Ray, Stream, Triangle, Triangles, cross, normalize, uniform_sphere,
};

use super::check::{RAYS, bits, check_kernels};
use super::rays::{Bundles, adversarial, soup, vector};

/// The kinds of matrices.
#[derive(Clone, Copy, Debug)]
enum Kind {
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
fn instanced(seed: u64, kind: Kind, scale: f32, shift: Vec3) -> (Geometry, Geometry) {
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
        check_kernels(&name, &geometry, RAYS / 8, make, oracle);
        let mut bundles = Bundles::new(98, &placed, scale, shift);
        check_kernels(&name, &geometry, RAYS / 8, |i| bundles.next(i), oracle);
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
        let mut instances = 0;
        for i in 0..20_000 {
            let (ray, t_max) = adversarial(&mut random, i, &placed, 1.0, Vec3::ZERO);
            let want = geometry.closest_by_brute_force(&ray, 0.0, t_max);
            let found = tree.closest(&geometry, &ray, 0.0, t_max);
            assert_eq!(bits(found), bits(want), "{kind:?} {ray:?}");
            assert_eq!(tree.occluded(&geometry, &ray, 0.0, t_max), want.is_some());
            let first = geometry.len() as u32;
            instances += usize::from(want.is_some_and(|hit| hit.primitive >= first));
        }
        assert!(instances > 4000, "only {instances} rays hit instances");
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
