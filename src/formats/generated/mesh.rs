//! `mesh:N`, triangles on spheres.

use glam::Vec3;

use super::icosphere::icosphere;
use super::scene_of;
use crate::math::Stream;
use crate::scene::{Named, SceneFile, TrianglesFile};
use crate::shading::material::Lambertian;

/// Triangulated spheres on a cubic lattice of pitch 2.4, moved and scaled at random.
pub(super) fn scene(count: u32) -> SceneFile {
    let (sphere, faces) = icosphere(5);
    let copies = (count / faces.len() as u32).max(1);
    let side = (1..).find(|side: &u32| side.pow(3) >= copies).expect("a large enough cube exists");
    let middle = (side - 1) as f32 * 0.5;
    let mut random = Stream::new(777);
    let (mut vertices, mut indices) = (Vec::new(), Vec::new());
    for copy in 0..copies {
        let cell = [copy % side, copy / side % side, copy / (side * side)];
        let center = cell.map(|cell| (cell as f32 - middle) * 2.4 + 0.6 * random.uniform());
        let center = Vec3::from_array(center);
        let radius = 0.6 + 0.6 * random.uniform();
        let base = vertices.len() as u32;
        vertices.extend(sphere.iter().map(|&v| (v * radius + center).to_array()));
        indices.extend(faces.iter().map(|face| face.map(|vertex| base + vertex)));
    }
    let base = vertices.len() as u32;
    let (floor, reach) = (-(side as f32) * 1.2 - 1.0, 60.0);
    let corners = [(-reach, -reach), (reach, -reach), (reach, reach), (-reach, reach)];
    vertices.extend(corners.map(|(x, z)| [x, floor, z]));
    indices.extend([[base, base + 2, base + 1], [base, base + 3, base + 2]]);
    let gray = Lambertian::new([0.7; 3]).into();
    let material = "gray".to_owned();
    let materials = Named(vec![(material.clone(), gray)]);
    let primitives = vec![TrianglesFile::new(vertices, indices, material).into()];
    scene_of([0.0, 9.0, 22.0], 35.0, materials, primitives)
}
