//! Tests of geometry that is hard for tree builders: empty, crowded, regular, nested or degenerate.

use glam::Vec3;
use ptfast::Kernel;
use ptfast::internals::{
    Accelerator, Bvh2, Geometry, Hit, HitBatch, Quad, Ray, RayBatch, Sphere, Stream, Triangle,
    Triangles,
};

use super::check::{RAYS, check};
use super::rays::vector;

#[test]
fn reference_on_odd_geometry() {
    let ray = Ray { origin: Vec3::ZERO, direction: Vec3::Z, time: 0.0 };
    let empty = Geometry::default();
    let tree = Bvh2::new(&empty, 1);
    assert_eq!(tree.closest(&empty, &ray, 0.0, f32::INFINITY), None);
    assert!(!tree.occluded(&empty, &ray, 0.0, f32::INFINITY));

    let sphere = Sphere::still(Vec3::Z * 5.0, 1.0);
    let line = Triangle { vertices: [Vec3::Z, Vec3::Z * 2.0, Vec3::Z * 3.0] };
    let point = Triangle { vertices: [Vec3::Z * 2.0; 3] };
    let same = Geometry {
        spheres: vec![sphere; 100_000],
        quads: Vec::new(),
        triangles: Triangles::from_iter([line, point]),
        ..Geometry::default()
    };
    let tree = Bvh2::new(&same, 1);
    let hit = tree.closest(&same, &ray, 0.0, f32::INFINITY).unwrap();
    assert_eq!((hit.primitive, hit.t), (0, 4.0), "of 100 000 equal spheres, the first must win");
}

/// Rows and grids of equal primitives tie in every comparison of the builder, and primitives in
/// geometric progression give the deepest trees. Both must build quickly enough for a test.
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
        let accelerator = Accelerator::new(geometry.clone());
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

/// No kernel hangs or fails on a million equal primitives, on one, or on an empty scene.
#[test]
fn kernels_on_odd_geometry() {
    let sphere = Sphere::still(Vec3::Z * 5.0, 1.0);
    let ray = Ray { origin: Vec3::ZERO, direction: Vec3::Z, time: 0.0 };
    let mut batch = RayBatch::default();
    batch.push(&ray, 0.0, f32::INFINITY);
    batch.push(&Ray { direction: Vec3::NEG_Z, ..ray }, 0.0, f32::INFINITY);
    batch.push(&Ray { direction: Vec3::ZERO, ..ray }, 0.0, f32::INFINITY);
    let quad = Quad::new(Vec3::new(-1.0, -1.0, 4.0), Vec3::X * 2.0, Vec3::Y * 2.0).unwrap();
    let vertices = [quad.q, quad.q + quad.u * 2.0, quad.q + quad.v * 2.0];
    for count in [0, 1, 1_000_000] {
        for geometry in [
            Geometry { spheres: vec![sphere; count], ..Geometry::default() },
            Geometry { quads: vec![quad; count], ..Geometry::default() },
            Geometry {
                triangles: std::iter::repeat_n(Triangle { vertices }, count).collect(),
                ..Geometry::default()
            },
        ] {
            let accelerator = Accelerator::new(geometry.clone());
            for kernel in Kernel::ALL {
                let (mut closest, mut any) = (HitBatch::misses(3), HitBatch::misses(3));
                accelerator.closest(kernel, &batch, 0..3, &mut closest);
                accelerator.occluded(kernel, &batch, 0..3, &mut any);
                for (hits, t) in [(closest, 4.0), (any, 0.0)] {
                    let first = (count > 0).then_some(Hit::of(0, t));
                    assert_eq!([0, 1, 2].map(|i| hits.get(i)), [first, None, None], "{kernel:?}");
                }
            }
        }
    }
}

/// Concentric spheres, nested boxes, triangles without area, and crowds of primitives at one place.
#[test]
fn nested_degenerate_and_crowded_geometry() {
    let mut random = Stream::new(13);
    let mut geometry = Geometry::default();
    for _ in 0..4 {
        let center = vector(&mut random, 1.0);
        for shell in 1..12 {
            let size = 0.03 * shell as f32;
            geometry.spheres.push(Sphere::still(center, size));
            let [u, v] = [Vec3::X, Vec3::Y].map(|axis| axis * size);
            geometry.quads.extend(Quad::new(center - (u + v) * 0.5, u, v));
            let [a, b] = [(); 2].map(|()| vector(&mut random, size));
            let corners = [center + a, center + b, center - a];
            geometry.triangles.push(Triangle { vertices: corners });
            // A point, a line that returns to its start, and a line through three points.
            let [a, b, _] = corners;
            for vertices in [[a; 3], [a, b, a], [a, b, (a + b) * 0.5]] {
                geometry.triangles.push(Triangle { vertices });
            }
        }
    }
    check("nested", &geometry, RAYS, 1.0, Vec3::ZERO);

    let sphere = Sphere::still(Vec3::ONE, 0.3);
    let quad = Quad::new(Vec3::ZERO, Vec3::new(0.3, 0.1, 0.0), Vec3::new(0.0, 0.2, 0.3)).unwrap();
    let vertices = [Vec3::NEG_ONE, Vec3::new(-0.5, -1.0, -0.8), Vec3::new(-0.9, -0.4, -1.0)];
    let crowd = Geometry {
        spheres: vec![sphere; 200],
        quads: vec![quad; 200],
        triangles: std::iter::repeat_n(Triangle { vertices }, 200).collect(),
        ..Geometry::default()
    };
    check("crowd", &crowd, RAYS, 1.0, Vec3::ZERO);
}

/// One primitive spans the scene, so the tree consists of a single leaf with the other primitive.
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
            triangles: Triangles::from_iter([Triangle { vertices }]),
            ..Geometry::default()
        },
    ];
    for geometry in &small {
        check("one", geometry, 20_000, 1.0, Vec3::Y);
    }
}
