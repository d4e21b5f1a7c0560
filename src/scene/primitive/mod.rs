//! Primitives of scene files, and groups of primitives: one file each.
//!
//! The list in `primitive_files!` makes the enum of scene files and the dispatch.

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
use super::place::{Element, MAX_COORDINATE};
use crate::error::Result;
use crate::geometry::{Geometry, Quad};

/// An entry in the list of primitives of a scene file.
trait Expand {
    /// Checks the parameters, and adds the primitives that they stand for.
    fn expand(&self, e: &Element<'_>, to: &mut Builder<'_>) -> Result<()>;
}

/// A geometry while it grows.
pub(super) struct Builder<'a> {
    pub(super) geometry: Geometry,
    /// The meshes that were read, by file.
    pub(super) meshes: HashMap<PathBuf, Mesh>,
    /// Where the scene file is.
    folder: &'a Path,
    budget: &'a Budget,
}

impl<'a> Builder<'a> {
    pub(super) fn new(folder: &'a Path, budget: &'a Budget) -> Self {
        Self { geometry: Geometry::default(), meshes: HashMap::new(), folder, budget }
    }

    /// Checks that there is room for `more` primitives.
    fn room(&self, e: &Element<'_>, more: usize) -> Result<()> {
        let held = self.budget.hold_primitives(self.geometry.len(), more);
        held.map_err(|message| e.error(message))
    }

    /// Adds a quad whose parameters are in range.
    fn quad(&mut self, e: &Element<'_>, [q, u, v]: [[f32; 3]; 3]) -> Result<()> {
        let quad = Quad::new(q.into(), u.into(), v.into()).ok_or_else(|| {
            e.error("the edges must span an area, they are zero or (all but) parallel")
        })?;
        self.geometry.quads.push(quad);
        Ok(())
    }
}

/// Checks a radius.
fn radius(e: &Element<'_>, radius: f32) -> Result<f32> {
    let ok = radius > 0.0 && radius <= MAX_COORDINATE;
    e.check(ok, "radius", "above 0 and at most 1e9", radius).map(|()| radius)
}

macro_rules! primitive_files {
    ($($(#[doc = $doc:literal])* $name:ident($file:ident) in $module:ident called $word:literal,)*) => {
        $(pub use $module::$file;)*

        /// A primitive, or a group that is expanded into primitives.
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
            /// The name of its kind in scene files.
            pub(super) fn name(&self) -> &'static str {
                match self {
                    $(Self::$name(_) => $word,)*
                }
            }

            /// The name of its material.
            pub(super) fn material(&self) -> &str {
                match self {
                    $(Self::$name(primitive) => &primitive.material,)*
                }
            }

            /// Checks the parameters, and adds the primitives that they stand for.
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
