//! Indexed triangles.

use std::ops::Range;

use glam::{Vec2, Vec3};

use super::Triangle;
use crate::math::{Row, row};
use crate::simd::axes;

/// A list of triangles, which share their vertices where the meshes that they come from do.
///
/// Vertices and triangles are stored as rows of four words, which vectors gather fastest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Triangles {
    /// For each triangle, the indices of its vertices, and its flags.
    corners: Vec<Row>,
    /// For each vertex, its position, and the first texture coordinate.
    positions: Vec<Row>,
    /// For each vertex, its normal, and the second texture coordinate; empty if no triangle needs
    /// them.
    normals: Vec<Row>,
}

/// The vertices of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Vertices {
    /// Their positions.
    pub positions: Vec<Vec3>,
    /// Their unit normals, or empty if the triangles are flat.
    pub normals: Vec<Vec3>,
    /// Their texture coordinates, or empty if the mesh has no texture coordinates.
    pub uvs: Vec<Vec2>,
}

/// Flag of triangles that interpolate the normals of their vertices.
pub(super) const SMOOTH: u32 = 1;
/// Flag of triangles that interpolate the texture coordinates of their vertices.
pub(super) const MAPPED: u32 = 2;
/// Flag of smooth triangles whose shadows fade out towards the terminator.
pub(super) const SOFT: u32 = 4;

/// An end of a list of triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mark {
    triangles: usize,
    vertices: usize,
}

impl Mark {
    /// Number of triangles before it.
    pub(crate) fn triangles(self) -> u32 {
        self.triangles as u32
    }
}

/// The tables of a list of triangles.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    pub(super) corners: &'a [Row],
    pub(super) positions: &'a [Row],
    pub(super) normals: &'a [Row],
}

impl Triangles {
    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.corners.len()
    }

    /// Size of the tables in memory, with their spare capacity.
    pub(super) fn bytes(&self) -> u64 {
        let rows = self.corners.capacity() + self.positions.capacity() + self.normals.capacity();
        (rows * size_of::<Row>()) as u64
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
        let corners = self.corners[index];
        // `map` would call a function for each vertex.
        axes(|i| vector(&self.positions[corners[i] as usize]))
    }

    /// All triangles, in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Triangle> + '_ {
        (0..self.len()).map(|index| Triangle { vertices: self.vertices(index) })
    }

    /// The flags of the triangle at `index`, and the normal and texture coordinates of its vertices,
    /// for the scene's hash. `None` if it has none of them.
    pub(crate) fn attributes(&self, index: usize) -> Option<(u32, [[f32; 5]; 3])> {
        let [a, b, c, flags] = self.corners[index];
        let attributes = |vertex: u32| {
            let [.., u] = self.positions[vertex as usize];
            let [x, y, z, v] = self.normals[vertex as usize];
            [x, y, z, u, v].map(f32::from_bits)
        };
        (flags != 0).then(|| (flags, [a, b, c].map(attributes)))
    }

    /// Appends one flat triangle with vertices of its own.
    pub fn push(&mut self, triangle: Triangle) {
        let vertices = Vertices { positions: triangle.vertices.to_vec(), ..Vertices::default() };
        self.add(vertices, [[0, 1, 2]], true);
    }

    /// Number of vertices.
    pub(crate) fn vertex_count(&self) -> usize {
        self.positions.len()
    }

    /// The current end of the list, for [`Triangles::split_off`].
    pub(crate) fn mark(&self) -> Mark {
        Mark { triangles: self.corners.len(), vertices: self.positions.len() }
    }

    /// Removes the triangles added since `mark`, with their vertices, and returns them.
    pub(crate) fn split_off(&mut self, mark: Mark) -> Self {
        let Mark { triangles, vertices } = mark;
        let moved = |[a, b, c, flags]: Row| {
            let [a, b, c] = [a, b, c].map(|vertex| vertex - vertices as u32);
            [a, b, c, flags]
        };
        let normals = vertices.min(self.normals.len());
        Self {
            corners: self.corners.split_off(triangles).into_iter().map(moved).collect(),
            positions: self.positions.split_off(vertices),
            normals: self.normals.split_off(normals),
        }
    }

    /// A copy of some of the triangles, with all vertices.
    pub(crate) fn select(&self, range: Range<usize>) -> Self {
        Self { corners: self.corners[range].to_vec(), ..self.clone() }
    }

    /// Appends the triangles of another list.
    ///
    /// # Panics
    /// If there are 2^32 vertices or more.
    pub fn append(&mut self, other: &Self) {
        let first = self.positions.len();
        let end = u32::try_from(first + other.positions.len());
        assert!(end.is_ok(), "a scene has fewer than 2^32 vertices");
        let moved = |vertex: u32| first as u32 + vertex;
        let corners = other.corners.iter();
        self.corners.extend(corners.map(|&[a, b, c, flags]| [moved(a), moved(b), moved(c), flags]));
        self.positions.extend_from_slice(&other.positions);
        if !(self.normals.is_empty() && other.normals.is_empty()) {
            self.normals.resize(first, [0; 4]);
            self.normals.extend_from_slice(&other.normals);
            self.normals.resize(self.positions.len(), [0; 4]);
        }
    }

    /// Replaces the normal of each vertex by `f` of it.
    pub(super) fn map_normals(&mut self, f: impl Fn(Vec3) -> Vec3) {
        for row in &mut self.normals {
            let [x, y, z] = f(vector(row)).to_array().map(f32::to_bits);
            *row = [x, y, z, row[3]];
        }
    }

    /// Exchanges two vertices of each triangle, so that the front becomes the back.
    pub(super) fn turn_over(&mut self) {
        self.corners.iter_mut().for_each(|corners| corners.swap(1, 2));
    }

    /// Removes the triangles without area.
    pub(super) fn remove_degenerate(&mut self) {
        let kept: Vec<bool> = self.iter().map(|triangle| !triangle.is_degenerate()).collect();
        let mut kept = kept.iter();
        self.corners.retain(|_| *kept.next().expect("one flag for each triangle"));
    }

    /// Replaces the position of each vertex by `f` of it.
    pub fn map_vertices(&mut self, f: impl Fn(Vec3) -> Vec3) {
        for vertex in &mut self.positions {
            let [x, y, z] = f(vector(vertex)).to_array().map(f32::to_bits);
            *vertex = [x, y, z, vertex[3]];
        }
    }

    /// Appends a mesh, with three indices into its vertices for each triangle. If it has normals,
    /// `soft` makes shadows fade out towards the terminator.
    ///
    /// # Panics
    /// If there are 2^32 vertices or more, if an index is out of range, or if the lists of vertices
    /// differ in length and are not empty.
    pub fn add(
        &mut self,
        vertices: Vertices,
        faces: impl IntoIterator<Item = [u32; 3]>,
        soft: bool,
    ) {
        let Vertices { positions, normals, uvs } = vertices;
        let first = self.positions.len();
        let count = positions.len();
        let end = first + count;
        assert!(u32::try_from(end).is_ok(), "a scene has fewer than 2^32 vertices");
        for len in [normals.len(), uvs.len()] {
            assert!(len == 0 || len == positions.len(), "each vertex needs the same data");
        }
        let uv = |i: usize| uvs.get(i).copied().unwrap_or_default();
        let rows = positions.iter().enumerate().map(|(i, &position)| row(position, uv(i).x));
        self.positions.extend(rows);
        let has_attributes = !normals.is_empty() || !uvs.is_empty();
        if has_attributes || !self.normals.is_empty() {
            self.normals.resize(first, [0; 4]);
            let normal = |i: usize| normals.get(i).copied().unwrap_or_default();
            self.normals.extend((0..positions.len()).map(|i| row(normal(i), uv(i).y)));
        }
        let flag = |flag: u32, is_set: bool| if is_set { flag } else { 0 };
        let smooth = !normals.is_empty();
        let flags =
            flag(SMOOTH, smooth) | flag(MAPPED, !uvs.is_empty()) | flag(SOFT, smooth && soft);
        let corners = faces.into_iter().map(|[a, b, c]| {
            let [a, b, c] = [a, b, c].map(|vertex| {
                assert!((vertex as usize) < count, "a corner must be the index of a vertex");
                first as u32 + vertex
            });
            [a, b, c, flags]
        });
        self.corners.extend(corners);
    }

    #[inline(always)]
    pub(super) fn rows(&self) -> Rows<'_> {
        Rows { corners: &self.corners, positions: &self.positions, normals: &self.normals }
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
fn vector(&[x, y, z, _]: &Row) -> Vec3 {
    Vec3::from_array([x, y, z].map(f32::from_bits))
}
