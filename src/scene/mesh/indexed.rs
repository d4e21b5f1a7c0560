//! Indexed triangle meshes.

use std::collections::BTreeSet;
use std::path::Path;

use glam::Vec3;

use crate::geometry::Triangle;
use crate::math::precise::rotate;
use crate::scene::budget::Budget;
use crate::scene::place::{MAX_COORDINATE, angles};

/// A mesh as read from its file. Its indices are in range and its coordinates are finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::scene) struct Mesh {
    pub(in crate::scene) vertices: Vec<Vec3>,
    pub(in crate::scene) triangles: Vec<[u32; 3]>,
    /// Names of the ignored data in the file.
    pub(super) ignored: BTreeSet<&'static str>,
}

/// A scale about the origin, then rotations about the axes x, y and z in this order, then a
/// translation.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct Transform {
    pub(in crate::scene) scale: f32,
    /// Rotation about each axis in degrees.
    pub(in crate::scene) rotation: [f32; 3],
    pub(in crate::scene) translation: [f32; 3],
}

impl Mesh {
    /// If there are more than three vertices per triangle, keeps only the corners of the triangles,
    /// because each vertex takes time to transform.
    pub(super) fn without_stray_vertices(self) -> Self {
        if self.vertices.len() <= 3 * self.triangles.len() {
            return self;
        }
        let corners = self.triangles.iter().flatten();
        Self {
            vertices: corners.map(|&corner| self.vertices[corner as usize]).collect(),
            ignored: self.ignored,
            triangles: (0..self.triangles.len() as u32)
                .map(|t| [0, 1, 2].map(|c| 3 * t + c))
                .collect(),
        }
    }

    /// Returns a message that names the ignored data in `file`, if any.
    pub(in crate::scene) fn ignored(&self, file: &Path) -> Option<String> {
        let names: Vec<&str> = self.ignored.iter().copied().collect();
        (!names.is_empty()).then(|| format!("{}: ignoring {}", file.display(), names.join(", ")))
    }

    /// Returns the bytes of memory that the mesh takes.
    pub(in crate::scene) fn memory(&self) -> u64 {
        12 * (self.vertices.len() + self.triangles.len()) as u64
    }

    /// Returns the transformed vertices, and the triangles that have an area. They are computed in
    /// f64 and rounded once.
    ///
    /// No ray slips between triangles that share a whole edge. Rays may slip through at
    /// T-junctions, which are vertices on the edge of a neighbour. A triangle without area
    /// is left out even if it closes the crack at a T-junction, because it has no normal.
    ///
    /// # Errors
    /// If a vertex ends up too far away, no triangle has an area, or the memory limit is exceeded.
    pub(in crate::scene) fn transformed(
        &self,
        transform: &Transform,
        budget: &Budget,
    ) -> Result<(Vec<Vec3>, Vec<[u32; 3]>), String> {
        let (vertices, triangles) = (self.vertices.len() as u64, self.triangles.len() as u64);
        // Includes the spare capacity of growing lists.
        budget.check(36 * (vertices + triangles) + 108 * triangles)?;
        let turns = angles(transform.rotation);
        let transformed = |vertex: &Vec3| {
            let scaled = vertex.to_array().map(|c| f64::from(c) * f64::from(transform.scale));
            let turned = rotate(scaled, turns);
            let moved =
                std::array::from_fn(|i| (turned[i] + f64::from(transform.translation[i])) as f32);
            let placed = Vec3::from_array(moved);
            if in_range(placed) {
                Ok(placed)
            } else {
                Err(format!("a vertex is placed at {moved:?}, coordinates must be within ±1e9"))
            }
        };
        let vertices = self.vertices.iter().map(transformed).collect::<Result<Vec<_>, _>>()?;
        let has_area = |face: &[u32; 3]| {
            !Triangle { vertices: face.map(|vertex| vertices[vertex as usize]) }.is_degenerate()
        };
        let faces: Vec<_> = self.triangles.iter().copied().filter(has_area).collect();
        if faces.is_empty() {
            return Err(
                "no triangle has an area after the transform, but a mesh needs one".to_owned()
            );
        }
        Ok((vertices, faces))
    }
}

/// Whether the coordinates of a vertex are within the range of a scene.
pub(in crate::scene) fn in_range(vertex: Vec3) -> bool {
    vertex.to_array().iter().all(|c| c.abs() <= MAX_COORDINATE)
}

/// Returns the triangles of the polygon with these corners, as a fan about the first corner.
pub(in crate::scene) fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]])
}
