//! Tests that the wavefront engine gives the same bits as the scalar engine.

use std::sync::Mutex;

use ptfast::internals::{Stage, Stream};
use ptfast::{
    BUILTIN_NAMES, ComputeSettings, Engine, FirstHits, ImageSettings, Kernel, Layer, Layers,
    Observer, Plan, PlanChoice, Planning, Progress, Render, Renderer, Roulette, Sampler, Scene,
    SegmentPlan,
};

use crate::common::SAMPLINGS;
use crate::random_scene::random_scene;

fn render(scene: &Scene, settings: &ImageSettings, by: impl Into<ComputeSettings>) -> Render {
    Renderer::new(scene, settings.clone(), by).unwrap().render().unwrap()
}

fn on_threads(threads: u32) -> ComputeSettings {
    ComputeSettings { threads, ..ComputeSettings::default() }
}

/// Renders with both engines, compares the results, and returns the number of rays traced.
#[track_caller]
fn compare(scene: &Scene, settings: &ImageSettings, what: &str) -> u64 {
    compare_by(scene, settings, ComputeSettings::default(), what)
}

/// As [`compare`], with settings of the computation.
#[track_caller]
fn compare_by(scene: &Scene, settings: &ImageSettings, by: ComputeSettings, what: &str) -> u64 {
    let want = render(scene, settings, ComputeSettings { engine: Engine::Scalar, ..by.clone() });
    let got = render(scene, settings, by);
    assert_eq!(got.image.hash(), want.image.hash(), "{what}: {settings:?}");
    assert_eq!(got.image.layers(), want.image.layers(), "{what}: {settings:?}");
    assert_eq!(got.tally, want.tally, "{what}");
    assert_eq!(got.tally.endings.total(), got.tally.rays.primary, "{what}");
    want.tally.rays.total()
}

#[test]
fn only_large_renders_try_plans_and_only_if_they_may() {
    let scene = Scene::load("cornell").unwrap();
    for (spp, plan, planning) in [
        (4, PlanChoice::Measured, Planning::Usual),
        (400, PlanChoice::Measured, Planning::Measured),
        (400, PlanChoice::Usual, Planning::Usual),
    ] {
        let settings = ImageSettings { spp, depth: 2, ..ImageSettings::of(&scene) };
        let compute = ComputeSettings { plan, ..on_threads(1) };
        let renderer = Renderer::new(&scene, settings, compute).unwrap();
        assert_eq!(renderer.planning(), Some(planning), "{spp}");
    }
}

#[test]
fn built_in_scenes() {
    for name in BUILTIN_NAMES.into_iter().chain([
        "tests/data/everything.ron",
        "tests/data/glass.ron",
        "cloud:2000",
    ]) {
        let scene = Scene::load(name).unwrap();
        for sampling in SAMPLINGS {
            for (sampler, roulette) in [
                (Sampler::Sobol, Roulette::From(5)),
                (Sampler::Sobol, Roulette::Auto),
                (Sampler::Independent, Roulette::From(2)),
            ] {
                let settings = ImageSettings {
                    width: 61,
                    height: 37,
                    spp: 5,
                    sampling,
                    sampler,
                    roulette,
                    ..ImageSettings::of(&scene)
                };
                compare(&scene, &settings, name);
            }
        }
    }
}

/// A random plan, or `None`.
fn random_plan(random: &mut Stream) -> Option<Plan> {
    let mut below = |end| (random.bits() % end) as usize;
    let segments = (0..below(4)).map(|_| SegmentPlan {
        ordered: below(2) == 0,
        closest: Kernel::ALL[below(Kernel::ALL.len() as u64)],
        occluded: Kernel::ALL[below(Kernel::ALL.len() as u64)],
        shadows_ordered: below(2) == 0,
    });
    let segments: Vec<_> = segments.collect();
    let wave_size = 1 + below(700) as u32;
    (!segments.is_empty()).then_some(Plan { wave_size, segments })
}

/// Scenes whose trees are too large for packets.
#[test]
fn large_scenes() {
    for name in ["mesh:20480", "cloud:30000"] {
        let scene = Scene::load(name).unwrap();
        let base = ImageSettings::of(&scene);
        compare(&scene, &ImageSettings { width: 70, height: 50, spp: 2, ..base }, name);
    }
}

#[test]
fn random_scenes() {
    let mut rays = 0;
    for seed in 0..400 {
        let scene = Scene::from_file(&random_scene(seed)).unwrap();
        let mut random = Stream::new(!seed);
        let roulettes = [Roulette::Off, Roulette::From(1), Roulette::From(3), Roulette::Auto];
        let roulette = roulettes[random.bits() as usize % 4];
        let plan = random_plan(&mut random);
        let sampler = Sampler::ALL[seed as usize % 2];
        let base = ImageSettings::of(&scene);
        let layers =
            Layers::new(Layer::ALL.into_iter().filter(|_| random.bits().is_multiple_of(4)));
        let first_hit = FirstHits::ALL[seed as usize / 2 % 2];
        let settings = ImageSettings { seed, sampler, roulette, layers, first_hit, ..base };
        let by = ComputeSettings { plan: plan.into(), ..on_threads(1) };
        rays += compare_by(&scene, &settings, by, &format!("scene {seed}"));
    }
    assert!(rays > 800_000, "{rays}");
}

/// Images of odd sizes, with few samples, few segments, or more threads than pixels.
#[test]
fn odd_sizes() {
    let scene = Scene::load("tests/data/everything.ron").unwrap();
    let base = ImageSettings { spp: 3, depth: 6, ..ImageSettings::of(&scene) };
    for (width, height) in [(1, 1), (3, 1000), (1000, 3), (37, 41), (1, 17)] {
        let settings = ImageSettings { width, height, ..base.clone() };
        compare(&scene, &settings, "size");
    }
    for (spp, depth, threads) in [(1, 1, 1), (1, 50, 2), (40, 1, 3), (17, 2, 64)] {
        let settings = ImageSettings { width: 7, height: 5, spp, depth, ..base.clone() };
        compare_by(&scene, &settings, on_threads(threads), "samples, segments, threads");
    }
}

/// Waves of any size, down to one pixel's samples, and plans of every kind give the same bits.
#[test]
fn waves_and_plans_do_not_matter() {
    for name in ["tests/data/everything.ron", "spheres"] {
        let scene = Scene::load(name).unwrap();
        let base = ImageSettings { width: 43, height: 29, spp: 18, ..ImageSettings::of(&scene) };
        let want = render(&scene, &base, Engine::Scalar);
        let same = |by: ComputeSettings| {
            let got = render(&scene, &base, by.clone());
            assert_eq!(got.image.hash(), want.image.hash(), "{by:?}");
            assert_eq!(got.tally, want.tally, "{by:?}");
        };
        for wave_size in [1, 7, 16, 33, 500, 1 << 16] {
            same(ComputeSettings { wave_size, ..on_threads(2) });
        }
        let ways = Kernel::ALL.into_iter().flat_map(|kernel| [(kernel, true), (kernel, false)]);
        for (kernel, ordered) in ways {
            let (closest, occluded) = (kernel, kernel);
            let segment = SegmentPlan { ordered, closest, occluded, shadows_ordered: !ordered };
            let plan = Plan { wave_size: 700, segments: vec![segment; 2] };
            same(ComputeSettings { plan: PlanChoice::Given(plan), ..on_threads(2) });
        }
    }
}

/// Equal plans do equal work on any number of threads, and the counts add up.
#[test]
fn counts_add_up_and_repeat() {
    let scene = Scene::load("cornell").unwrap();
    let settings = ImageSettings {
        width: 60,
        height: 40,
        spp: 20,
        // At most the number of segments that are counted separately.
        depth: 16,
        ..ImageSettings::of(&scene)
    };
    let counting = ComputeSettings { count: true, ..on_threads(1) };
    let renderer = Renderer::new(&scene, settings.clone(), counting.clone()).unwrap();
    let plan = renderer.plan().cloned();
    let first = renderer.render().unwrap();
    let second =
        render(&scene, &settings, ComputeSettings { plan: plan.into(), threads: 3, ..counting });
    // This scene has no media.
    for stage in Stage::ALL.into_iter().filter(|&stage| stage != Stage::Collide) {
        let (a, b) = (first.waves.stage(stage), second.waves.stage(stage));
        assert_eq!((a.active, a.issued, a.counters), (b.active, b.issued, b.counters), "{stage:?}");
        assert!(a.active > 0 && a.active <= a.issued, "{stage:?}");
    }
    let active = |stage| first.waves.stage(stage).active;
    assert_eq!(active(Stage::Generate), first.tally.rays.primary);
    assert_eq!(active(Stage::Extend), first.tally.rays.primary + first.tally.rays.bounce);
    assert_eq!(active(Stage::Order), first.tally.rays.bounce);
    // Each ray of a segment belongs to a path that ends there or continues in the next segment.
    let segments = &first.waves.segments;
    let next = segments[1..].iter().map(|segment| segment.stage(Stage::Extend).active);
    for (segment, on) in segments.iter().zip(next.chain([0])) {
        let rays = segment.stage(Stage::Extend).active;
        assert_eq!(segment.stage(Stage::Sort).active, rays);
        assert_eq!(segment.endings.total() + on, rays);
    }
    let ended: u64 = segments.iter().map(|segment| segment.endings.total()).sum();
    assert_eq!(ended, first.tally.rays.primary);
    assert_eq!(active(Stage::Connect), first.tally.rays.shadow);
    assert_eq!(active(Stage::Accumulate), 60 * 40 * 20);
    assert!(first.waves.stage(Stage::Extend).counters.lanes_active > 0);
    assert_eq!(first.tally.endings.total(), first.tally.rays.primary);
}

/// Large renders measure a plan, on one thread and on two, and other renders can use that plan.
#[test]
fn plans_are_measured() {
    let scene = Scene::load("cornell").unwrap();
    let base = ImageSettings { width: 200, height: 200, ..ImageSettings::of(&scene) };
    for threads in [1, 2] {
        // 30 million paths per thread are enough to measure wave sizes too.
        let large = ImageSettings { spp: 750 * threads, ..base.clone() };
        let renderer = Renderer::new(&scene, large.clone(), on_threads(threads)).unwrap();
        let plan = renderer.plan().unwrap();
        plan.check().unwrap();
        assert_eq!(plan.segments.len(), 4, "{plan:?}");
        assert!((1 << 12..=1 << 14).contains(&plan.wave_size), "{plan:?}");
        let first = &plan.segments[0];
        assert!(!first.ordered && first.closest != Kernel::Scalar, "{plan:?}");
        let small = ImageSettings { spp: 3, ..large.clone() };
        let by = ComputeSettings { plan: PlanChoice::Given(plan.clone()), ..on_threads(2) };
        compare_by(&scene, &small, by, "measured");
        let text = serde_json::to_string(plan).unwrap();
        assert_eq!(serde_json::from_str::<Plan>(&text).unwrap(), *plan);
        // A given wave size is kept.
        let given = ComputeSettings { wave_size: 5000, ..on_threads(threads) };
        let renderer = Renderer::new(&scene, large, given).unwrap();
        let plan = renderer.plan().unwrap();
        assert_eq!((plan.wave_size, plan.segments.len()), (5000, 4));
    }
}

#[test]
fn plans_out_of_range_are_refused() {
    let scene = Scene::load("cornell").unwrap();
    let (closest, occluded) = (Kernel::Flat, Kernel::Flat);
    let segment = SegmentPlan { ordered: false, closest, occluded, shadows_ordered: false };
    let plan = Plan { wave_size: 1, segments: vec![segment] };
    let refused = |plan| {
        let by = ComputeSettings { plan: PlanChoice::Given(plan), ..ComputeSettings::default() };
        Renderer::new(&scene, ImageSettings::of(&scene), by).is_err()
    };
    assert!(!refused(plan.clone()));
    assert!(refused(Plan { wave_size: 0, ..plan.clone() }));
    assert!(refused(Plan { segments: Vec::new(), ..plan }));
}

/// Passes of any size give the same bits and the same counts as a single pass. Each pass yields an
/// image.
#[test]
fn passes_of_any_size_give_the_same_bits() {
    struct Nobody;
    impl Observer for Nobody {
        fn progressed(&self, _: Progress) {}
    }
    let scene = Scene::load("tests/data/everything.ron").unwrap();
    let base = ImageSettings { width: 40, height: 30, spp: 37, ..ImageSettings::of(&scene) };
    for engine in Engine::ALL {
        let whole = render(&scene, &base, engine);
        let by = ComputeSettings { engine, wave_size: 700, ..ComputeSettings::default() };
        let renderer = Renderer::new(&scene, base.clone(), by).unwrap();
        let mut rendering = renderer.begin().unwrap();
        for pass in [1, 1, 2, 4, 8, 5, 16] {
            let end = rendering.film.samples_done() as u32 / (40 * 30) + pass;
            renderer.advance_to(&mut rendering, end, &Nobody).unwrap();
            let so_far = ImageSettings { spp: end, ..base.clone() };
            let image = rendering.image().unwrap();
            assert_eq!(image.hash(), render(&scene, &so_far, engine).image.hash(), "{end} samples");
        }
        assert_eq!(renderer.finish(&mut rendering).unwrap().tally, whole.tally, "{engine:?}");
    }
}

/// A renderer that changes views keeps its trees, and renders the same image as a new renderer.
#[test]
fn views_share_a_prepared_scene() {
    fn send_and_sync<T: Send + Sync + 'static>(_: &T) {}
    let scene = Scene::load("mesh:20480").unwrap();
    let base = ImageSettings { width: 40, height: 30, spp: 4, ..ImageSettings::of(&scene) };
    let mut renderer = Renderer::new(&scene, base.clone(), Engine::Wavefront).unwrap();
    send_and_sync(&renderer);
    let other = Scene::load("cornell").unwrap().camera().clone();
    for engine in Engine::ALL {
        let views = [
            ImageSettings { camera: Some(other.clone()), ..base.clone() },
            ImageSettings { width: 31, height: 17, seed: 3, ..base.clone() },
            ImageSettings { spp: 20, depth: 3, ..base.clone() },
            base.clone(),
        ];
        for view in views {
            renderer.set(view.clone(), engine).unwrap();
            let new = Renderer::new(&scene, view.clone(), engine).unwrap().render().unwrap();
            assert_eq!(renderer.render().unwrap().image.hash(), new.image.hash());
            let shared =
                Renderer::new(renderer.prepared(), view, engine).unwrap().render().unwrap();
            assert_eq!(shared.image.hash(), new.image.hash());
        }
    }
    assert!(renderer.set(ImageSettings { width: 0, ..base }, Engine::Wavefront).is_err());
    assert_eq!(renderer.image_settings().width, 40);
}

/// Progress reports count every path and ray once.
#[test]
fn progress_adds_up() {
    struct Last(Mutex<Progress>);
    impl Observer for Last {
        fn progressed(&self, progress: Progress) {
            // Reports of several threads may arrive out of order.
            let mut last = self.0.lock().unwrap();
            last.samples = last.samples.max(progress.samples);
            last.rays = last.rays.max(progress.rays);
        }
    }
    let scene = Scene::load("cornell").unwrap();
    let base = ImageSettings { width: 50, height: 40, spp: 21, ..ImageSettings::of(&scene) };
    for engine in Engine::ALL {
        let by = ComputeSettings { engine, wave_size: 100, ..ComputeSettings::default() };
        let renderer = Renderer::new(&scene, base.clone(), by).unwrap();
        let last = Last(Mutex::default());
        let mut rendering = renderer.begin().unwrap();
        renderer.advance(&mut rendering, &last).unwrap();
        let rays = rendering.tally.rays;
        let Progress { samples, rays: traced } = last.0.into_inner().unwrap();
        assert_eq!((samples, traced), (50 * 40 * 21, rays.total()), "{engine:?}");
    }
}
