//! Tests that equal seeds give equal bits with any number of threads, any wave size and any build.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::sync::{Mutex, mpsc};

use ptfast::internals::BITS;
use ptfast::{
    ComputeSettings, Engine, ImageSettings, Observer, Progress, Renderer, Roulette, Sampler, Scene,
};
use rayon::prelude::*;

use crate::common::{SAMPLINGS, render, render_by};

/// Small settings whose last chunk of samples is not full.
fn small(scene: &Scene) -> ImageSettings {
    ImageSettings { width: 50, height: 31, spp: 19, ..ImageSettings::of(scene) }
}

#[test]
fn threads_and_waves_do_not_matter() {
    for name in ptfast::BUILTIN_NAMES {
        let scene = Scene::load(name).unwrap();
        let base = small(&scene);
        let by = |threads, wave_size| {
            let compute = ComputeSettings { threads, wave_size, ..ComputeSettings::default() };
            render_by(&scene, base.clone(), compute).hash()
        };
        let want = by(1, 0);
        for threads in [2, 3, 7] {
            assert_eq!(by(threads, 0), want, "{name}, {threads} threads");
        }
        for wave_size in [1, 50, 2000] {
            assert_eq!(by(2, wave_size), want, "{name}, waves of {wave_size}");
        }
        let other = render(&scene, ImageSettings { seed: 2, ..base.clone() });
        assert_ne!(other.hash(), want, "{name}: the seed matters");
    }
}

#[test]
fn renders_on_the_pool_of_the_caller() {
    let scene = Scene::load("cornell").unwrap();
    let want = render(&scene, small(&scene)).hash();
    /// Collects the names of the threads that render.
    #[derive(Default)]
    struct Names(Mutex<BTreeSet<String>>);

    impl Observer for Names {
        fn progressed(&self, _: Progress) {
            let name = std::thread::current().name().unwrap_or_default().to_owned();
            self.0.lock().unwrap().insert(name);
        }
    }

    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).thread_name(|i| format!("mine {i}"));
    let (names, hash) = pool.build().unwrap().install(|| {
        let renderer =
            Renderer::in_current_pool(&scene, small(&scene), ComputeSettings::default()).unwrap();
        assert_eq!(renderer.threads(), 3);
        let (mut rendering, names) = (renderer.begin().unwrap(), Names::default());
        renderer.advance(&mut rendering, &names).unwrap();
        (names.0.into_inner().unwrap(), rendering.image().unwrap().hash())
    });
    assert_eq!(hash, want);
    assert!(!names.is_empty() && names.iter().all(|name| name.starts_with("mine ")), "{names:?}");
}

/// A render must not wait for pool threads that the caller keeps busy.
#[test]
fn busy_threads_of_the_caller_are_not_waited_for() {
    let scene = Scene::load("cornell").unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let (begun, has_begun) = mpsc::channel();
    let (rendered, is_rendered) = mpsc::channel();
    pool.spawn(move || {
        begun.send(()).unwrap();
        is_rendered.recv().unwrap();
    });
    has_begun.recv().unwrap();
    let hash = pool.install(|| {
        let renderer =
            Renderer::in_current_pool(&scene, small(&scene), ComputeSettings::default()).unwrap();
        renderer.render().unwrap().image.hash()
    });
    rendered.send(()).unwrap();
    assert_eq!(hash, render(&scene, small(&scene)).hash());
}

/// A rendering rejects samples of another camera, setting or scene.
#[test]
fn renderings_belong_to_a_view() {
    let [scene, other] = ["cornell", "checker"].map(|name| Scene::load(name).unwrap());
    let base = small(&scene);
    let mut renderer = Renderer::new(&scene, base.clone(), ComputeSettings::default()).unwrap();
    let mut rendering = renderer.begin().unwrap();
    renderer.advance_to(&mut rendering, 1, &()).unwrap();
    for settings in [
        ImageSettings { seed: 2, ..base.clone() },
        ImageSettings { camera: Some(other.camera().clone()), ..base.clone() },
        ImageSettings { width: base.width + 1, ..base.clone() },
        ImageSettings { depth: base.depth + 1, ..base.clone() },
        ImageSettings { clamp: Some(1.0), ..base.clone() },
    ] {
        renderer.set(settings, ComputeSettings::default()).unwrap();
        let refused = renderer.advance(&mut rendering, &()).unwrap_err();
        assert!(refused.to_string().contains("of another scene, camera or setting"), "{refused}");
    }
    let elsewhere = Renderer::new(&other, base.clone(), ComputeSettings::default()).unwrap();
    assert!(elsewhere.advance(&mut rendering, &()).is_err());
    let same = ImageSettings { camera: Some(scene.camera().clone()), ..base.clone() };
    renderer.set(same, Engine::Scalar).unwrap();
    renderer.advance(&mut rendering, &()).unwrap();
    assert_eq!(rendering.image().unwrap().hash(), render(&scene, base).hash());
}

/// Russian roulette as the report has it.
const FIFTH: Roulette = Roulette::From(5);

/// The hashes of a scene, line by line.
fn hashes_of(name: &str) -> String {
    let mut hashes = String::new();
    let scene = Scene::load(name).unwrap();
    // Without lights, all three modes are the same.
    let modes = if scene.lights() == 0 { &SAMPLINGS[..1] } else { &SAMPLINGS };
    for &sampling in modes {
        for (sampler, roulette) in [
            (Sampler::Sobol, FIFTH),
            (Sampler::Sobol, Roulette::Off),
            (Sampler::Sobol, Roulette::Auto),
            (Sampler::Independent, FIFTH),
        ] {
            // The rule of `auto` depends on the scene, but not on the mode.
            if roulette == Roulette::Auto && sampling != modes[modes.len() - 1] {
                continue;
            }
            let settings = ImageSettings { sampling, sampler, roulette, ..small(&scene) };
            let hash = render(&scene, settings).hash();
            let (sampling, sampler) = (sampling.name(), sampler.name());
            let roulette = match roulette {
                Roulette::From(_) => "on".to_owned(),
                other => other.to_string(),
            };
            writeln!(hashes, "{name} {sampling} {sampler} {roulette} {hash}").unwrap();
        }
    }
    hashes
}

/// Every build and machine must give these hashes. If they change, images have changed, which needs
/// an entry in CHANGELOG.md and a new version of the arithmetic (`BITS`).
#[test]
fn every_build_gives_the_pinned_hashes() {
    let files = ["everything", "smooth", "instances", "mapped", "lights", "glass"];
    let files = files.map(|name| format!("tests/data/{name}.ron"));
    let names: Vec<_> = ptfast::BUILTIN_NAMES.map(str::to_owned).into_iter().chain(files).collect();
    // All at a time, since an emulator takes long for each.
    let hashes = names.par_iter().map(|name| hashes_of(name)).collect::<Vec<_>>().concat();
    let pinned = include_str!("../data/hashes.txt");
    assert_eq!(
        hashes, pinned,
        "if the change is intended, write these to tests/data/hashes.txt:\n{hashes}"
    );
    // `bits.txt` has one line per version of the arithmetic, with the hash of `hashes.txt`.
    // Checkpoints store the version, so that a build with other arithmetic does not continue them.
    let known = include_str!("../data/bits.txt");
    let now = format!("{BITS} {}", blake3::hash(pinned.as_bytes()));
    assert_eq!(
        known.lines().last(),
        Some(&*now),
        "images have changed: increment BITS and append its line to tests/data/bits.txt"
    );
    let versions =
        known.lines().map(|line| line.split(' ').next().unwrap().parse::<u32>().unwrap());
    assert!(
        versions.eq(1..=BITS),
        "tests/data/bits.txt must have one line per version, from 1 to BITS"
    );
}
