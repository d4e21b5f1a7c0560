//! Benchmarks single kernels: box tests, primitive tests, and whole traversals of recorded rays.
//!
//! The throughput is in rays. `slab` tests every ray against every box, and `primitive` tests every ray
//! against 16 primitives of one kind.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use ptfast::internals::{
    Accelerator, Geometry, HitBatch, Quad, Query, Ray, RayBatch, RaySet, Sphere, Stream, Triangle,
    record,
};
use ptfast::{ImageSettings, Kernel, Scene};

/// Scenes whose rays are traced, one of each size.
const SCENES: [&str; 4] = ["spheres", "cornell", "cloud:30000", "mesh:20480"];
/// Maximum number of rays of a set.
const RAYS: u64 = 1 << 14;

/// Geometry of `scene`, and the rays that a render of it traces.
fn sets(scene: &str) -> (Geometry, Vec<RaySet>) {
    let scene = Scene::load(scene).expect("the scene is built in");
    let settings = ImageSettings { width: 160, height: 90, spp: 2, ..ImageSettings::of(&scene) };
    let sets = record(&scene, &settings, RAYS).expect("the settings are in range");
    (sets.geometry, sets.sets)
}

fn slab(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("slab");
    let (geometry, sets) = sets("spheres");
    let rays = &sets.iter().find(|set| set.name == "bounce").expect("paths bounce").rays;
    let accelerator = Accelerator::new(geometry.clone());
    let range = 0..rays.len().min(2048);
    group.throughput(Throughput::Elements(range.len() as u64));
    group.bench_function("packet", |bencher| {
        bencher.iter(|| accelerator.boxes_entered(rays, range.clone()));
    });
    group.bench_function("scalar", |bencher| {
        bencher.iter(|| accelerator.boxes_entered_by_scalar(rays, range.clone()));
    });
    group.finish();
}

/// Primitives of one kind within a few units of the origin.
fn primitives() -> [(&'static str, Geometry); 5] {
    let mut random = Stream::new(1);
    let mut vector = |size: f32| Vec3::from_array([0; 3].map(|_| random.between(-size, size)));
    let none = Geometry::default;
    let mut sixteen =
        || -> Vec<[Vec3; 3]> { (0..16).map(|_| [vector(3.0), vector(1.0), vector(1.0)]).collect() };
    let still = sixteen().into_iter().map(|[at, ..]| Sphere::still(at, 0.5)).collect();
    let moving = sixteen()
        .into_iter()
        .map(|[at, by, _]| Sphere { center: at, center1: at + by, radius: 0.5 })
        .collect();
    let quad = |q, u, v| Quad::new(q, u, v).expect("its edges are not parallel");
    let quads = sixteen().into_iter().map(|[q, u, v]| quad(q, u, v)).collect();
    let aligned = sixteen()
        .into_iter()
        .map(|[q, u, v]| quad(q, Vec3::X * (u.x + 2.0), Vec3::Z * (v.z + 2.0)));
    let aligned = aligned.collect();
    let triangles =
        sixteen().into_iter().map(|[a, b, c]| Triangle { vertices: [a, a + b, a + c] }).collect();
    [
        ("sphere", Geometry { spheres: still, ..none() }),
        ("moving-sphere", Geometry { spheres: moving, ..none() }),
        ("quad", Geometry { quads, ..none() }),
        ("aligned-quad", Geometry { quads: aligned, ..none() }),
        ("triangle", Geometry { triangles, ..none() }),
    ]
}

fn primitive(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("primitive");
    let mut random = Stream::new(2);
    let mut rays = RayBatch::default();
    for _ in 0..4096 {
        let mut vector = |size: f32| Vec3::from_array([0; 3].map(|_| random.between(-size, size)));
        let (origin, target) = (vector(6.0), vector(3.0));
        let ray = Ray { origin, direction: target - origin, time: random.uniform() };
        rays.push(&ray, 0.0, f32::INFINITY);
    }
    for (name, geometry) in primitives() {
        let accelerator = Accelerator::new(geometry.clone());
        accelerator.prepare(Kernel::Flat, 1);
        let brute_force = |rays: &RayBatch| -> HitBatch {
            let mut hits = HitBatch::default();
            for index in 0..rays.len() {
                let (ray, t_min, t_max) = rays.get(index);
                hits.push(geometry.closest_by_brute_force(&ray, t_min, t_max));
            }
            hits
        };
        let want = brute_force(&rays);
        let mut hits = HitBatch::default();
        group.throughput(Throughput::Elements(rays.len() as u64));
        group.bench_function(BenchmarkId::new(name, "lanes"), |bencher| {
            bencher.iter(|| {
                hits.reset(rays.len(), true);
                accelerator.closest(Kernel::Flat, &rays, 0..rays.len(), &mut hits);
            });
        });
        // The hits are empty if criterion's filter skipped this benchmark.
        assert!(hits.is_empty() || hits == want, "{name}");
        group.bench_function(BenchmarkId::new(name, "scalar"), |bencher| {
            bencher.iter(|| brute_force(&rays));
        });
    }
    group.finish();
}

fn traversal(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("traversal");
    for scene in SCENES {
        let (geometry, sets) = sets(scene);
        let accelerator = Accelerator::new(geometry.clone());
        for set in &sets {
            let may_win = |kernel: &Kernel| accelerator.may_win(*kernel);
            for kernel in Kernel::ALL.into_iter().filter(|k| may_win(k) || *k == Kernel::Scalar) {
                accelerator.prepare(kernel, 1);
                let all = 0..set.rays.len();
                let mut hits = HitBatch::default();
                group.throughput(Throughput::Elements(all.len() as u64));
                let id = format!("{scene}/{}/{}", set.name, kernel.name());
                group.bench_function(id, |bencher| {
                    bencher.iter(|| {
                        hits.reset(all.len(), true);
                        match set.query {
                            Query::Closest => {
                                accelerator.closest(kernel, &set.rays, all.clone(), &mut hits);
                            }
                            Query::Occluded => {
                                accelerator.occluded(kernel, &set.rays, all.clone(), &mut hits);
                            }
                        }
                    });
                });
                assert!(hits.is_empty() || hits == set.hits, "{scene} {} {kernel:?}", set.name);
            }
        }
    }
    group.finish();
}

criterion_group!(benches, slab, primitive, traversal);
criterion_main!(benches);
