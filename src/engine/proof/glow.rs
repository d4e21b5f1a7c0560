//! Tests surfaces that both scatter and emit light against a closed form: inside a sphere of albedo
//! a that emits radiance L everywhere, the radiance is L / (1 − a).

use crate::engine::{Engine, RenderSettings, Renderer};
use crate::scene::material::{Glow, Lambertian};
use crate::scene::{CameraFile, Sampling, Scene, SceneFile};

#[test]
fn surfaces_scatter_and_emit() {
    let mut file = SceneFile::new(CameraFile::new([0.2, 0.1, 0.0], [0.0, 0.0, 1.0], 90.0));
    let base = Lambertian::new([0.5; 3]);
    file.add_material("glow", Glow { base, radiance: [1.0; 3] });
    file.add_sphere([0.0; 3], 1.0, "glow");
    let scene = Scene::from_file(&file).unwrap();
    for sampling in Sampling::ALL {
        let images = Engine::ALL.map(|engine| {
            let settings = RenderSettings {
                width: 32,
                height: 32,
                spp: 64,
                sampling,
                engine,
                roulette: false,
                ..RenderSettings::of(&scene)
            };
            Renderer::new(&scene, settings).unwrap().render().unwrap().image
        });
        assert_eq!(images[0].hash(), images[1].hash(), "{sampling:?}");
        let pixels = images[0].pixels();
        let mean =
            pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / pixels.len() as f64;
        println!("{sampling:?}: {mean:.5}");
        // If only the BSDF is sampled, all paths have the same radiance.
        let bound = if sampling == Sampling::Bsdf { 1e-5 } else { 0.01 };
        assert!((mean - 2.0).abs() < bound, "{sampling:?}: {mean}");
    }
}
