//! Indexed triangles.

use glam::Vec3;

use super::Triangle;
use crate::math::{Row, row};

/// A list of triangles, which share their vertices where the meshes that they come from do.
///
/// Vertices and triangles are stored as rows of four words, which vectors gather fastest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Triangles {
    /// The indices of each triangle's vertices, and 0.
    corners: Vec<Row>,
    /// The position of each vertex, and 0.
    vertices: Vec<Row>,
}

impl Triangles {
    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.corners.len()
    }

    /// Whether there are no triangles.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// The triangle at `index`, or `None` beyond the end.
    #[inline(always)]
    pub fn get(&self, index: usize) -> Option<Triangle> {
        (index < self.len()).then(|| Triangle { vertices: self.vertices(index) })
    }

    /// The vertices of the triangle at `index`.
    ///
    /// # Panics
    /// If `index` is not below [`Triangles::len`].
    #[inline(always)]
    pub fn vertices(&self, index: usize) -> [Vec3; 3] {
        let [a, b, c, _] = self.corners[index];
        [a, b, c].map(|vertex| position(&self.vertices[vertex as usize]))
    }

    /// All triangles, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Triangle> + '_ {
        (0..self.len()).map(|index| Triangle { vertices: self.vertices(index) })
    }

    /// Appends one triangle with vertices of its own.
    pub fn push(&mut self, triangle: Triangle) {
        self.add(triangle.vertices, [[0, 1, 2]]);
    }

    /// Replaces each vertex by `f` of it.
    pub fn map_vertices(&mut self, f: impl Fn(Vec3) -> Vec3) {
        for vertex in &mut self.vertices {
            *vertex = row(f(position(vertex)), 0.0);
        }
    }

    /// Appends a mesh: the positions of its vertices, and three indices into them for each
    /// triangle.
    ///
    /// # Panics
    /// If there are 2^32 vertices or more.
    pub fn add(
        &mut self,
        positions: impl IntoIterator<Item = Vec3>,
        faces: impl IntoIterator<Item = [u32; 3]>,
    ) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(positions.into_iter().map(|position| row(position, 0.0)));
        assert!(u32::try_from(self.vertices.len()).is_ok(), "a scene has fewer than 2^32 vertices");
        let corners = faces.into_iter().map(|[a, b, c]| [first + a, first + b, first + c, 0]);
        self.corners.extend(corners);
    }

    /// The rows of the triangles and of their vertices.
    #[inline(always)]
    pub(super) fn rows(&self) -> (&[Row], &[Row]) {
        (&self.corners, &self.vertices)
    }
}

impl Extend<Triangle> for Triangles {
    fn extend<I: IntoIterator<Item = Triangle>>(&mut self, triangles: I) {
        triangles.into_iter().for_each(|triangle| self.push(triangle));
    }
}

impl FromIterator<Triangle> for Triangles {
    fn from_iter<I: IntoIterator<Item = Triangle>>(triangles: I) -> Self {
        let mut list = Self::default();
        list.extend(triangles);
        list
    }
}

#[inline(always)]
fn position(&[x, y, z, _]: &Row) -> Vec3 {
    Vec3::from_array([x, y, z].map(f32::from_bits))
}
