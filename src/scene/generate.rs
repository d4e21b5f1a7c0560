//! Generated scenes of any size: `cloud:N` and `mesh:N`.
//!
//! They reproduce, number by number, the stress scenes of another renderer's benchmark, so that
//! both programs trace the same primitives. All arithmetic is in f32 and in the order of the source
//! code, except that cube roots are computed in f64 and then rounded. The other program computes
//! the same numbers if its compiler fuses no operations and its math library rounds cube roots
//! correctly. glibc 2.36 rounds them incorrectly for one N in eleven. For N = 1000000, the root is
//! exactly 1.

use std::collections::HashMap;

use glam::Vec3;

use super::background::Background;
use super::description::{CameraFile, SceneFile};
use super::material::{Dielectric, Fresnel, Lambertian, Material, Metal};
use super::named::Named;
use super::primitive::{PrimitiveFile, SphereFile, TrianglesFile};
use crate::error::{Error, Result};
use crate::limits::MAX_GENERATED;
use crate::math::normalize;
use crate::math::precise::cbrt;
use crate::math::random::Stream;

/// A kind of generated scene and its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Generated {
    /// This many spheres in a ball of constant density: a million fill a ball of radius 100.
    Cloud(u32),
    /// About this many triangles: subdivided icosahedra of 20 480 triangles each on a jittered
    /// lattice, and a floor.
    Mesh(u32),
}

impl Generated {
    /// Parses `name`. Returns `None` if it does not have the form `cloud:N` or `mesh:N`.
    ///
    /// # Errors
    /// If N is not a number or is out of range.
    pub(super) fn parse(name: &str) -> Option<Result<Self>> {
        let (kind, count) = name.split_once(':')?;
        let (make, noun): (fn(u32) -> Self, _) = match kind {
            "cloud" => (Self::Cloud, "spheres"),
            "mesh" => (Self::Mesh, "triangles"),
            _ => return None,
        };
        let count = count.parse().ok().filter(|n| (1..=MAX_GENERATED).contains(n));
        Some(count.map(make).ok_or_else(|| {
            Error::Usage(format!("`{name}`: the number of {noun} must be in 1 to {MAX_GENERATED}"))
        }))
    }

    /// The approximate number of primitives.
    pub(super) fn count(self) -> u32 {
        match self {
            Self::Cloud(count) | Self::Mesh(count) => count,
        }
    }

    pub(super) fn scene(self) -> SceneFile {
        match self {
            Self::Cloud(count) => cloud(count),
            Self::Mesh(count) => mesh(count),
        }
    }
}

fn scene(
    look_from: [f32; 3],
    vfov: f32,
    materials: Named<Material>,
    primitives: Vec<PrimitiveFile>,
) -> SceneFile {
    let mut scene = SceneFile::new(CameraFile::new(look_from, [0.0; 3], vfov));
    scene.background = Background::Constant { radiance: [0.70, 0.80, 1.00] };
    (scene.materials, scene.primitives) = (materials, primitives);
    scene
}

/// Spheres of radius 0.1 to 0.5, distributed uniformly in a ball that grows with their number, so
/// that the density is constant. About four in five of the 64 materials are diffuse.
fn cloud(count: u32) -> SceneFile {
    let mut random = Stream::new(12_345);
    let radius = 100.0 * cbrt(f64::from(count as f32 / 1e6)) as f32;
    let materials = (0..64).map(|index| {
        let color = [(); 3].map(|()| 0.2 + 0.7 * random.uniform());
        let albedo = color.into();
        let kind = random.uniform();
        let material: Material = if kind < 0.80 {
            Lambertian { albedo }.into()
        } else if kind < 0.95 {
            Metal { albedo, fuzz: 0.3 * random.uniform() }.into()
        } else {
            Dielectric { ior: 1.5, fresnel: Fresnel::Schlick }.into()
        };
        (format!("m{index}"), material)
    });
    let materials = Named(materials.collect());
    let mut primitives = Vec::with_capacity(count as usize);
    while primitives.len() < count as usize {
        let [x, y, z] = [(); 3].map(|()| 2.0 * random.uniform() - 1.0);
        if x * x + y * y + z * z >= 1.0 {
            continue;
        }
        let sphere = SphereFile {
            center: [x * radius, y * radius, z * radius],
            radius: 0.1 + 0.4 * random.uniform(),
            material: format!("m{}", random.bits() % 64),
        };
        primitives.push(sphere.into());
    }
    scene([0.0, 40.0, 260.0], 45.0, materials, primitives)
}

/// Triangulated spheres on a cubic lattice of pitch 2.4, moved and scaled at random.
fn mesh(count: u32) -> SceneFile {
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
    let gray = Lambertian { albedo: [0.7; 3].into() }.into();
    let material = "gray".to_owned();
    let materials = Named(vec![(material.clone(), gray)]);
    let primitives = vec![TrianglesFile::new(vertices, indices, material).into()];
    scene([0.0, 9.0, 22.0], 35.0, materials, primitives)
}

/// An icosahedron inscribed in the unit sphere. Each face is split into four smaller ones, and this
/// is done `levels` times.
fn icosphere(levels: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    const GOLDEN: f32 = 1.618_034;
    let mut vertices: Vec<Vec3> = Vec::new();
    for [a, b, c] in [[0, 1, 2], [2, 0, 1], [1, 2, 0]] {
        for (one, golden) in [(-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
            let corner = [one, golden * GOLDEN, 0.0];
            vertices.push(normalize(Vec3::new(corner[a], corner[b], corner[c])));
        }
    }
    let mut faces = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push(normalize(vertices[a as usize] + vertices[b as usize]));
                vertices.len() as u32 - 1
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (x, y, z) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, x, z], [b, y, x], [c, z, y], [x, y, z]]
            })
            .collect();
    }
    (vertices, faces)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_parsed() {
        assert_eq!(Generated::parse("cloud:7").unwrap().unwrap(), Generated::Cloud(7));
        assert_eq!(Generated::parse("mesh:20480").unwrap().unwrap(), Generated::Mesh(20_480));
        assert!(Generated::parse("spheres").is_none() && Generated::parse("fog:3").is_none());
        for bad in ["cloud:", "mesh:0", "mesh:-1", "cloud:1e6", "cloud:99999999999"] {
            assert!(Generated::parse(bad).unwrap().is_err(), "{bad}");
        }
    }

    #[test]
    fn scenes_equal_those_of_the_other_renderer() {
        // The hashes are of scenes whose arrays were equal, byte by byte, to those of the other
        // renderer, built without fused multiply-add.
        for (name, hash) in [
            ("cloud:1000", "c70d161d9b1f43f3774e2df8e2cee04cf4cc84e6642b85a87e0b8c8619fffbac"),
            ("mesh:41000", "525cbb066341204e301dfcfee9d45fc1f09cdb2e002a90f3d5198f121fb29f8c"),
        ] {
            assert_eq!(crate::Scene::load(name).unwrap().hash(), hash, "{name}");
        }
    }

    #[test]
    fn an_icosphere_is_closed_and_round() {
        let (vertices, faces) = icosphere(2);
        assert_eq!((vertices.len(), faces.len()), (162, 320));
        let mut edges = HashMap::new();
        for [a, b, c] in faces {
            for edge in [(a, b), (b, c), (c, a)] {
                *edges.entry(edge).or_insert(0) += 1;
            }
        }
        // Every edge occurs once in each direction, so the surface is closed and its faces are
        // oriented consistently.
        assert!(edges.iter().all(|(&(a, b), &n)| n == 1 && edges[&(b, a)] == 1));
        assert!(vertices.iter().all(|v| (v.length_squared() - 1.0).abs() < 1e-6));
    }
}
