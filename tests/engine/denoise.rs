//! Denoised pictures have the same bits on all builds and threads, and less noise.

use ptfast::{Denoise, Engine, FirstHits, ImageSettings, Layers, Renderer, Roulette, Scene};

fn settings(scene: &Scene, spp: u32) -> ImageSettings {
    let layers: Layers = "halves,albedo,normal,depth".parse().unwrap();
    ImageSettings {
        width: 50,
        height: 31,
        spp,
        layers,
        first_hit: FirstHits::Through,
        roulette: Roulette::From(5),
        ..ImageSettings::of(scene)
    }
}

/// Every build and machine must give the hashes of `denoised.txt`.
#[test]
fn every_build_denoises_alike() {
    let scene = Scene::load("cornell").unwrap();
    let render = Renderer::new(&scene, settings(&scene, 19), Engine::Wavefront).unwrap();
    let image = render.render().unwrap().image;
    let hashes = [Denoise::Fast, Denoise::Good].map(|quality| {
        let image = image.clone();
        let threads = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let [hash, other] = [threads, alone]
            .map(|pool| pool.install(|| image.clone().denoised(quality).unwrap().hash()));
        assert_eq!(hash, other, "{quality:?} depends on threads");
        (quality, hash)
    });
    let hashes = hashes.map(|(quality, hash)| format!("{} {hash}\n", quality.name())).concat();
    let pinned = std::fs::read_to_string("tests/data/denoised.txt").unwrap();
    assert_eq!(
        hashes, pinned,
        "if the change is intended, write these to tests/data/denoised.txt:\n{hashes}"
    );
}

#[test]
fn denoised_pictures_are_nearer_to_the_truth() {
    let scene = Scene::load("cornell").unwrap();
    let image = |spp, seed| {
        let settings = ImageSettings { seed, ..settings(&scene, spp) };
        Renderer::new(&scene, settings, Engine::Wavefront).unwrap().render().unwrap().image
    };
    let (truth, noisy) = (image(512, 2), image(8, 1));
    let error = |image: &ptfast::Image| -> f32 {
        let pairs = image.pixels().iter().flatten().zip(truth.pixels().iter().flatten());
        pairs.map(|(x, r)| (x - r) * (x - r) / (r * r + 0.01)).sum()
    };
    let before = error(&noisy);
    for (quality, gain) in [(Denoise::Fast, 4.0), (Denoise::Good, 4.0)] {
        let after = error(&noisy.clone().denoised(quality).unwrap());
        assert!(gain * after < before, "{quality:?}: {before} to {after}");
    }
}
