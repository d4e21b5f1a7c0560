//! Instances look like the triangles that they place.

use ptfast::glam::{DMat3, DVec3, Vec3};
use ptfast::internals::Source;
use ptfast::primitive::{InstanceFile, TrianglesFile};
use ptfast::{Engine, ImageSettings, Limits, Renderer, Scene, SceneFile};

use super::smooth::sphere;

/// A scene with everything but the mesh, whose material is `m`.
fn surroundings(material: &str) -> SceneFile {
    let text = format!(
        r#"(camera: (look_from: (1, 1.5, 6), look_at: (0, 0, 0), vfov: 30),
            background: gradient(bottom: (0.1, 0.2, 0.3), top: (0.9, 0.8, 0.7)),
            render: (width: 64, height: 64, spp: 64),
            textures: {{"picture": image(file: "tests/data/picture.png")}},
            materials: {{"m": {material}, "floor": lambertian(albedo: (0.6, 0.5, 0.4)),
                "lamp": light(radiance: (30, 30, 20))}},
            primitives: [
                quad(q: (-8, -1.5, 8), u: (16, 0, 0), v: (0, 0, -16), material: "floor"),
                sphere(center: (2.5, 3, 2), radius: 0.3, material: "lamp"),
            ])"#
    );
    let source = Source::from_reader(text.as_bytes(), &Limits::default()).unwrap();
    source.read(&Limits::default()).unwrap().file
}

/// The triangles where `matrix` places them, computed in f64.
fn placed(mesh: &TrianglesFile, matrix: &[[f32; 4]; 3]) -> TrianglesFile {
    let rows = matrix.map(|row| row.map(f64::from));
    let linear = DMat3::from_cols_array_2d(&rows.map(|[x, y, z, _]| [x, y, z])).transpose();
    let shift = DVec3::from_array(rows.map(|[.., t]| t));
    let to_normals = linear.inverse().transpose();
    let each = |vectors: &[[f32; 3]], f: &dyn Fn(DVec3) -> DVec3| {
        let f = |v: &[f32; 3]| f(Vec3::from_array(*v).as_dvec3()).as_vec3().to_array();
        vectors.iter().map(f).collect::<Vec<_>>()
    };
    let mut placed = mesh.clone();
    placed.vertices = each(&mesh.vertices, &|v| linear * v + shift);
    placed.normals = each(&mesh.normals, &|n| (to_normals * n).normalize());
    if linear.determinant() < 0.0 {
        placed.indices.iter_mut().for_each(|corners| corners.swap(1, 2));
    }
    placed
}

#[test]
fn instances_look_like_the_triangles_that_they_place() {
    let (vertices, indices) = sphere(3);
    let mut flat = TrianglesFile::new(vertices.clone(), indices, "m");
    // Texture coordinates, too, must be those of the mesh.
    flat.uvs = vertices.iter().map(|[x, y, _]| [0.5 + 0.5 * x, 0.5 + 0.5 * y]).collect();
    let mut smooth = flat.clone();
    smooth.normals = vertices;
    let matrices = [
        [[1.1, 0.2, 0.0, 0.1], [0.0, 0.7, 0.3, 0.2], [-0.4, 0.0, 1.3, -0.3]],
        [[-1.2, 0.0, 0.3, 0.0], [0.5, 0.9, 0.0, 0.1], [0.0, 0.2, 0.8, 0.2]],
        [[0.1, 0.0, 0.0, 0.0], [0.0, 1.2, 0.0, 0.0], [0.0, 0.0, 1.2, 0.0]],
        // A turn and a reflection, which keep the angles between normals.
        [[0.0, 0.96, 0.72, 0.1], [1.2, 0.0, 0.0, 0.0], [0.0, 0.72, -0.96, 0.1]],
    ];
    for material in [
        "lambertian(albedo: \"picture\")",
        "dielectric(ior: 1.5, fresnel: exact)",
        "metal(albedo: (0.9, 0.9, 0.9), fuzz: 0.1)",
        "light(radiance: (2, 1, 1), sides: front)",
    ] {
        for (mesh, kind) in [(&flat, "flat"), (&smooth, "smooth")] {
            for (number, matrix) in matrices.iter().enumerate() {
                let mut flattened = surroundings(material);
                let mut instanced = flattened.clone();
                instanced.add_named_mesh("mesh", mesh.clone());
                instanced.add(InstanceFile::new("mesh", *matrix));
                flattened.add(placed(mesh, matrix));
                let [a, b] = [instanced, flattened].map(|file| {
                    let scene = Scene::from_file(&file).unwrap();
                    let settings = ImageSettings::of(&scene);
                    Renderer::new(&scene, settings, Engine::Wavefront)
                        .unwrap()
                        .render()
                        .unwrap()
                        .image
                });
                let (mut difference, mut sum) = (0.0, 0.0);
                for (a, b) in a.pixels().iter().flatten().zip(b.pixels().iter().flatten()) {
                    difference += f64::from((a - b).abs());
                    sum += f64::from(a + b);
                }
                // The same random numbers are used, so only paths that rounding sends another way
                // differ.
                let relative = 2.0 * difference / sum;
                println!("{material:<60} {kind:<6} {number}: {relative:.6}");
                // Other matrices change the angles, and so the normals between vertices.
                let most = if kind == "smooth" && number < 3 { 0.06 } else { 0.01 };
                assert!(relative < most, "{material} {kind} {number}: {relative}");
            }
        }
    }
}
