//! Generated scenes of any size: `cloud:N`, `mesh:N` and `forest:N`.
//!
//! `cloud` and `mesh` reproduce, number by number, the stress scenes of another renderer's benchmark,
//! so that both programs trace the same primitives. All arithmetic is in f32 and in the order of the
//! source code, except that cube roots are computed in f64 and then rounded. The other program
//! computes the same numbers if its compiler fuses no operations and its math library rounds cube
//! roots correctly. glibc 2.36 rounds them incorrectly for one N in eleven. For N = 1000000, the root
//! is exactly 1.

mod cloud;
mod forest;
mod icosphere;
mod mesh;

use crate::error::{Error, Result};
use crate::limits::MAX_GENERATED;
use crate::scene::{Named, PrimitiveFile, Roulette, SceneFile};
use crate::shading::{Background, CameraFile, Material};

/// A kind of generated scene and its size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Generated {
    /// This many spheres in a ball of constant density: a million fill a ball of radius 100.
    Cloud(u32),
    /// About this many triangles: subdivided icosahedra of 20 480 triangles each on a jittered
    /// lattice, and a floor.
    Mesh(u32),
    /// This many trees, bushes and rocks on hills: instances of four smooth meshes.
    Forest(u32),
}

impl Generated {
    /// Parses `name`. Returns `None` if it does not have the form `cloud:N`, `mesh:N` or
    /// `forest:N`.
    ///
    /// # Errors
    /// If N is not a number or is out of range.
    pub(crate) fn parse(name: &str) -> Option<Result<Self>> {
        let (kind, count) = name.split_once(':')?;
        let (make, noun): (fn(u32) -> Self, _) = match kind {
            "cloud" => (Self::Cloud, "spheres"),
            "mesh" => (Self::Mesh, "triangles"),
            "forest" => (Self::Forest, "instances"),
            _ => return None,
        };
        let count = count.parse().ok().filter(|n| (1..=MAX_GENERATED).contains(n));
        Some(count.map(make).ok_or_else(|| {
            Error::Usage(format!("`{name}`: the number of {noun} must be in 1 to {MAX_GENERATED}"))
        }))
    }

    /// The approximate number of primitives and instances.
    pub(crate) fn count(self) -> u32 {
        match self {
            Self::Cloud(count) | Self::Mesh(count) => count,
            Self::Forest(count) => count + forest::TRIANGLES,
        }
    }

    pub(crate) fn scene(self) -> SceneFile {
        match self {
            Self::Cloud(count) => cloud::scene(count),
            Self::Mesh(count) => mesh::scene(count),
            Self::Forest(count) => forest::scene(count),
        }
    }
}

fn scene_of(
    look_from: [f32; 3],
    vfov: f32,
    materials: Named<Material>,
    primitives: Vec<PrimitiveFile>,
) -> SceneFile {
    let mut scene = SceneFile::new(CameraFile::new(look_from, [0.0; 3], vfov));
    scene.background = Background::Constant { radiance: [0.70, 0.80, 1.00] };
    scene.render.roulette = Roulette::From(5);
    (scene.materials, scene.primitives) = (materials, primitives);
    scene
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
}
