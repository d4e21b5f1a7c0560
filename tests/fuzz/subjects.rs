//! The functions that are fuzzed.
//!
//! Each takes arbitrary bytes as the content of a file. It must not panic, hang or exceed its memory limit, and the
//! data that it accepts must be valid.

#![allow(dead_code, unreachable_pub)] // each target uses only one

use std::fs;
use std::path::Path;

use ptfast::internals::{Checkpoint, Source};
use ptfast::{
    ComputeSettings, Engine, Image, ImageSettings, Limit, Limits, Metadata, Renderer, Sampling,
    Scene,
};

/// A function to fuzz.
pub type Subject = fn(&[u8]);

/// All subjects with their names.
pub const ALL: [(&str, Subject); 13] = [
    ("scene_ron", scene_ron),
    ("scene_json", scene_json),
    ("scene_pbrt", scene_pbrt),
    ("scene_gltf", scene_gltf),
    ("mesh_mtl", mesh_mtl),
    ("mesh_obj", mesh_obj),
    ("mesh_ply", mesh_ply),
    ("texture", texture),
    ("texture_pfm", texture_pfm),
    ("texture_tga", texture_tga),
    ("checkpoint", checkpoint),
    ("record", record),
    ("render", render),
];

fn limits() -> Limits {
    let limits = Limits::default().with(Limit::Memory, 64 << 20);
    limits.with(Limit::Primitives, 10_000).with(Limit::Pixels, 1 << 20)
}

/// Files that scenes of other programs in the corpora name.
const BESIDE: [(&str, &[u8]); 7] = [
    ("grid.png", include_bytes!("../data/import/grid.png")),
    ("tilted.png", include_bytes!("../data/import/tilted.png")),
    ("sky.pfm", include_bytes!("../data/import/sky.pfm")),
    ("quad.ply", include_bytes!("../data/import/quad.ply")),
    ("quad.ply.gz", include_bytes!("../data/import/quad.ply.gz")),
    ("part.pbrt", include_bytes!("../data/import/part.pbrt")),
    ("state.pbrt.gz", include_bytes!("../data/import/state.pbrt.gz")),
];

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("cannot create a temporary folder");
    for (name, bytes) in BESIDE {
        fs::write(folder.path().join(name), bytes).expect("cannot write the file");
    }
    folder
}

/// Calls `use_it` with a file of this name and content in a temporary folder, which also has the
/// files of [`BESIDE`].
fn in_file<T>(name: &str, bytes: &[u8], use_it: impl FnOnce(&Path) -> T) -> T {
    thread_local! {
        static FOLDER: tempfile::TempDir = folder();
    }
    FOLDER.with(|folder| {
        let path = folder.path().join(name);
        fs::write(&path, bytes).expect("cannot write the file");
        use_it(&path)
    })
}

/// Loads a scene. An accepted scene must stay the same when it is written and read again.
fn scene(name: &str, bytes: &[u8]) -> Option<Scene> {
    in_file(name, bytes, |path| {
        let read = |path: &Path| Source::find(&path.display().to_string())?.read(&limits());
        let parsed = read(path).ok()?;
        let scene = parsed.resolve().ok()?;
        for (again, text) in [("again.ron", parsed.to_ron()), ("again.json", parsed.to_json())] {
            let again = in_file(again, text.as_bytes(), |path| read(path)?.resolve());
            match again {
                Ok(again) => assert_eq!(again.hash(), scene.hash()),
                // The text may be longer now, because numbers can have more digits.
                Err(error) => assert!(error.to_string().contains("limit of memory"), "{error}"),
            }
        }
        Some(scene)
    })
}

pub fn scene_ron(bytes: &[u8]) {
    scene("a.ron", bytes);
}

pub fn scene_json(bytes: &[u8]) {
    scene("a.json", bytes);
}

pub fn scene_pbrt(bytes: &[u8]) {
    scene("a.pbrt", bytes);
}

pub fn scene_gltf(bytes: &[u8]) {
    scene("a.gltf", bytes);
}

/// Loads a mesh with this file of materials.
pub fn mesh_mtl(bytes: &[u8]) {
    const MESH: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n\
        usemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 1/1 3/3 2/2\n";
    in_file("m.mtl", bytes, |_| scene("m.obj", MESH.as_bytes()));
}

/// Loads a mesh file through a scene that names it, and through one that places it with the materials
/// that the file names.
fn mesh(name: &str, bytes: &[u8]) {
    let instance = "instance(mesh: \"a\", matrix: ((2, 0, 0, 0), (0, 1, 0, 0), (0, 0, -1, 3)))";
    in_file(name, bytes, |_| {
        for primitive in [&format!("mesh(file: \"{name}\", material: \"m\")"), instance] {
            let scene = format!(
                "(camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 40), \
                 materials: {{\"m\": lambertian(albedo: (0.5, 0.5, 0.5)), \"l\": light(radiance: (1, 1, 1))}}, \
                 meshes: {{\"a\": \"{name}\"}}, primitives: [{primitive}])"
            );
            let scene = in_file("a.ron", scene.as_bytes(), |path| {
                Scene::load_within(&path.display().to_string(), &limits())
            });
            for triangle in scene.iter().flat_map(|scene| scene.geometry().triangles.iter()) {
                let in_range = |c: f32| c.abs() <= 1e9;
                assert!(triangle.vertices.iter().all(|v| v.to_array().into_iter().all(in_range)));
            }
        }
    });
}

pub fn mesh_obj(bytes: &[u8]) {
    mesh("m.obj", bytes);
}

pub fn mesh_ply(bytes: &[u8]) {
    mesh("m.ply", bytes);
}

fn image(name: &str, bytes: &[u8]) {
    let allow = |pixels: u64, memory: u64| limits().check_image(pixels, memory);
    in_file(name, bytes, |path| {
        let _ = Metadata::read(path);
        if let Ok(image) = Image::read_where(path, &allow) {
            let pixels = u64::from(image.width()) * u64::from(image.height());
            assert_eq!(image.pixels().len() as u64, pixels);
            assert!((1..=1 << 20).contains(&pixels));
        }
    });
}

pub fn texture(bytes: &[u8]) {
    image("t.png", bytes);
}

pub fn texture_tga(bytes: &[u8]) {
    image("t.tga", bytes);
}

pub fn texture_pfm(bytes: &[u8]) {
    image("t.pfm", bytes);
}

/// Loads a checkpoint. A valid hash is appended, so that the fuzzer passes the check of the hash.
pub fn checkpoint(bytes: &[u8]) {
    let hash = blake3::hash(bytes);
    let whole = [bytes, hash.as_bytes()].concat();
    in_file("a.film", &whole, |path| {
        let Ok(checkpoint) = Checkpoint::read(path, &limits()) else { return };
        let film = &checkpoint.rendering.film;
        assert!(
            film.samples_done() <= film.samples_to_do() && checkpoint.rendering.percent() <= 100
        );
        assert_eq!(
            film.means().expect("the limits allow this film").len() as u64,
            film.area().pixels()
        );
        let again = path.with_file_name("again.film");
        checkpoint.write(&again).expect("cannot write the checkpoint");
        assert!(Checkpoint::read(&again, &limits()).is_ok());
    });
}

/// Loads the record of a bench.
pub fn record(bytes: &[u8]) {
    in_file("a.json", bytes, |path| {
        let _ = ptfast::internals::check_record(path);
    });
}

/// Renders every accepted scene. Both engines must give the same image and only finite samples.
pub fn render(bytes: &[u8]) {
    let Some(scene) = scene("a.ron", bytes) else { return };
    let images = Engine::ALL.map(|engine| {
        let settings = ImageSettings {
            width: 8,
            height: 8,
            spp: 2,
            depth: 8,
            sampling: if bytes.len().is_multiple_of(2) { Sampling::Mis } else { Sampling::Light },
            ..ImageSettings::of(&scene)
        };
        let compute = ComputeSettings { threads: 1, ..engine.into() };
        let renderer = Renderer::new(&scene, settings, compute);
        let render = renderer.and_then(|renderer| renderer.render());
        let render = render.expect("an accepted scene must render");
        assert_eq!(render.tally.non_finite.count, 0, "{:?}", render.tally.non_finite);
        (render.image.hash(), render.tally)
    });
    assert_eq!(images[0], images[1]);
}
