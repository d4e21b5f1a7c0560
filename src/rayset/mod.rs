//! Ray sets: the rays that a render traces and what they hit, as files that any program can
//! read, and their replay through each kernel.
//!
//! A set is a folder of raw little-endian arrays and `manifest.json`:
//!
//! | file | content |
//! |---|---|
//! | `spheres.f32` | 8 f32 a sphere: centre at time 0, radius, centre at time 1, 0 |
//! | `quads.f32` | 9 f32 a quad: corner, edge, edge |
//! | `triangles.f32` | 9 f32 a triangle: its vertices |
//! | `<set>.rays` | 6 f32 a ray: origin, direction |
//! | `<set>.range` | 2 f32 a ray: t_min, t_max |
//! | `<set>.time` | 1 f32 a ray; absent when nothing moves |
//! | `<set>.hits` | 8 bytes a ray: t as f32 (+∞ for a miss), primitive as u32 (all ones) |
//!
//! Primitives are numbered as in [`Geometry`]: spheres, quads, triangles. A shadow ray that is
//! occluded has primitive 0, and t means nothing. Paths go by tiles of 8 × 8 pixels row by row, in a
//! tile sample by sample, in a sample row by row; bounces by waves of 4096 paths, segment by
//! segment. The manifest is
//!
//! ```json
//! {"scene": "spheres", "seed": 1, "image": [1280, 720],
//!  "counts": {"spheres": 488, "quads": 0, "triangles": 0},
//!  "sets": [{"name": "primary", "kind": "closest", "rays": 2097152}]}
//! ```
//!
//! with `kind` `closest` or, for shadow rays, `occluded`.

mod files;
mod record;
mod replay;
mod select;

pub(crate) use files::{files, read, write};
pub use record::record;
pub(crate) use replay::{Replay, replay};

use serde::{Deserialize, Serialize};

use crate::accel::{HitBatch, RayBatch};
use crate::geometry::Geometry;

/// Rays of a scene's render, kind by kind.
#[derive(Clone, Debug)]
pub struct RaySets {
    /// Name of the scene.
    pub scene: String,
    /// Seed of the render.
    pub seed: u64,
    /// Width and height of its image.
    pub image: [u32; 2],
    /// What the rays hit.
    pub geometry: Geometry,
    /// The sets, none of them empty.
    pub sets: Vec<RaySet>,
}

/// Rays of one kind.
#[derive(Clone, Debug)]
pub struct RaySet {
    /// `primary`, `bounce` or `shadow`.
    pub name: String,
    /// What is asked of them.
    pub query: Query,
    /// The rays.
    pub rays: RayBatch,
    /// The answers.
    pub hits: HitBatch,
}

/// What is asked of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Query {
    /// The closest hit.
    Closest,
    /// Whether there is any hit: distance 0 and primitive 0 where there is.
    Occluded,
}
