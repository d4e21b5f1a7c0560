//! Triangle meshes that scene files name: reading, checking and placing them.

use std::path::Path;

use glam::Vec3;

use super::budget::Budget;
use super::place::{MAX_COORDINATE, angles};
use super::{obj, ply};
use crate::error::{Error, Result};
use crate::geometry::Triangle;
use crate::input::read_bytes;
use crate::limits::Limit;
use crate::math::precise::rotate;

/// A mesh as its file says it, indices in range and coordinates finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Mesh {
    pub(super) vertices: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// How a mesh is placed: scaled about the origin, turned about the axes x, y, z in this order,
/// moved.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placement {
    pub(super) scale: f32,
    /// Degrees.
    pub(super) rotation: [f32; 3],
    pub(super) translation: [f32; 3],
}

impl Mesh {
    /// Reads a `.obj` or `.ply` file. Polygons become fans of triangles; all but positions and
    /// faces is ignored.
    ///
    /// # Errors
    /// Where it cannot be read, is beyond the limits, or its content is wrong: the message names file and
    /// line.
    pub(super) fn read(path: &Path, budget: &Budget) -> Result<Self> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let parse = match extension.as_deref() {
            Some("obj") => obj::parse,
            Some("ply") => ply::parse,
            _ => {
                let message = "no reader for this extension, meshes are .obj or .ply files";
                return Err(Error::input(path.display().to_string(), "", message));
            }
        };
        let name = path.display().to_string();
        let bytes = read_bytes(path, |length| {
            budget.limits.check(Limit::MeshBytes, length).and_then(|()| budget.check(length))
        })?;
        let within = budget.with(bytes.len() as u64);
        let mesh = parse(&name, &bytes, &within)?;
        if mesh.triangles.is_empty() {
            return Err(Error::input(name, "", "no face in it, a mesh needs at least one"));
        }
        Ok(mesh.without_stray_vertices())
    }

    /// With the vertices of its triangles alone, where most are of none: placing takes time for each.
    fn without_stray_vertices(self) -> Self {
        if self.vertices.len() <= 3 * self.triangles.len() {
            return self;
        }
        let corners = self.triangles.iter().flatten();
        Self {
            vertices: corners.map(|&corner| self.vertices[corner as usize]).collect(),
            triangles: (0..self.triangles.len() as u32)
                .map(|t| [0, 1, 2].map(|c| 3 * t + c))
                .collect(),
        }
    }

    /// Bytes of memory that it takes.
    pub(super) fn memory(&self) -> u64 {
        12 * (self.vertices.len() + self.triangles.len()) as u64
    }

    /// The triangles that have an area, placed. Computed in f64 and rounded once.
    ///
    /// No ray slips between triangles that share an edge as a whole. Where a vertex lies on an edge
    /// of a neighbour (T-junctions), rays may, and a triangle without area that fills the crack is
    /// left out: it has no normal.
    ///
    /// # Errors
    /// A vertex that is too far away, no triangle with an area, or no memory.
    pub(super) fn place(
        &self,
        placement: &Placement,
        budget: &Budget,
    ) -> Result<Vec<Triangle>, String> {
        let (vertices, triangles) = (self.vertices.len() as u64, self.triangles.len() as u64);
        // With lists that grow.
        budget.check(36 * (vertices + triangles) + 108 * triangles)?;
        let turns = angles(placement.rotation);
        let place = |vertex: &Vec3| {
            let scaled = vertex.to_array().map(|c| f64::from(c) * f64::from(placement.scale));
            let turned = rotate(scaled, turns);
            let moved =
                std::array::from_fn(|i| (turned[i] + f64::from(placement.translation[i])) as f32);
            let placed = Vec3::from_array(moved);
            if in_range(placed) {
                Ok(placed)
            } else {
                Err(format!("a vertex is placed at {moved:?}, it must be within ±1e9"))
            }
        };
        let vertices = self.vertices.iter().map(place).collect::<Result<Vec<_>, _>>()?;
        let triangles = self
            .triangles
            .iter()
            .map(|indices| Triangle { vertices: indices.map(|index| vertices[index as usize]) });
        let placed: Vec<_> = triangles.filter(|triangle| !triangle.is_degenerate()).collect();
        if placed.is_empty() {
            return Err("no triangle has an area as it is placed".to_owned());
        }
        Ok(placed)
    }
}

/// Whether a vertex may be part of a scene.
pub(super) fn in_range(vertex: Vec3) -> bool {
    vertex.to_array().iter().all(|c| c.abs() <= MAX_COORDINATE)
}

/// The triangles of a polygon with `corners` corners: a fan about the first.
pub(super) fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]])
}
