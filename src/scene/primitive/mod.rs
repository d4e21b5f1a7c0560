//! Primitives of scene files, and groups of primitives, one file per kind.
//!
//! The list in `primitive_files!` generates the enum of scene files and the dispatch.

mod boxes;
mod mesh;
mod moving_sphere;
mod quad;
mod sphere;
mod triangles;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::budget::Budget;
use super::mesh::Mesh;
pub use super::mesh::Smooth;
use super::place::{Element, MAX_COORDINATE};
use crate::error::Result;
use crate::geometry::{Geometry, Quad};

/// An entry in the list of primitives of a scene file.
trait Expand {
    /// Checks the parameters and adds the primitives that they describe.
    fn expand(&self, e: &Element<'_>, to: &mut Builder<'_>) -> Result<()>;
}

/// Collects the geometry of a scene while its primitives are expanded.
pub(super) struct Builder<'a> {
    pub(super) geometry: Geometry,
    /// The meshes read so far, by file.
    pub(super) meshes: HashMap<PathBuf, Mesh>,
    /// Folder of the scene file.
    folder: &'a Path,
    budget: &'a Budget,
}

impl<'a> Builder<'a> {
    pub(super) fn new(folder: &'a Path, budget: &'a Budget) -> Self {
        Self { geometry: Geometry::default(), meshes: HashMap::new(), folder, budget }
    }

    /// Checks that the limits allow `more` primitives, and counts their memory.
    fn room(&self, e: &Element<'_>, more: usize) -> Result<()> {
        let held = self.budget.hold_primitives(self.geometry.len(), more);
        held.map_err(|message| e.error(message))
    }

    /// Adds a quad whose parameters are in range.
    fn quad(&mut self, e: &Element<'_>, [q, u, v]: [[f32; 3]; 3]) -> Result<()> {
        let quad = Quad::new(q.into(), u.into(), v.into()).ok_or_else(|| {
            e.error("the edges must span an area, but they are zero or nearly parallel")
        })?;
        self.geometry.quads.push(quad);
        Ok(())
    }
}

/// Returns the radius after checking its range.
fn radius(e: &Element<'_>, radius: f32) -> Result<f32> {
    let ok = radius > 0.0 && radius <= MAX_COORDINATE;
    e.check(ok, "radius", "above 0 and at most 1e9", radius).map(|()| radius)
}

macro_rules! primitive_files {
    ($($(#[doc = $doc:literal])* $name:ident($file:ident) in $module:ident called $word:literal,)*) => {
        $(pub use $module::$file;)*

        /// A primitive, or a group that expands into primitives.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        #[non_exhaustive]
        pub enum PrimitiveFile {
            $($(#[doc = $doc])* $name($file),)*
        }

        $(impl From<$file> for PrimitiveFile {
            fn from(primitive: $file) -> Self {
                Self::$name(primitive)
            }
        })*

        impl PrimitiveFile {
            /// Returns the name of the primitive's kind in scene files.
            pub(super) fn name(&self) -> &'static str {
                match self {
                    $(Self::$name(_) => $word,)*
                }
            }

            /// Returns the name of the primitive's material.
            pub(super) fn material(&self) -> &str {
                match self {
                    $(Self::$name(primitive) => &primitive.material,)*
                }
            }

            /// Checks the parameters and adds the primitives that they describe.
            pub(super) fn expand(&self, e: &Element<'_>, to: &mut Builder<'_>) -> Result<()> {
                match self {
                    $(Self::$name(primitive) => primitive.expand(e, to),)*
                }
            }
        }
    };
}

primitive_files! {
    /// A sphere that does not move.
    Sphere(SphereFile) in sphere called "sphere",
    /// A sphere that moves linearly.
    MovingSphere(MovingSphereFile) in moving_sphere called "moving_sphere",
    /// A parallelogram.
    Quad(QuadFile) in quad called "quad",
    /// A box of six quads.
    Box(BoxFile) in boxes called "box",
    /// A list of triangles.
    Triangles(TrianglesFile) in triangles called "triangles",
    /// A triangle mesh from a file.
    Mesh(MeshFile) in mesh called "mesh",
}
