//! Tests of the layers of images.

use ptfast::{Engine, FirstHits, Image, ImageSettings, Layer, Layers, Renderer, Roulette, Scene};

/// A lamp, glass, a leaf with holes, and fog, in front of a white background.
const SCENE: &str = r#"(
    camera: (look_from: (0, 0, 4), look_at: (0, 0, 0), vfov: 40),
    background: gradient(bottom: (1, 1, 1), top: (1, 1, 1)),
    render: (width: 32, height: 32, spp: 20, depth: 8, sampling: mis),
    materials: {
        "lamp": light(radiance: (3, 2, 1)),
        "glass": dielectric(ior: 1.5),
        "leaf": lambertian(albedo: (0.2, 0.5, 0.1), opacity: blend(alpha: 0.5)),
    },
    primitives: [
        quad(q: (-5, -5, 0), u: (5, 0, 0), v: (0, 10, 0), material: "lamp"),
        sphere(center: (0.6, 0.7, 0), radius: 0.4, material: "glass"),
        triangles(vertices: [(0.1, -1, 0), (0.6, -1, 0), (0.1, -0.2, 0)], indices: [(0, 1, 2)], material: "leaf"),
    ],
    media: [sphere(center: (0.9, -0.6, 0), radius: 0.4, density: 2, albedo: (0.9, 0.9, 0.9))],
)"#;

fn render(scene: &Scene, settings: ImageSettings, engine: Engine) -> Image {
    Renderer::new(scene, settings, engine).unwrap().render().unwrap().image
}

fn with_all(scene: &Scene) -> ImageSettings {
    ImageSettings { layers: Layers::new(Layer::ALL), ..ImageSettings::of(scene) }
}

fn layer(image: &Image, layer: Layer) -> &[[f32; 3]] {
    image.layer(layer.name()).expect("the settings ask for it").values()
}

fn pixel(image: &Image, wanted: Layer, x: u32, y: u32) -> [f32; 3] {
    layer(image, wanted)[(y * image.width() + x) as usize]
}

/// The background is white, so a pixel lacks as much light as it lacks alpha.
#[test]
fn the_background_is_hidden_where_alpha_is_missing() {
    let scene = Scene::from_ron(SCENE).unwrap();
    let by = |transparent, engine| {
        let settings = ImageSettings { transparent, ..ImageSettings::of(&scene) };
        render(&scene, settings, engine)
    };
    let (hidden, shown) = (by(true, Engine::Wavefront), by(false, Engine::Wavefront));
    let scalar = by(true, Engine::Scalar);
    assert_eq!((hidden.hash(), hidden.alpha()), (scalar.hash(), scalar.alpha()));
    assert_eq!(shown.alpha(), None);
    let alpha = hidden.alpha().unwrap();
    for (i, &alpha) in alpha.iter().enumerate() {
        for (shown, hidden) in shown.pixels()[i].iter().zip(hidden.pixels()[i]) {
            assert!(
                (shown - hidden - (1.0 - alpha)).abs() < 1e-5,
                "pixel {i}: {shown} {hidden} {alpha}"
            );
        }
    }
    // The lamp covers the left half; the leaf lets half of the rays pass, and the fog some.
    let of = |x: usize, y: usize| alpha[y * 32 + x];
    assert!((0..32).all(|y| (0..16).all(|x| of(x, y) == 1.0)));
    assert_eq!((of(22, 8), of(31, 1)), (1.0, 0.0), "glass and background");
    for (x, y) in [(18, 24), (26, 23)] {
        assert!(of(x, y) > 0.1 && of(x, y) < 0.95, "{x}, {y}: {}", of(x, y));
    }
}

/// Pixel filters with negative weights count samples equally, so that pixels without a surface are transparent.
#[test]
fn negative_weights_do_not_change_alpha() {
    let scene = SCENE.replace("vfov: 40", "vfov: 40, filter: mitchell()");
    let scene = Scene::from_ron(&scene).unwrap();
    let settings = ImageSettings { transparent: true, ..ImageSettings::of(&scene) };
    let image = render(&scene, settings, Engine::Wavefront);
    let alpha = image.alpha().unwrap();
    assert!(alpha.iter().all(|alpha| (0.0..=1.0).contains(alpha)));
    // The radius of the filter is 2 pixels.
    let of = |x: usize, y: usize| alpha[y * 32 + x];
    assert_eq!([of(3, 9), of(22, 8), of(31, 1)], [1.0, 1.0, 0.0], "lamp, glass, background");
}

/// Colour is the sum of its parts, also with a filter that has negative weights, and with clamping.
#[test]
fn parts_of_light_add_up_to_the_colour() {
    for (filter, clamp) in [("box", None), ("mitchell()", None), ("mitchell()", Some(1.5))] {
        let scene = SCENE.replace("vfov: 40", &format!("vfov: 40, filter: {filter}"));
        let scene = Scene::from_ron(&scene).unwrap();
        let image = render(&scene, ImageSettings { clamp, ..with_all(&scene) }, Engine::Wavefront);
        let parts = [Layer::Direct, Layer::Indirect, Layer::Emission, Layer::Background];
        for (i, color) in image.pixels().iter().enumerate() {
            for (channel, color) in color.iter().enumerate() {
                let parts = parts.map(|part| layer(&image, part)[i][channel]);
                let size = parts.iter().map(|part| f64::from(part.abs())).sum::<f64>().max(1.0);
                let off = (parts.iter().sum::<f32>() - color).abs();
                assert!(f64::from(off) < 1e-5 * size, "{filter}, pixel {i}: {parts:?} {color}");
            }
        }
        // Only the lamp emits light, and it does not scatter any.
        assert_eq!(pixel(&image, Layer::Background, 3, 9), [0.0; 3]);
        assert_eq!(pixel(&image, Layer::Direct, 3, 9), [0.0; 3]);
        assert_eq!(pixel(&image, Layer::Emission, 31, 1), [0.0; 3]);
        assert_eq!(pixel(&image, Layer::Emission, 22, 8), [0.0; 3]);
    }
}

/// A wall, a mirror in the left half in front of it, and a ball of glass in the right half.
const ROOM: &str = r#"(
    camera: (look_from: (0, 0, 5), look_at: (0, 0, 0), vfov: 40),
    render: (width: 20, height: 20, spp: 16, depth: 8, sampling: bsdf),
    background: constant(radiance: (1, 1, 1)),
    materials: {
        "white": lambertian(albedo: (0.8, 0.8, 0.8)),
        "wall": lambertian(albedo: (0.1, 0.2, 0.3)),
        "mirror": metal(albedo: (0.9, 0.9, 0.9), fuzz: 0),
        "glass": dielectric(ior: 1),
        "behind": lambertian(albedo: (0.5, 0.4, 0.3)),
    },
    primitives: [
        quad(q: (-9, -9, -1), u: (18, 0, 0), v: (0, 18, 0), material: "wall"),
        quad(q: (-2, -2, 0), u: (2, 0, 0), v: (0, 4, 0), material: "mirror"),
        quad(q: (-99, -99, 25), u: (0, 198, 0), v: (198, 0, 0), material: "behind"),
        sphere(center: (0.7, 0, 0), radius: 0.5, material: "glass"),
    ],
)"#;

#[test]
fn values_are_those_of_the_first_hit() {
    let scene = Scene::from_ron(ROOM).unwrap();
    let image = render(&scene, with_all(&scene), Engine::Wavefront);
    let near = |layer: Layer, (x, y): (u32, u32), want: [f32; 3], tolerance: f32| {
        let got = pixel(&image, layer, x, y);
        let close = got.iter().zip(want).all(|(got, want)| (got - want).abs() <= tolerance);
        assert!(close, "{} at {x}, {y}: {got:?}, not {want:?}", layer.name());
    };
    let (wall, mirror, glass) = ((18, 1), (4, 10), (13, 10));
    for (at, depth, albedo, material) in [
        (wall, 6.0, [0.1, 0.2, 0.3], 2.0),
        (mirror, 5.0, [0.9; 3], 3.0),
        (glass, 4.5, [1.0; 3], 4.0),
    ] {
        near(Layer::Alpha, at, [1.0, 0.0, 0.0], 0.0);
        near(Layer::Depth, at, [depth, 0.0, 0.0], if at == glass { 0.05 } else { 1e-4 });
        near(Layer::Albedo, at, albedo, 1e-5);
        near(Layer::Material, at, [material, 0.0, 0.0], 0.0);
        near(Layer::Instance, at, [0.0; 3], 0.0);
        near(Layer::Samples, at, [16.0, 0.0, 0.0], 0.0);
    }
    near(Layer::Normal, wall, [0.0, 0.0, 1.0], 1e-6);
    // Half a pixel is 0.11 wide at the wall, and its quad is 18 wide.
    let half_height = 6.0 * 0.363_970_23; // tan 20°
    let (x, y) = ((2.0 * 18.5 / 20.0 - 1.0) * half_height, (1.0 - 2.0 * 1.5 / 20.0) * half_height);
    near(Layer::Position, wall, [x, y, -1.0], 0.11);
    near(Layer::Uv, wall, [(x + 9.0) / 18.0, (y + 9.0) / 18.0, 0.0], 0.01);
}

/// What lies behind mirrors and clear glass is the first hit, but alpha is that of the camera ray.
#[test]
fn first_hits_follow_mirrors_and_glass() {
    let scene = Scene::from_ron(ROOM).unwrap();
    let settings = ImageSettings { first_hit: FirstHits::Through, ..with_all(&scene) };
    let image = render(&scene, settings, Engine::Wavefront);
    let albedo = |(x, y)| pixel(&image, Layer::Albedo, x, y).map(|c| (c * 1e4).round() / 1e4);
    assert_eq!(albedo((18, 1)), [0.1, 0.2, 0.3], "the wall");
    assert_eq!(albedo((4, 10)), [0.5, 0.4, 0.3], "behind the camera, in the mirror");
    assert_eq!(albedo((13, 10)), [0.1, 0.2, 0.3], "the wall behind the glass");
    assert_eq!(pixel(&image, Layer::Material, 4, 10)[0], 5.0);
    assert!(layer(&image, Layer::Alpha).iter().all(|alpha| alpha[0] == 1.0));
}

/// Halves have about the same values, and their mean is the whole.
#[test]
fn halves_make_the_whole() {
    let scene = Scene::from_ron(SCENE).unwrap();
    for spp in [20, 21] {
        let settings = ImageSettings { spp, ..with_all(&scene) };
        let image = render(&scene, settings, Engine::Wavefront);
        let (odd, all) = ((spp / 2) as f32, spp as f32);
        let halves = [
            (image.pixels(), Layer::ColorEven, Layer::ColorOdd),
            (layer(&image, Layer::Albedo), Layer::AlbedoEven, Layer::AlbedoOdd),
        ];
        for (whole, even_half, odd_half) in halves {
            for (i, whole) in whole.iter().enumerate() {
                let [even_half, odd_half] =
                    [even_half, odd_half].map(|half| layer(&image, half)[i]);
                for (channel, whole) in whole.iter().enumerate() {
                    let sum = even_half[channel] * (all - odd) + odd_half[channel] * odd;
                    assert!((sum / all - whole).abs() < 1e-5, "pixel {i}: {sum} {whole}");
                }
            }
        }
        let [whole, even, odd] =
            [Layer::Depth, Layer::DepthEven, Layer::DepthOdd].map(|l| pixel(&image, l, 18, 24)[0]);
        assert!((whole - even).abs() < 1e-4 && (whole - odd).abs() < 1e-4, "{whole} {even} {odd}");
        assert_eq!(pixel(&image, Layer::DepthOdd, 31, 1), [0.0; 3], "no sample hits anything");
    }
}

/// Pixels that no sample meets have 0 in all layers of the first hit.
#[test]
fn nothing_is_zero() {
    let scene = Scene::from_ron(SCENE).unwrap();
    let image = render(&scene, with_all(&scene), Engine::Wavefront);
    for found in image.layers() {
        let at = found.values()[32 + 31];
        let light = ["background", "color_even", "color_odd"].contains(&found.name());
        assert_eq!(at == [0.0; 3], !light && found.name() != "samples", "{}", found.name());
    }
}

/// Colour does not depend on layers.
#[test]
fn layers_do_not_change_the_colour() {
    for name in ["spheres", "cornell", "tests/data/everything.ron"] {
        let scene = Scene::load(name).unwrap();
        let settings = |layers| ImageSettings {
            width: 40,
            height: 30,
            spp: 5,
            layers,
            ..ImageSettings::of(&scene)
        };
        for engine in [Engine::Wavefront, Engine::Scalar] {
            let [without, with] = [Layers::default(), Layers::new(Layer::ALL)]
                .map(|layers| render(&scene, settings(layers), engine).hash());
            assert_eq!(without, with, "{name}");
        }
    }
}

/// Every build and engine gives the same layers.
#[test]
fn every_build_gives_the_pinned_layers() {
    let scenes = ["spheres", "everything.ron", "instances.ron", "mapped.ron", "glass.ron"];
    let mut lines = Vec::new();
    for (name, first_hit) in
        scenes.into_iter().flat_map(|name| FirstHits::ALL.map(|hit| (name, hit)))
    {
        let path = if name == "spheres" { name.into() } else { format!("tests/data/{name}") };
        let scene = Scene::load(&path).unwrap();
        let (width, height, spp, roulette) = (50, 31, 19, Roulette::From(5));
        let base = ImageSettings { width, height, spp, roulette, ..with_all(&scene) };
        let by = |engine| render(&scene, ImageSettings { first_hit, ..base.clone() }, engine);
        let image = by(Engine::Wavefront);
        assert_eq!(image.layers(), by(Engine::Scalar).layers(), "{name} {}", first_hit.name());
        for layer in image.layers() {
            let hash = image.layer_image(layer).hash();
            lines.push(format!("{name} {} {} {hash}", first_hit.name(), layer.name()));
        }
    }
    let pinned: Vec<&str> = include_str!("../data/layers.txt").lines().collect();
    let wrong = lines.iter().filter(|line| !pinned.contains(&line.as_str()));
    let wrong: Vec<_> = wrong.map(String::as_str).collect();
    assert!(wrong.is_empty(), "not in tests/data/layers.txt:\n{}", wrong.join("\n"));
}
