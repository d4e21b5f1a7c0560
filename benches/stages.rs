//! Benchmarks the stages of the wavefront engine in whole renders, timed by the engine's own clocks.
//!
//! Throughput is the number of rays or paths that a stage processes per second.

use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ptfast::internals::Stage;
use ptfast::{ComputeSettings, ImageSettings, Renderer, Scene};

fn stages(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("stages");
    group.sample_size(10).measurement_time(Duration::from_secs(2));
    for name in ptfast::BUILTIN_NAMES {
        let scene = Scene::load(name).expect("built-in scenes are valid");
        let settings =
            ImageSettings { width: 160, height: 90, spp: 16, ..ImageSettings::of(&scene) };
        let compute = ComputeSettings { threads: 1, ..ComputeSettings::default() };
        let renderer = Renderer::new(&scene, settings, compute).expect("the settings are in range");
        let render = || renderer.render().expect("there is memory for a small image");
        let first = render();
        for stage in Stage::ALL {
            let active = first.waves.stage(stage).active;
            if active == 0 {
                continue;
            }
            group.throughput(Throughput::Elements(active));
            group.bench_function(format!("{name}/{}", stage.name()), |bencher| {
                bencher.iter_custom(|renders| {
                    let seconds = (0..renders).map(|_| render().waves.stage(stage).seconds);
                    Duration::from_secs_f64(seconds.sum())
                });
            });
        }
    }
    group.finish();
}

criterion_group!(benches, stages);
criterion_main!(benches);
