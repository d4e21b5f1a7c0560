//! Benchmarks whole frames of the built-in scenes, of a mesh and of instances, with the throughput in rays.

use std::time::{Duration, Instant};

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ptfast::{ComputeSettings, Engine, ImageSettings, Renderer, Scene};

fn frames(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("frames");
    group.sample_size(10);
    for name in ptfast::BUILTIN_NAMES.into_iter().chain(["mesh:100000", "forest:10000"]) {
        let scene = Scene::load(name).expect("these scenes are valid");
        for engine in Engine::ALL {
            let settings =
                ImageSettings { width: 160, height: 90, spp: 16, ..ImageSettings::of(&scene) };
            let compute = ComputeSettings { threads: 1, ..engine.into() };
            let renderer =
                Renderer::new(&scene, settings, compute).expect("the settings are in range");
            let first = renderer.render().expect("one thread can be started");
            let hash = first.image.hash();
            group.throughput(Throughput::Elements(first.tally.rays.total()));
            group.bench_function(format!("{name}/{}", engine.name()), |bencher| {
                bencher.iter_custom(|renders| {
                    let mut time = Duration::ZERO;
                    for _ in 0..renders {
                        let start = Instant::now();
                        let render = renderer.render().expect("one thread can be started");
                        time += start.elapsed();
                        // The benchmark fails if an image differs from the first one.
                        assert_eq!(render.image.hash(), hash);
                    }
                    time
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, frames);
criterion_main!(benches);
