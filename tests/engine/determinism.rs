//! Same seed, same bits: whatever the threads, the waves and the build.

use std::fmt::Write;

use crate::common::{SAMPLINGS, render};
use ptfast::internals::BITS;
use ptfast::{RenderSettings, Renderer, Sampler, Scene};

/// Small settings with a last chunk of samples that is not full.
fn small(scene: &Scene) -> RenderSettings {
    RenderSettings { width: 50, height: 31, spp: 19, ..RenderSettings::of(scene) }
}

#[test]
fn threads_and_waves_do_not_matter() {
    for name in ptfast::BUILTIN_NAMES {
        let scene = Scene::load(name).unwrap();
        let base = RenderSettings { threads: 1, ..small(&scene) };
        let want = render(&scene, base.clone()).hash();
        for threads in [2, 3, 7] {
            let hash = render(&scene, RenderSettings { threads, ..base.clone() }).hash();
            assert_eq!(hash, want, "{name}, {threads} threads");
        }
        for wave_size in [1, 50, 2000] {
            let hash =
                render(&scene, RenderSettings { wave_size, threads: 2, ..base.clone() }).hash();
            assert_eq!(hash, want, "{name}, waves of {wave_size}");
        }
        let other = render(&scene, RenderSettings { seed: 2, ..base });
        assert_ne!(other.hash(), want, "{name}: the seed matters");
    }
}

#[test]
fn renders_on_the_pool_of_the_caller() {
    let scene = Scene::load("cornell").unwrap();
    let want = render(&scene, small(&scene)).hash();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let (hash, threads) = pool.install(|| {
        let renderer = Renderer::in_current_pool(&scene, small(&scene)).unwrap();
        (renderer.render().unwrap().image.hash(), renderer.threads())
    });
    assert_eq!((hash, threads), (want, 3));
}

/// Hashes that every build and machine must give. A change of them is a change of the
/// images: it needs a line in CHANGELOG.md, and another version of the arithmetic.
#[test]
fn every_build_gives_the_pinned_hashes() {
    let mut hashes = String::new();
    for name in ptfast::BUILTIN_NAMES.into_iter().chain(["tests/data/everything.ron"]) {
        let scene = Scene::load(name).unwrap();
        // Without lights all three are one.
        let modes = if scene.lights() == 0 { &SAMPLINGS[..1] } else { &SAMPLINGS };
        for &sampling in modes {
            for (sampler, roulette) in
                [(Sampler::Sobol, true), (Sampler::Sobol, false), (Sampler::Independent, true)]
            {
                let settings = RenderSettings { sampling, sampler, roulette, ..small(&scene) };
                let hash = render(&scene, settings).hash();
                let (sampling, sampler) = (sampling.name(), sampler.name());
                let roulette = if roulette { "on" } else { "off" };
                writeln!(hashes, "{name} {sampling} {sampler} {roulette} {hash}").unwrap();
            }
        }
    }
    let pinned = include_str!("../data/hashes.txt");
    assert_eq!(hashes, pinned, "write these to tests/data/hashes.txt if they are meant:\n{hashes}");
    // Of each version of the arithmetic the hash of these hashes. What is kept of renders tells by the version
    // whether it may be continued.
    let known = include_str!("../data/bits.txt");
    let now = format!("{BITS} {}", blake3::hash(pinned.as_bytes()));
    assert_eq!(known.lines().last(), Some(&*now), "for other images raise BITS, and add the line");
    let versions =
        known.lines().map(|line| line.split(' ').next().unwrap().parse::<u32>().unwrap());
    assert!(versions.eq(1..=BITS), "each version of tests/data/bits.txt has one line");
}
