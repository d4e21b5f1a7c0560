//! Tests of images without a background and of their alpha channel.

use ptfast::internals::alpha;
use ptfast::{Engine, Image, ImageSettings, Renderer, Scene};

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

/// The image and its alpha channel.
fn render(scene: &Scene, transparent: bool, engine: Engine) -> (Image, Vec<f32>) {
    let settings = ImageSettings { transparent, ..ImageSettings::of(scene) };
    let renderer = Renderer::new(scene, settings, engine).unwrap();
    let alpha = alpha(&renderer).unwrap();
    (renderer.render().unwrap().image, alpha)
}

/// The background is white, so a pixel lacks as much light as it lacks alpha.
#[test]
fn the_background_is_hidden_where_alpha_is_missing() {
    let scene = Scene::from_ron(SCENE).unwrap();
    let (hidden, alpha) = render(&scene, true, Engine::Wavefront);
    let (shown, same) = render(&scene, false, Engine::Wavefront);
    assert_eq!(alpha, same);
    let scalar = render(&scene, true, Engine::Scalar);
    assert_eq!((hidden.hash(), &alpha), (scalar.0.hash(), &scalar.1));
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
    let (_, alpha) = render(&scene, true, Engine::Wavefront);
    assert!(alpha.iter().all(|alpha| (0.0..=1.0).contains(alpha)));
    // The radius of the filter is 2 pixels.
    let of = |x: usize, y: usize| alpha[y * 32 + x];
    assert_eq!([of(3, 9), of(22, 8), of(31, 1)], [1.0, 1.0, 0.0], "lamp, glass, background");
}
