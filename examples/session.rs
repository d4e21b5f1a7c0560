//! A render that is watched, stopped, continued, and changed:
//!
//!     cargo run --release --example session -- cornell

use std::path::Path;
use std::thread;
use std::time::Duration;

use ptfast::material::Lambertian;
use ptfast::{Camera, Engine, Image, ImageSettings, Layer, Layers, Metadata, Scene};
use ptfast::{Session, Transfer, Until};

fn main() -> ptfast::Result<()> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "cornell".to_owned());
    let scene = Scene::load(&name)?;
    let layers = Layers::new([Layer::Albedo, Layer::Normal]);
    let settings = ImageSettings { spp: 256, layers, ..ImageSettings::of(&scene) };
    let enough = 32 * u64::from(settings.width) * u64::from(settings.height);
    let mut session = Session::new(&scene, settings.clone(), Engine::Wavefront)?;

    // Another thread renders, and this one shows the picture so far, until it has seen enough.
    thread::scope(|scope| {
        let render = scope.spawn(|| session.render(Until::Complete, &()));
        while !render.is_finished() {
            thread::sleep(Duration::from_millis(200));
            show(&session.snapshot()?, "session.png")?;
            println!("{} samples are in session.png", session.progress().samples);
            if session.progress().samples > enough {
                session.cancel();
            }
        }
        render.join().expect("the thread does not panic")
    })?;

    // It continues as if it had never been stopped.
    session.render(Until::Complete, &())?;
    println!("{} samples per pixel have the hash {}", settings.spp, session.snapshot()?.hash());

    // Another colour and another camera: no tree is built again.
    session.change_look(|look| {
        if let Some((_, material)) = look.materials.0.first_mut() {
            *material = Lambertian::new([0.9, 0.5, 0.1]).into();
        }
    })?;
    let mut file = scene.camera_file().clone();
    file.vfov = 25.0;
    let camera = Some(Camera::try_from(&file)?);
    session.set(ImageSettings { camera, ..settings }, Engine::Wavefront)?;
    session.render(Until::Time(Duration::from_secs(1)), &())?;
    let image = session.snapshot()?;
    for layer in ["albedo", "normal"] {
        let values: &[[f32; 3]] = image.layer(layer).expect("it was asked for").values();
        println!("{layer} in the middle: {:?}", values[values.len() / 2]);
    }
    show(&image, "changed.png")
}

fn show(image: &Image, file: &str) -> ptfast::Result<()> {
    image.write(Path::new(file), Transfer::Srgb, &Metadata::default())
}
