//! Tests of sessions.

use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use ptfast::material::Lambertian;
use ptfast::{
    Background, Camera, ComputeSettings, Engine, Image, ImageSettings, Layer, Layers, Look,
    Observer, Progress, Renderer, Scene, Session, Stop, Until,
};

fn settings(scene: &Scene) -> ImageSettings {
    let layers = Layers::new([Layer::Albedo, Layer::Depth, Layer::DepthOdd, Layer::Direct]);
    ImageSettings { width: 61, height: 47, spp: 40, layers, ..ImageSettings::of(scene) }
}

/// The image of one render from scratch.
fn at_once(scene: &Scene, settings: &ImageSettings) -> Image {
    Renderer::new(scene, settings.clone(), Engine::Wavefront).unwrap().render().unwrap().image
}

/// However a render is stopped and continued, its image is that of one run.
#[test]
fn stops_do_not_change_the_image() {
    let scene = Scene::load("cornell").unwrap();
    let settings = settings(&scene);
    for engine in [Engine::Wavefront, Engine::Scalar] {
        let compute = ComputeSettings { threads: 3, ..engine.into() };
        let session = Session::new(&scene, settings.clone(), compute).unwrap();
        session.render(Until::Time(Duration::ZERO), &()).unwrap();
        session.cancel();
        session.render(Until::Complete, &()).unwrap();
        assert!(!session.is_complete());
        session.render(Until::Samples(7), &()).unwrap();
        let seven = at_once(&scene, &ImageSettings { spp: 7, ..settings.clone() });
        assert_eq!(session.progress().samples, 61 * 47 * 7);
        assert_eq!(session.snapshot().unwrap(), seven);
        session.render(Until::Complete, &()).unwrap();
        assert!(session.is_complete());
        let whole = at_once(&scene, &settings);
        assert_eq!(session.snapshot().unwrap(), whole);
        let depth = session.snapshot_of(&Layers::new([Layer::Depth])).unwrap();
        assert_eq!(depth.layers(), [whole.layer("depth").unwrap().clone()]);
        let tally = session.finish().unwrap().tally;
        assert_eq!(tally.endings.total(), tally.rays.primary, "no path ends twice");
    }
}

/// Stops as soon as a snapshot was taken.
#[derive(Default)]
struct Seen(AtomicBool);

impl Observer for Seen {
    fn progressed(&self, _: Progress) {}

    fn stop(&self) -> Stop {
        if self.0.load(Ordering::Relaxed) { Stop::Now } else { Stop::No }
    }
}

/// Snapshots can be taken while another thread renders, and have all pixels and layers.
#[test]
fn snapshots_are_taken_meanwhile() {
    let scene = Scene::load("cornell").unwrap();
    let settings = ImageSettings { spp: 1 << 16, ..settings(&scene) };
    let session = Session::new(&scene, settings.clone(), Engine::Wavefront).unwrap();
    let seen = Seen::default();
    thread::scope(|scope| {
        let render = scope.spawn(|| session.render(Until::Complete, &seen));
        // A unit has 16 samples of its pixels.
        while session.progress().samples < 16 * 61 * 47 {
            assert!(!render.is_finished());
            thread::yield_now();
        }
        let image = session.snapshot().unwrap();
        assert_eq!(image.layers().len(), 4);
        assert!(image.layers().iter().all(|layer| layer.values().len() == 61 * 47));
        let depths = image.layer("depth").unwrap().values().iter();
        assert!(depths.filter(|depth| depth[0] > 0.0).count() > 61 * 47 / 2);
        let depth = session.snapshot_of(&Layers::new([Layer::Depth])).unwrap();
        assert_eq!(depth.layers().iter().map(|layer| layer.name()).collect::<Vec<_>>(), ["depth"]);
        seen.0.store(true, Ordering::Relaxed);
        render.join().unwrap().unwrap();
    });
    assert!(!session.is_complete());
}

/// Changes of settings begin anew, except for more samples.
#[test]
fn settings_change() {
    let scene = Scene::load("cornell").unwrap();
    let mut settings = settings(&scene);
    let mut session = Session::new(&scene, settings.clone(), Engine::Wavefront).unwrap();
    session.render(Until::Complete, &()).unwrap();
    settings.spp = 50;
    session.set(settings.clone(), Engine::Wavefront).unwrap();
    assert_eq!(session.progress().samples, 61 * 47 * 40, "the render continues");
    let mut file = scene.camera_file().clone();
    file.vfov = 30.0;
    let camera = Some(Camera::try_from(&file).unwrap());
    let other = ImageSettings { camera, width: 30, seed: 5, ..settings.clone() };
    for settings in [settings, other] {
        session.set(settings.clone(), Engine::Wavefront).unwrap();
        session.render(Until::Complete, &()).unwrap();
        assert_eq!(session.snapshot().unwrap(), at_once(&scene, &settings));
        assert!(session.set(ImageSettings { width: 0, ..settings }, Engine::Wavefront).is_err());
        assert!(session.is_complete(), "an error changes nothing");
    }
}

const LOOK: &str = r#"(
    camera: (look_from: (0, 0, 4), look_at: (0, 0, 0), vfov: 40),
    background: constant(radiance: BACKGROUND),
    render: (width: 32, height: 32, spp: 20, depth: 4, sampling: mis),
    materials: {
        "lamp": light(radiance: LAMP),
        "ball": lambertian(albedo: BALL),
        "leaf": lambertian(albedo: (0.2, 0.5, 0.1), opacity: blend(alpha: 0.5)),
    },
    lights: [point(position: (2, 2, 2), intensity: POINT)],
    primitives: [
        quad(q: (-5, -5, 0), u: (3, 0, 0), v: (0, 10, 0), material: "lamp"),
        sphere(center: (0.6, 0.7, 0), radius: 0.4, material: "ball"),
        triangles(vertices: [(0.1, -1, 0), (0.6, -1, 0), (0.1, -0.2, 0)], indices: [(0, 1, 2)], material: "leaf"),
    ],
)"#;

fn look(values: [&str; 4]) -> Scene {
    let names = ["BACKGROUND", "LAMP", "BALL", "POINT"];
    let text = names
        .iter()
        .zip(values)
        .fold(LOOK.to_owned(), |text, (name, value)| text.replace(name, value));
    Scene::from_ron(&text).unwrap()
}

/// A changed scene has the image of a scene that was loaded with these values.
#[test]
fn looks_change_without_new_trees() {
    let before = look(["(0.1, 0.2, 0.3)", "(3, 2, 1)", "(0.5, 0.5, 0.5)", "(1, 1, 1)"]);
    let after = look(["(0.3, 0.2, 0.1)", "(1, 2, 3)", "(0.9, 0.1, 0.5)", "(2, 3, 4)"]);
    let settings = ImageSettings::of(&before);
    let mut session = Session::new(&before, settings.clone(), Engine::Wavefront).unwrap();
    session.render(Until::Samples(3), &()).unwrap();
    let wanted = after.look();
    session.change_look(|look| *look = wanted).unwrap();
    assert_eq!(session.progress().samples, 0);
    session.render(Until::Complete, &()).unwrap();
    assert_eq!(session.snapshot().unwrap().hash(), at_once(&after, &settings).hash());
    assert_eq!(session.renderer().prepared().scene().hash(), after.hash());
}

/// What needs new shapes, lights or files is refused, and the session stays as it is.
#[test]
fn other_looks_are_refused() {
    let scene = look(["(0.1, 0.2, 0.3)", "(3, 2, 1)", "(0.5, 0.5, 0.5)", "(1, 1, 1)"]);
    let mut session = Session::new(&scene, ImageSettings::of(&scene), Engine::Wavefront).unwrap();
    session.render(Until::Samples(3), &()).unwrap();
    let mut refused = |wanted: &str, change: fn(&mut Look)| {
        let error = session.change_look(change).unwrap_err().to_string();
        assert!(error.contains(wanted), "{error}");
        assert_eq!(session.progress().samples, 32 * 32 * 3, "an error changes nothing");
    };
    refused("opacity", |look| set(look, "leaf", Lambertian::new([0.5; 3])));
    refused("role as a light", |look| set(look, "lamp", Lambertian::new([0.5; 3])));
    refused("1 lights instead of 2", |look| look.lights.clear());
    refused("added, removed or renamed", |look| look.materials.0[1].0 = "other".to_owned());
    refused("albedo", |look| set(look, "ball", Lambertian::new([7.0; 3])));
    refused("radiance", |look| look.background = Background::Constant { radiance: [f32::NAN; 3] });
}

fn set(look: &mut Look, name: &str, material: Lambertian) {
    look.materials.0.iter_mut().find(|(known, _)| known == name).unwrap().1 = material.into();
}
