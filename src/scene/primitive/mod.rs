//! Primitives of scene files, and groups of primitives, one file per kind.
//!
//! The list in `PrimitiveFile` names them.

mod boxes;
mod instance;
mod materials;
mod mesh;
mod moving_sphere;
mod named_mesh;
mod named_meshes;
mod quad;
mod sphere;
mod triangles;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

pub(crate) use self::materials::{Materials, Ranges};
pub use self::named_mesh::NamedMesh;
use self::named_meshes::NamedMeshes;
pub use super::mesh::Smooth;
use super::{Assets, IndexedMesh, Named, add_tangents, lacks_tangents};
use crate::checks::{Location, MAX_COORDINATE};
use crate::error::Result;
use crate::geometry::{Geometry, Quad, Vertices};
use crate::limits::Budget;
use crate::shading::kinds;

/// Bytes of memory for each triangle while tangents are computed.
const TANGENTS: u64 = 600;

/// Bytes of memory for each row of the tables of colours and tangents while they grow: 16, in up to
/// three copies.
const ROW: u64 = 48;

/// An entry in the list of primitives of a scene file.
pub(crate) trait Expand {
    /// Returns the name of the material. `None` for an instance whose mesh has its own materials.
    fn material(&self) -> Option<&str>;

    /// Checks the parameters and adds the primitives that they describe.
    fn expand(&self, e: &Location<'_>, to: &mut Builder<'_>) -> Result<()>;
}

/// The file of a mesh, its number if the file is a scene of another program, and the bits of its origin.
pub(crate) type MeshKey = (PathBuf, Option<usize>, [u64; 3]);

/// Collects the geometry of a scene while its primitives are expanded.
pub(crate) struct Builder<'a> {
    pub(crate) geometry: Geometry,
    /// The materials of the triangles in `geometry`.
    pub(crate) ranges: Ranges,
    /// The materials of the triangles of meshes that instances place.
    pub(crate) mesh_ranges: Ranges,
    /// The meshes read so far.
    pub(crate) meshes: HashMap<MeshKey, IndexedMesh>,
    groups: NamedMeshes<'a>,
    materials: &'a Materials<'a>,
    /// Folder of the scene file.
    folder: &'a Path,
    assets: &'a dyn Assets,
    budget: &'a Budget,
}

impl<'a> Builder<'a> {
    /// Creates a builder for primitives that may place `meshes`.
    pub(crate) fn new(
        meshes: &'a Named<NamedMesh>,
        materials: &'a Materials<'a>,
        folder: &'a Path,
        assets: &'a dyn Assets,
        budget: &'a Budget,
    ) -> Self {
        Self {
            geometry: Geometry::default(),
            ranges: Ranges::default(),
            mesh_ranges: Ranges::default(),
            meshes: HashMap::new(),
            groups: NamedMeshes::new(meshes),
            materials,
            folder,
            assets,
            budget,
        }
    }

    /// Number of primitives, triangles of meshes and instances so far.
    fn count(&self) -> usize {
        self.geometry.elements() + self.geometry.instances.triangle_count()
    }

    /// Checks that the limits allow `more` primitives, and counts their memory.
    fn room(&self, e: &Location<'_>, more: usize) -> Result<()> {
        let held = self.budget.hold_primitives(self.count(), more);
        held.map_err(|message| e.error(message))
    }

    /// Adds triangles, with tangents and colours if materials need them.
    fn triangles(
        &mut self,
        e: &Location<'_>,
        mut vertices: Vertices,
        mut faces: Vec<[u32; 3]>,
        soft: bool,
    ) -> Result<()> {
        if !self.materials.vertex_colors {
            vertices.colors.clear();
        }
        if self.materials.need_tangents && lacks_tangents(&vertices) {
            self.budget.check(TANGENTS * faces.len() as u64).map_err(|message| e.error(message))?;
            let before = vertices.positions.len();
            add_tangents(&mut vertices, &mut faces).map_err(|message| e.error(message))?;
            let more = vertices.positions.len() - before;
            self.budget.hold_vertices(more).map_err(|message| e.error(message))?;
        }
        let rows = self.geometry.triangles.optional_rows(&vertices);
        self.budget.hold(ROW * rows as u64).map_err(|message| e.error(message))?;
        self.geometry.triangles.add(vertices, faces, soft);
        Ok(())
    }

    /// Adds a quad whose parameters are in range.
    fn quad(&mut self, e: &Location<'_>, [q, u, v]: [[f32; 3]; 3]) -> Result<()> {
        let quad = Quad::new(q.into(), u.into(), v.into()).ok_or_else(|| {
            e.error("the edges must span an area, but they are zero or nearly parallel")
        })?;
        self.geometry.quads.push(quad);
        Ok(())
    }
}

/// Returns the radius after checking its range.
fn radius(e: &Location<'_>, radius: f32) -> Result<f32> {
    let ok = radius > 0.0 && radius <= MAX_COORDINATE;
    e.check(ok, "radius", "above 0 and at most 1e9", radius).map(|()| radius)
}

kinds! {
    /// A primitive, or a group that expands into primitives.
    pub enum PrimitiveFile: pub(crate) Expand {
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
        /// A named mesh, placed by a matrix.
        Instance(InstanceFile) in instance called "instance",
    }
}
