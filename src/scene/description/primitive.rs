//! Primitives in a scene file.

use serde::{Deserialize, Serialize};

/// A primitive, or a group that is expanded into primitives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
#[non_exhaustive]
pub enum PrimitiveFile {
    /// A still sphere.
    Sphere {
        /// Centre.
        center: [f32; 3],
        /// Radius, above 0.
        radius: f32,
        /// A key of [`SceneFile::materials`](super::SceneFile::materials).
        material: String,
    },
    /// A sphere that moves linearly.
    MovingSphere {
        /// Centre at time 0.
        center: [f32; 3],
        /// Centre at time 1.
        center1: [f32; 3],
        /// Radius, above 0.
        radius: f32,
        /// A key of [`SceneFile::materials`](super::SceneFile::materials).
        material: String,
    },
    /// The parallelogram q + a u + b v, a and b in [0, 1]; its front is the side of u × v.
    Quad {
        /// Corner.
        q: [f32; 3],
        /// Edge.
        u: [f32; 3],
        /// Edge.
        v: [f32; 3],
        /// A key of [`SceneFile::materials`](super::SceneFile::materials).
        material: String,
    },
    /// A box of six quads.
    Box {
        /// Lower corner before rotation.
        min: [f32; 3],
        /// Upper corner before rotation.
        max: [f32; 3],
        /// Right-handed angles about x, then y, then z, through the middle of the box.
        #[serde(default)]
        rotation: [f32; 3],
        /// A key of [`SceneFile::materials`](super::SceneFile::materials).
        material: String,
    },
    /// A list of triangles; their front is where they run counter-clockwise. Those without
    /// area are left out.
    Triangles {
        /// Points.
        vertices: Vec<[f32; 3]>,
        /// Three positions in `vertices` each, from 0.
        indices: Vec<[u32; 3]>,
        /// A key of [`SceneFile::materials`](super::SceneFile::materials).
        material: String,
    },
    /// The triangles of an OBJ or PLY file: its positions and faces, nothing else. Polygons
    /// become fans; triangles without area are left out.
    Mesh {
        /// Path, relative to the scene file.
        file: String,
        /// Factor about the origin, above 0, before the rotation.
        #[serde(default = "PrimitiveFile::default_scale")]
        scale: f32,
        /// Right-handed angles about x, then y, then z, through the origin.
        #[serde(default)]
        rotation: [f32; 3],
        /// Added last.
        #[serde(default)]
        translation: [f32; 3],
        /// A key of [`SceneFile::materials`](super::SceneFile::materials).
        material: String,
    },
}

impl PrimitiveFile {
    fn default_scale() -> f32 {
        1.0
    }

    /// The variant's name in files, and its material.
    pub(in crate::scene) fn kind_and_material(&self) -> (&'static str, &str) {
        match self {
            Self::Sphere { material, .. } => ("sphere", material),
            Self::MovingSphere { material, .. } => ("moving_sphere", material),
            Self::Quad { material, .. } => ("quad", material),
            Self::Box { material, .. } => ("box", material),
            Self::Triangles { material, .. } => ("triangles", material),
            Self::Mesh { material, .. } => ("mesh", material),
        }
    }
}
