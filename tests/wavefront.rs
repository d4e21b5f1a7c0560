//! The wavefront engine has the scalar engine's bits.

mod common;

use common::SAMPLINGS;
use common::random_scene::random_scene;
use ptfast::accel::Kernel;
use ptfast::engine::{Plan, SegmentPlan, Stage};
use ptfast::scene::BUILTIN_NAMES;
use ptfast::{Engine, Render, RenderSettings, Renderer, Scene};

fn render(scene: &Scene, settings: &RenderSettings, engine: Engine) -> Render {
    let settings = RenderSettings { engine, ..settings.clone() };
    Renderer::new(scene, settings).unwrap().render().unwrap()
}

/// Renders with both engines. Returns the rays traced.
#[track_caller]
fn compare(scene: &Scene, settings: &RenderSettings, what: &str) -> u64 {
    let want = render(scene, settings, Engine::Scalar);
    let got = render(scene, settings, Engine::Wavefront);
    assert_eq!(got.image.hash(), want.image.hash(), "{what}: {settings:?}");
    assert_eq!(got.rays, want.rays, "{what}");
    assert_eq!(got.non_finite, want.non_finite, "{what}");
    assert_eq!(got.endings, want.endings, "{what}");
    assert_eq!(got.endings.total(), got.rays.primary, "{what}");
    want.rays.total()
}

#[test]
fn built_in_scenes() {
    for name in BUILTIN_NAMES.into_iter().chain(["tests/data/everything.ron", "cloud:2000"]) {
        let scene = Scene::load(name).unwrap();
        for sampling in SAMPLINGS {
            for roulette in [true, false] {
                let base = RenderSettings::of(&scene);
                let settings =
                    RenderSettings { width: 61, height: 37, spp: 5, sampling, roulette, ..base };
                compare(&scene, &settings, name);
            }
        }
    }
}

#[test]
fn random_scenes() {
    let mut rays = 0;
    for seed in 0..400 {
        let scene = Scene::from_file(&random_scene(seed)).unwrap();
        let settings = RenderSettings { seed, threads: 1, ..RenderSettings::of(&scene) };
        rays += compare(&scene, &settings, &format!("scene {seed}"));
    }
    assert!(rays > 900_000, "{rays}");
}

/// Images of odd sizes, few samples, few segments, more threads than pixels.
#[test]
fn odd_sizes() {
    let scene = Scene::load("tests/data/everything.ron").unwrap();
    let base = RenderSettings { spp: 3, depth: 6, ..RenderSettings::of(&scene) };
    for (width, height) in [(1, 1), (3, 1000), (1000, 3), (37, 41), (1, 17)] {
        let settings = RenderSettings { width, height, ..base.clone() };
        compare(&scene, &settings, "size");
    }
    for (spp, depth, threads) in [(1, 1, 1), (1, 50, 2), (40, 1, 3), (17, 2, 64)] {
        let settings = RenderSettings { width: 7, height: 5, spp, depth, threads, ..base.clone() };
        compare(&scene, &settings, "samples, segments, threads");
    }
}

/// Waves from less than a vector up, tiles of every size, plans of every kind: the same bits.
#[test]
fn waves_tiles_and_plans_do_not_matter() {
    for name in ["tests/data/everything.ron", "spheres"] {
        let scene = Scene::load(name).unwrap();
        let base = RenderSettings {
            width: 43,
            height: 29,
            spp: 18,
            threads: 2,
            ..RenderSettings::of(&scene)
        };
        let want = render(&scene, &base, Engine::Scalar);
        let same = |settings: RenderSettings| {
            let got = render(&scene, &settings, Engine::Wavefront);
            assert_eq!(got.image.hash(), want.image.hash(), "{settings:?}");
            assert_eq!((got.rays, got.endings), (want.rays, want.endings), "{settings:?}");
        };
        for wave_size in [1, 7, 16, 33, 500, 1 << 16] {
            same(RenderSettings { wave_size, ..base.clone() });
        }
        for tile_size in [1, 5, 64] {
            same(RenderSettings { tile_size, ..base.clone() });
        }
        let ways = Kernel::ALL.into_iter().flat_map(|kernel| [(kernel, true), (kernel, false)]);
        for (kernel, ordered) in ways {
            let segment = SegmentPlan { ordered, closest: kernel, occluded: kernel };
            let plan = Plan { wave_size: 700, tile_size: 9, segments: vec![segment; 2] };
            same(RenderSettings { plan: Some(plan), ..base.clone() });
        }
    }
}

/// With the same plan the same work, however it is shared out; and its counts add up.
#[test]
fn counts_add_up_and_repeat() {
    let scene = Scene::load("cornell").unwrap();
    let settings = RenderSettings {
        width: 60,
        height: 40,
        spp: 20,
        threads: 1,
        count: true,
        ..RenderSettings::of(&scene)
    };
    let renderer = Renderer::new(&scene, settings.clone()).unwrap();
    let plan = renderer.plan().cloned();
    let first = renderer.render().unwrap();
    let again = RenderSettings { plan, threads: 3, ..settings };
    let second = render(&scene, &again, Engine::Wavefront);
    for stage in Stage::ALL {
        let (a, b) = (first.waves.stage(stage), second.waves.stage(stage));
        assert_eq!((a.active, a.issued, a.counters), (b.active, b.issued, b.counters), "{stage:?}");
        assert!(a.active > 0 && a.active <= a.issued && a.seconds > 0.0, "{stage:?}");
    }
    let active = |stage| first.waves.stage(stage).active;
    assert_eq!(active(Stage::Generate), first.rays.primary);
    assert_eq!(active(Stage::Extend), first.rays.primary + first.rays.bounce);
    assert_eq!(active(Stage::Order), first.rays.bounce);
    assert_eq!(active(Stage::Connect), first.rays.shadow);
    assert_eq!(active(Stage::Accumulate), 60 * 40 * 20);
    assert!(first.waves.stage(Stage::Extend).counters.lanes_active > 0);
    assert_eq!(first.endings.total(), first.rays.primary);
}

/// A render large enough for a plan to be measured, which is one that can be given.
#[test]
fn plans_are_measured() {
    let scene = Scene::load("cornell").unwrap();
    let settings =
        RenderSettings { width: 200, height: 200, spp: 27, depth: 3, ..RenderSettings::of(&scene) };
    compare(&scene, &settings, "measured");
    let renderer = Renderer::new(&scene, settings).unwrap();
    let plan = renderer.plan().unwrap();
    plan.check().unwrap();
    assert_eq!(plan.segments.len(), 4, "{plan:?}");
    let text = serde_json::to_string(plan).unwrap();
    assert_eq!(serde_json::from_str::<Plan>(&text).unwrap(), *plan);
    for wrong in [
        Plan { wave_size: 0, ..plan.clone() },
        Plan { tile_size: 0, ..plan.clone() },
        Plan { segments: Vec::new(), ..plan.clone() },
    ] {
        let settings = RenderSettings { plan: Some(wrong), ..RenderSettings::of(&scene) };
        assert!(Renderer::new(&scene, settings).is_err());
    }
}
