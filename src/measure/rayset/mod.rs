//! Ray sets: the rays that a render traces and their hits.
//!
//! They are stored in files that any program can read, and can be replayed through each kernel.
//!
//! A set is a folder of raw little-endian arrays and `manifest.json`:
//!
//! | file | content |
//! |---|---|
//! | `spheres.f32` | 8 f32 per sphere: centre at time 0, radius, centre at time 1, 0 |
//! | `quads.f32` | 9 f32 per quad: corner, edge, edge |
//! | `triangles.f32` | 9 f32 per triangle: its vertices |
//! | `meshes.f32` | 9 f32 per triangle of a mesh, in object space; absent without instances |
//! | `instances.f32` | 12 f32 and 1 u32 per instance: the rows of its matrix, its mesh; absent without instances |
//! | `<set>.rays` | 6 f32 per ray: origin, direction |
//! | `<set>.range` | 2 f32 per ray: t_min, t_max |
//! | `<set>.time` | 1 f32 per ray; absent when nothing moves |
//! | `<set>.hits` | 8 bytes per ray: t as f32, primitive as u32; +∞ and all ones for a miss |
//! | `<set>.instances` | 1 u32 per ray: the instance that was hit, else 0; absent without instances |
//!
//! Primitives are numbered as in [`Geometry`]: spheres, quads, triangles, triangles of meshes. An
//! occluded shadow ray has primitive 0, and its t has no meaning.
//!
//! Paths are ordered by tile of 8 × 8 pixels (row by row), within a tile by sample, and within a
//! sample by pixel (row by row). Bounce and shadow rays are ordered by wave of 4096 paths, within a
//! wave by segment, and within a segment by path.
//!
//! The manifest looks like this:
//!
//! ```json
//! {"scene": "spheres", "seed": 1, "image": [1280, 720],
//!  "counts": {"spheres": 488, "quads": 0, "triangles": 0},
//!  "sets": [{"name": "primary", "kind": "closest", "rays": 2097152}], "origin": [0, 0, 0]}
//! ```
//!
//! The sum of a position and `origin` is in the coordinates of the scene's file.
//! With instances, `counts` also has `meshes`, the number of triangles of each mesh, and `instances`.
//! `kind` is `occluded` for shadow rays and `closest` for all others.

mod arrays;
mod files;
mod instances;
mod record;
mod replay;
mod select;

pub(crate) use files::{files, is_set, read, write};
pub use record::record;
pub(crate) use replay::{Replay, replay};

use serde::{Deserialize, Serialize};

use crate::accel::{HitBatch, RayBatch};
use crate::geometry::Geometry;

/// The rays of a render, in one set per kind.
#[derive(Clone, Debug)]
pub struct RaySets {
    /// Name of the scene.
    pub scene: String,
    /// Seed of the render.
    pub seed: u64,
    /// Width and height of the image.
    pub image: [u32; 2],
    /// The point (0, 0, 0) in the coordinates of the scene's file.
    pub origin: [f64; 3],
    /// The primitives that the rays are traced against.
    pub geometry: Geometry,
    /// The sets, each with at least one ray.
    pub sets: Vec<RaySet>,
}

/// Rays of one kind.
#[derive(Clone, Debug)]
pub struct RaySet {
    /// `primary`, `bounce` or `shadow`.
    pub name: String,
    /// The query that each ray makes.
    pub query: Query,
    /// The rays.
    pub rays: RayBatch,
    /// The hit or miss of each ray.
    pub hits: HitBatch,
}

/// The query that a ray makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Query {
    /// Finds the closest hit.
    Closest,
    /// Finds out whether there is any hit, which is reported as distance 0 and primitive 0.
    Occluded,
}
