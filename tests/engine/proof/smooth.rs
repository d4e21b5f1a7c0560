//! Furnace tests of smooth meshes: under uniform light, a closed mesh that absorbs nothing vanishes.

use ptfast::glam::Vec3;
use ptfast::{Engine, ImageSettings, Renderer, Roulette, Scene};

/// An octahedron inscribed in the unit sphere, with each face split into four `levels` times.
pub(super) fn sphere(levels: u32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let corners = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];
    let octants =
        [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    let mut faces = octants.map(|face| face.map(|corner: usize| corners[corner])).to_vec();
    for _ in 0..levels {
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let middle = |a: Vec3, b: Vec3| ((a + b) * 0.5).normalize();
                let (x, y, z) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, x, z], [x, b, y], [z, y, c], [x, y, z]]
            })
            .collect();
    }
    let vertices = faces.as_flattened().iter().map(|vertex| vertex.to_array()).collect();
    let indices = (0..faces.len() as u32).map(|i| [0, 1, 2].map(|corner| 3 * i + corner));
    (vertices, indices.collect())
}

/// A smooth ball of a material, under uniform light of radiance 1, seen from z = `from`.
fn scene(material: &str, levels: u32, soft: bool, from: f32) -> Scene {
    let (vertices, indices) = sphere(levels);
    // Vectors are tuples in RON.
    let list = |list: String| list.replace('[', "(").replace(']', ")");
    let inner = |list: &str| list[1..list.len() - 1].to_owned();
    let vertices = inner(&list(format!("{vertices:?}")));
    let indices = inner(&list(format!("{indices:?}")));
    Scene::from_ron(&format!(
        r#"(camera: (look_from: (0.1, 0.2, {from}), look_at: (0, 0, 0), vfov: 20),
            background: constant(radiance: (1, 1, 1)),
            render: (width: 48, height: 48, spp: 64),
            materials: {{"m": {material}}},
            primitives: [triangles(vertices: [{vertices}], indices: [{indices}],
                normals: [{vertices}], soft_terminator: {soft}, material: "m")])"#
    ))
    .unwrap()
}

#[test]
fn smooth_balls_neither_gain_nor_lose_light() {
    for material in [
        "lambertian(albedo: (1, 1, 1))",
        "metal(albedo: (1, 1, 1), fuzz: 0)",
        "dielectric(ior: 1.5, fresnel: exact)",
    ] {
        for (levels, soft) in [(1, true), (1, false), (4, true), (4, false)] {
            let scene = scene(material, levels, soft, 5.0);
            for engine in [Engine::Wavefront, Engine::Scalar] {
                // Roulette would make some paths brighter than the light.
                let settings =
                    ImageSettings { roulette: Roulette::Off, ..ImageSettings::of(&scene) };
                let image =
                    Renderer::new(&scene, settings, engine).unwrap().render().unwrap().image;
                let most = image.pixels().iter().flatten().fold(0.0, |most: f32, c| most.max(*c));
                let mean = image.pixels().iter().flatten().map(|c| f64::from(*c)).sum::<f64>()
                    / (3 * image.pixels().len()) as f64;
                println!(
                    "{material:<45} {levels} {soft:<5} {engine:?}: mean {mean:.5}, most {most}"
                );
                assert!(most <= 1.0 + 1e-4, "{material}: a pixel gains light, {most}");
                // The ball covers three quarters of the picture. The normals of a coarse one differ
                // too much for the bound.
                assert!(mean > if levels == 4 { 0.9925 } else { 0.8 }, "{material}: {mean}");
            }
        }
    }
}

/// Light that shines through the smooth surface of a closed ball would brighten its dark inside.
#[test]
fn no_light_leaks_into_a_smooth_ball() {
    for material in ["lambertian(albedo: (0.5, 0.5, 0.5))", "metal(albedo: (1, 1, 1), fuzz: 1)"] {
        for soft in [true, false] {
            let scene = scene(material, 1, soft, 0.1);
            let settings = ImageSettings::of(&scene);
            let image =
                Renderer::new(&scene, settings, Engine::Wavefront).unwrap().render().unwrap().image;
            assert!(image.pixels().iter().flatten().all(|c| *c == 0.0), "{material}");
        }
    }
}
