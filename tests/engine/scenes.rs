//! Tests of built-in scenes and scene file formats, and a comparison with the mean colours of
//! pictures by other programs.

use std::fs;

use ptfast::internals::Source;
use ptfast::material::Lambertian;
use ptfast::texture::{Checker, Image, Texture};
use ptfast::{
    BUILTIN_NAMES, Camera, CameraFile, ImageSettings, Limit, Limits, PixelFilter, Sampling, Scene,
    SceneFile,
};
use ron::extensions::Extensions;

use crate::common::{Estimate, render};
use crate::flat;

/// The report's scenes contain exactly the primitives, materials and camera of the flat files that other
/// programs read.
#[test]
fn built_in_scenes_equal_the_flat_files() {
    let hashes = BUILTIN_NAMES.map(|name| Scene::load(name).unwrap().hash());
    assert_eq!(std::collections::BTreeSet::from(hashes).len(), 5, "five scenes, five hashes");
    // Flat files have no images.
    for name in BUILTIN_NAMES.into_iter().filter(|name| *name != "garden") {
        let built_in = Scene::load(name).unwrap();
        let flat = Scene::from_file(&flat::parse(
            &fs::read_to_string(format!("tests/data/{name}.txt")).unwrap(),
        ))
        .unwrap();
        assert_eq!(built_in.geometry(), flat.geometry(), "{name}");
        assert_eq!(built_in.camera(), flat.camera(), "{name}");
        assert_eq!(built_in.background(), flat.background(), "{name}");
        let size = |scene: &Scene| (scene.defaults().width, scene.defaults().height);
        assert_eq!(size(&built_in), size(&flat), "{name}");
        // Materials have other numbers and names, so compare the material of each primitive.
        for primitive in 0..built_in.geometry().len() as u32 {
            assert_eq!(
                &built_in.material(primitive),
                &flat.material(primitive),
                "{name} {primitive}"
            );
        }
        assert_eq!(built_in.hash(), flat.hash(), "{name}");
        // The images must be equal too.
        let settings =
            ImageSettings { width: 64, height: 36, spp: 2, ..ImageSettings::of(&built_in) };
        let hash = |scene| render(scene, settings.clone()).hash();
        assert_eq!(hash(&built_in), hash(&flat), "{name}");
    }
}

#[test]
fn scenes_round_trip_through_ron_and_json() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    for (from, to) in [
        ("everything.ron", "a.ron"),
        ("picture.png", "picture.png"),
        ("mapped.ron", "mapped.ron"),
        ("bumps.png", "bumps.png"),
    ] {
        fs::copy(format!("tests/data/{from}"), path(to)).unwrap();
    }
    let parsed = Source::find(&path("a.ron")).unwrap().read(&Limits::default()).unwrap();
    fs::write(path("b.ron"), parsed.to_ron()).unwrap();
    fs::write(path("c.json"), parsed.to_json()).unwrap();
    let original = Scene::load(&path("a.ron")).unwrap();
    let settings = ImageSettings::of(&original);
    assert_eq!((settings.width, settings.depth, settings.sampling), (30, 7, Sampling::Light));
    assert_eq!(original.geometry().len(), 6 + 2 + 6 + 2);
    let hash = render(&original, settings.clone()).hash();
    for name in ["b.ron", "c.json"] {
        let again = Source::find(&path(name)).unwrap().read(&Limits::default()).unwrap();
        assert_eq!(again.file, parsed.file, "{name}");
        let scene = Scene::load(&path(name)).unwrap();
        assert_eq!(scene.hash(), original.hash(), "{name}");
        assert_eq!(render(&scene, settings.clone()).hash(), hash, "{name}");
    }
    let mapped = path("mapped.ron");
    for name in BUILTIN_NAMES.into_iter().chain([&*mapped]) {
        let parsed = Source::find(name).unwrap().read(&Limits::default()).unwrap();
        fs::write(path("d.json"), parsed.to_json()).unwrap();
        fs::write(path("d.ron"), parsed.to_ron()).unwrap();
        for file in ["d.json", "d.ron"] {
            assert_eq!(
                Source::find(&path(file)).unwrap().read(&Limits::default()).unwrap().file,
                parsed.file
            );
        }
    }
}

#[test]
fn cameras_are_made_in_code() {
    let mut file = CameraFile::new([3.0, 2.0, 4.0], [0.0; 3], 40.0);
    let scene = Scene::from_file(&SceneFile::new(file.clone())).unwrap();
    assert_eq!(&Camera::try_from(&file).unwrap(), scene.camera());
    file.vfov = 180.0;
    let error = Camera::try_from(&file).unwrap_err().to_string();
    assert_eq!(error, "scene: camera: vfov must be in (0, 180) degrees, is 180.0");
}

#[test]
fn filters_are_written_and_belong_to_the_identity() {
    let mut file = SceneFile::new(CameraFile::new([3.0, 2.0, 4.0], [0.0; 3], 40.0));
    let mut hashes = std::collections::HashSet::new();
    for (filter, text) in [
        (PixelFilter::Box, "box"),
        (PixelFilter::Gaussian { radius: 1.5, sigma: 0.5 }, "gaussian()"),
        (PixelFilter::Gaussian { radius: 1.5, sigma: 0.75 }, "gaussian(sigma: 0.75)"),
        (PixelFilter::Triangle { radius: 1.0 }, "triangle()"),
        (PixelFilter::Mitchell { radius: 2.0, b: 1.0 / 3.0, c: 1.0 / 3.0 }, "mitchell()"),
        (PixelFilter::BlackmanHarris { radius: 1.5 }, "blackman_harris(radius: 1.5)"),
    ] {
        file.camera.filter = filter;
        let scene = Scene::from_file(&file).unwrap();
        let ron = "(camera: (look_from: (3, 2, 4), look_at: (0, 0, 0), vfov: 40, filter: FILTER))";
        assert_eq!(Scene::from_ron(&ron.replace("FILTER", text)).unwrap(), scene, "{text}");
        let json = serde_json::to_string(&file).unwrap();
        assert_eq!(json.contains("filter"), filter != PixelFilter::Box, "{json}");
        assert_eq!(serde_json::from_str::<SceneFile>(&json).unwrap(), file);
        assert!(hashes.insert(scene.hash()), "{text} has the hash of another filter");
    }
    let hash = Scene::from_file(&file).unwrap().hash();
    file.add_camera("other", CameraFile::new([1.0; 3], [0.0; 3], 40.0));
    assert_eq!(Scene::from_file(&file).unwrap().hash(), hash, "unused cameras do not matter");
    file.add_camera("other", CameraFile::new([1.0; 3], [0.0; 3], 40.0));
    let refused = Scene::from_file(&file).unwrap_err().to_string();
    assert_eq!(refused, "scene:cameras: camera: the name `other` is used twice");
}

/// Mean linear RGB from two independent path tracers that use Embree, without direct light
/// sampling. The last digit is uncertain by ±1.
const MEANS: [(&str, [f64; 3]); 4] = [
    ("spheres", [0.3277, 0.3530, 0.4454]),
    ("spacetime", [0.3244, 0.3494, 0.4423]),
    ("checker", [0.0973, 0.0920, 0.0960]),
    ("cornell", [0.1805, 0.1610, 0.1464]),
];

/// All sampling modes agree with these means, and with each other, within 0.5% in every channel. 16
/// seeds give a mean and its standard error. 3.3 standard errors must be below 0.35% of the mean,
/// so that chance alone rarely exceeds the tolerance: a normal error exceeds 3.3 standard errors
/// with a probability of 0.1%.
#[test]
fn means_agree_with_other_programs() {
    for (name, want) in MEANS {
        let scene = Scene::load(name).unwrap();
        let modes: &[Sampling] =
            if scene.lights() == 0 { &[Sampling::Bsdf] } else { &crate::common::SAMPLINGS };
        let mut by_scattering = None;
        for &sampling in modes {
            // Enough paths for the noise of each scene, at a lower resolution of the same picture.
            let (width, height, spp) = match (name, sampling) {
                ("cornell", Sampling::Bsdf) => (200, 200, 64),
                ("cornell", _) => (200, 200, 8),
                ("checker", Sampling::Bsdf) => (320, 180, 16),
                _ => (320, 180, 8),
            };
            let means: Vec<[f64; 3]> = (0..16)
                .map(|seed| {
                    let base = ImageSettings::of(&scene);
                    render(&scene, ImageSettings { width, height, spp, seed, sampling, ..base })
                        .mean()
                })
                .collect();
            for (channel, want) in want.into_iter().enumerate() {
                let values: Vec<f64> = means.iter().map(|mean| mean[channel]).collect();
                let Estimate { mean, error } = Estimate::of(&values);
                let what = format!(
                    "{name} {sampling:?} channel {channel}: {mean:.5} ± {error:.5}, want {want}"
                );
                assert!(3.3 * error < 0.0035 * want, "the standard error is too large: {what}");
                assert!((mean - want).abs() < 0.005 * want, "{what}");
                if let Some(bsdf) = by_scattering.map(|means: [f64; 3]| means[channel]) {
                    assert!((mean - bsdf).abs() < 0.005 * bsdf, "{what}, bsdf {bsdf}");
                }
            }
            by_scattering.get_or_insert_with(|| {
                [0, 1, 2].map(|channel| {
                    means.iter().map(|mean| mean[channel]).sum::<f64>() / means.len() as f64
                })
            });
        }
    }
}

/// A scene built in code whose material has an unnamed texture.
fn with_texture(texture: impl Into<Texture>) -> SceneFile {
    let mut file = SceneFile::new(CameraFile::new([0.0, 0.0, 5.0], [0.0; 3], 40.0));
    file.add_material("a", Lambertian::new(texture.into()));
    file.add_sphere([0.0; 3], 1.0, "a");
    file
}

#[test]
fn textures_without_names_are_written_and_read() {
    let checker = Checker { odd: [0.0; 3], even: [1.0; 3], scale: 2.0 };
    for file in [with_texture(checker), with_texture(Image::from_file("tests/data/picture.png"))] {
        let hash = Scene::from_file(&file).unwrap().hash();
        let json = serde_json::to_string(&file).unwrap();
        let again: SceneFile = serde_json::from_str(&json).unwrap();
        assert_eq!(again, file);
        let options = ron::Options::default();
        let options = options.with_default_extension(Extensions::UNWRAP_VARIANT_NEWTYPES);
        let ron = options.to_string(&file).unwrap();
        assert_eq!(Scene::from_ron(&ron).unwrap().hash(), hash, "{ron}");
    }
}

#[test]
fn names_used_twice_are_refused() {
    let mut file = with_texture(Image::from_file("tests/data/picture.png"));
    file.add_material("a", Lambertian::new([0.5; 3]));
    let refused = Scene::from_file(&file).unwrap_err().to_string();
    assert_eq!(refused, "scene:materials: material: the name `a` is used twice");
}

#[test]
fn scenes_in_code_have_folders_and_limits() {
    let file = with_texture(Image::from_file("picture.png"));
    let load = |limits: &Limits| Scene::from_file_within(&file, "tests/data".as_ref(), limits);
    assert!(load(&Limits::default()).is_ok() && Scene::from_file(&file).is_err());
    let refused = load(&Limits::default().with(Limit::TextureBytes, 1)).unwrap_err().to_string();
    assert!(refused.contains("the limit of texture-bytes is 1"), "{refused}");
}

/// Channels and factors mean the same in RON and JSON, and survive being written.
#[test]
fn parameters_of_textures_are_read_and_written() {
    let limits = Limits::default();
    let resolve = |text: &str| {
        let parsed = Source::from_reader(text.as_bytes(), &limits).unwrap().read(&limits).unwrap();
        let hash = parsed.resolve().unwrap_or_else(|error| panic!("{error}: {text}")).hash();
        (hash, parsed.to_ron(), parsed.to_json())
    };
    let mut hashes = Vec::new();
    for parameters in [
        "",
        "roughness: \"t\"",
        "roughness: (texture: \"t\", channel: g)",
        "roughness: (texture: \"t\", channel: a)",
        "roughness: (texture: \"t\", channel: a, factor: 0.5)",
        "base_color: \"t\"",
        "base_color: (texture: \"t\", factor: (0.1, 0.2, 0.3))",
        "attenuation_distance: 2, attenuation_color: (0.5, 1, 1)",
        "opacity: blend(alpha: (texture: \"t\", channel: b))",
    ] {
        let (hash, ron, json) = resolve(&format!(
            r#"(camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 40),
                textures: {{"t": image(file: "tests/data/picture.png", wrap_u: mirror, filter: nearest)}},
                materials: {{"a": principled({parameters})}},
                primitives: [triangles(vertices: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], indices: [(0, 1, 2)], material: "a")],
                lights: [point(position: (0, 2, 0), intensity: (1, 1, 1))])"#
        ));
        assert_eq!(resolve(&ron).0, hash, "{ron}");
        assert_eq!(resolve(&json).0, hash, "{json}");
        assert!(!hashes.contains(&hash), "{parameters} changes nothing");
        hashes.push(hash);
    }
}
