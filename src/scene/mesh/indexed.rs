//! Indexed triangle meshes.

use glam::Vec3;

use crate::geometry::Triangle;
use crate::math::precise::rotate;
use crate::scene::budget::Budget;
use crate::scene::place::{MAX_COORDINATE, angles};

/// A mesh as its file says it, indices in range and coordinates finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::scene) struct Mesh {
    pub(in crate::scene) vertices: Vec<Vec3>,
    pub(in crate::scene) triangles: Vec<[u32; 3]>,
}

/// A scale about the origin, then rotations about the axes x, y, z in this order, then a translation.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct Transform {
    pub(in crate::scene) scale: f32,
    /// Degrees.
    pub(in crate::scene) rotation: [f32; 3],
    pub(in crate::scene) translation: [f32; 3],
}

impl Mesh {
    /// With the vertices of its triangles alone, where most are of none: placing takes time for each.
    pub(super) fn without_stray_vertices(self) -> Self {
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
    pub(in crate::scene) fn memory(&self) -> u64 {
        12 * (self.vertices.len() + self.triangles.len()) as u64
    }

    /// The transformed triangles that have an area. Computed in f64 and rounded once.
    ///
    /// No ray slips between triangles that share an edge as a whole. Where a vertex lies on an edge
    /// of a neighbour (T-junctions), rays may, and a triangle without area that fills the crack is
    /// left out: it has no normal.
    ///
    /// # Errors
    /// A vertex that is too far away, no triangle with an area, or no memory.
    pub(in crate::scene) fn transformed(
        &self,
        transform: &Transform,
        budget: &Budget,
    ) -> Result<Vec<Triangle>, String> {
        let (vertices, triangles) = (self.vertices.len() as u64, self.triangles.len() as u64);
        // With lists that grow.
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
                Err(format!("a vertex is placed at {moved:?}, it must be within ±1e9"))
            }
        };
        let vertices = self.vertices.iter().map(transformed).collect::<Result<Vec<_>, _>>()?;
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
pub(in crate::scene) fn in_range(vertex: Vec3) -> bool {
    vertex.to_array().iter().all(|c| c.abs() <= MAX_COORDINATE)
}

/// The triangles of a polygon with `corners` corners: a fan about the first.
pub(in crate::scene) fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]])
}
