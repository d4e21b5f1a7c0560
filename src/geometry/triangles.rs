//! Indexed triangles.

use std::collections::HashMap;
use std::mem::take;
use std::ops::Range;

use glam::Vec3;

use super::vertices::rows;
use super::{Triangle, Vertices};
use crate::huge_pages::settle;
use crate::math::Row;
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
    /// For each vertex, its normal, and the second texture coordinate. This table and the next two
    /// are empty if no triangle needs them.
    normals: Vec<Row>,
    /// For each vertex, its colour, and the first coordinate of the second set.
    colors: Vec<Row>,
    /// For each vertex, its tangent, and the second coordinate of the second set.
    tangents: Vec<Row>,
}

/// Flag of triangles that interpolate the normals of their vertices.
pub(super) const SMOOTH: u32 = 1;
/// Flag of triangles that interpolate the texture coordinates of their vertices.
pub(super) const MAPPED: u32 = 2;
/// Flag of smooth triangles whose shadows fade out towards the terminator.
pub(super) const SOFT: u32 = 4;
/// Flag of triangles that interpolate the second set of texture coordinates of their vertices.
pub(super) const MAPPED_TWICE: u32 = 8;
/// Flag of triangles that interpolate the colours of their vertices.
pub(super) const COLORED: u32 = 16;
/// Flag of triangles that interpolate the tangents of their vertices.
pub(super) const TANGENT: u32 = 32;

/// An end of a list of triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mark {
    triangles: usize,
    vertices: usize,
    /// Number of rows in the tables of normals, colours and tangents.
    rows: [usize; 3],
}

impl Mark {
    /// Number of triangles before it.
    pub(crate) fn triangles(self) -> u32 {
        self.triangles as u32
    }
}

/// Replaces the vector of each row by `f` of it.
fn map_rows(table: &mut [Row], f: impl Fn(Vec3) -> Vec3) {
    for row in table {
        let [x, y, z] = f(vector(row)).to_array().map(f32::to_bits);
        *row = [x, y, z, row[3]];
    }
}

/// The tables of a list of triangles.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    pub(super) corners: &'a [Row],
    pub(super) positions: &'a [Row],
    pub(super) normals: &'a [Row],
    pub(super) colors: &'a [Row],
    pub(super) tangents: &'a [Row],
}

/// Appends the rows of new vertices to the table of an attribute. Both this table and `rows` may be
/// empty; missing rows become 0. There were `first` vertices before, and `end` are there now.
fn append_rows(
    table: &mut Vec<Row>,
    rows: impl ExactSizeIterator<Item = Row>,
    first: usize,
    end: usize,
) {
    if !table.is_empty() || rows.len() > 0 {
        table.resize(first, [0; 4]);
        table.extend(rows);
        table.resize(end, [0; 4]);
    }
}

impl Triangles {
    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.corners.len()
    }

    /// Size of the tables in memory, with their spare capacity.
    pub(super) fn bytes(&self) -> u64 {
        let Self { corners, positions, normals, colors, tangents } = self;
        let tables = [corners, positions, normals, colors, tangents];
        tables.map(|table| table.capacity() * size_of::<Row>()).iter().sum::<usize>() as u64
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

    /// The flags of the triangle at `index`, and the attributes of its vertices, for the scene's
    /// hash. `None` if it has no attributes.
    pub(crate) fn attributes(&self, index: usize) -> Option<(u32, Vec<f32>)> {
        let [a, b, c, flags] = self.corners[index];
        if flags == 0 {
            return None;
        }
        let has = |flag| flags & flag != 0;
        let corners = [a, b, c].map(|vertex| vertex as usize);
        let number = |table: &[Row], vertex: usize, i: usize| {
            f32::from_bits(table.get(vertex).map_or(0, |row| row[i]))
        };
        let mut numbers = Vec::with_capacity(15);
        for vertex in corners {
            let v = [0, 1, 2, 3].map(|i| number(&self.normals, vertex, i));
            numbers.extend([v[0], v[1], v[2], number(&self.positions, vertex, 3), v[3]]);
        }
        for (flag, table, columns) in [
            (MAPPED_TWICE, &self.colors, 3..4),
            (MAPPED_TWICE, &self.tangents, 3..4),
            (COLORED, &self.colors, 0..3),
            (TANGENT, &self.tangents, 0..3),
        ] {
            for vertex in corners.into_iter().filter(|_| has(flag)) {
                numbers.extend(columns.clone().map(|i| number(table, vertex, i)));
            }
        }
        Some((flags, numbers))
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

    /// Number of tables with a row for each vertex. Those of positions and normals count as one.
    pub(crate) fn tables(&self) -> usize {
        1 + usize::from(!self.colors.is_empty()) + usize::from(!self.tangents.is_empty())
    }

    /// Moves the tables to huge pages. Call this after the last triangle has been added.
    pub(super) fn settle(&mut self) {
        let Self { corners, positions, normals, colors, tangents } = self;
        for table in [corners, positions, normals, colors, tangents] {
            *table = settle(take(table));
        }
    }

    /// Number of rows that adding these vertices appends to the tables of colours and tangents, which
    /// few meshes need. The vertices before them need rows as well.
    pub(crate) fn optional_rows(&self, vertices: &Vertices) -> usize {
        let Vertices { positions, second_uvs, colors, tangents, .. } = vertices;
        let end = self.positions.len() + positions.len();
        let more = |table: &[Row], vectors: &[Vec3]| {
            let is_needed = !(table.is_empty() && vectors.is_empty() && second_uvs.is_empty());
            if is_needed { end - table.len() } else { 0 }
        };
        more(&self.colors, colors) + more(&self.tangents, tangents)
    }

    /// The current end of the list, for [`Triangles::split_off`].
    pub(crate) fn mark(&self) -> Mark {
        let Self { corners, positions, normals, colors, tangents } = self;
        let rows = [normals, colors, tangents].map(Vec::len);
        Mark { triangles: corners.len(), vertices: positions.len(), rows }
    }

    /// Removes the triangles added since `mark`, with their vertices, and returns them.
    pub(crate) fn split_off(&mut self, mark: Mark) -> Self {
        let Mark { triangles, vertices, rows } = mark;
        let moved = |[a, b, c, flags]: Row| {
            let [a, b, c] = [a, b, c].map(|vertex| vertex - vertices as u32);
            [a, b, c, flags]
        };
        // A table that was empty must become so again.
        let split = |table: &mut Vec<Row>, rows: usize| {
            let added = table.split_off(vertices.min(table.len()));
            table.truncate(rows);
            added
        };
        Self {
            corners: self.corners.split_off(triangles).into_iter().map(moved).collect(),
            positions: self.positions.split_off(vertices),
            normals: split(&mut self.normals, rows[0]),
            colors: split(&mut self.colors, rows[1]),
            tangents: split(&mut self.tangents, rows[2]),
        }
    }

    /// A copy of some of the triangles, with the vertices that they use.
    pub(crate) fn select(&self, range: Range<usize>) -> Self {
        let (mut numbers, mut used) = (HashMap::new(), Vec::new());
        let mut number = |vertex: u32| {
            *numbers.entry(vertex).or_insert_with(|| {
                used.push(vertex as usize);
                used.len() as u32 - 1
            })
        };
        let corners = self.corners[range].iter();
        let corners = corners.map(|&[a, b, c, flags]| [number(a), number(b), number(c), flags]);
        let corners = corners.collect();
        // Some tables may be empty.
        let rows = |table: &[Row]| used.iter().filter_map(|&i| table.get(i).copied()).collect();
        Self {
            corners,
            positions: rows(&self.positions),
            normals: rows(&self.normals),
            colors: rows(&self.colors),
            tangents: rows(&self.tangents),
        }
    }

    /// Removes the triangles for which `kept` is false, but not their vertices.
    ///
    /// # Panics
    /// If `kept` is shorter than the list.
    pub(crate) fn retain(&mut self, kept: &[bool]) {
        let mut kept = kept.iter();
        self.corners.retain(|_| *kept.next().expect("one flag for each triangle"));
    }

    /// Appends the triangles of another list.
    ///
    /// # Panics
    /// If there are 2^32 vertices or more.
    pub fn append(&mut self, other: &Self) {
        let first = self.positions.len();
        let end = first + other.positions.len();
        assert!(u32::try_from(end).is_ok(), "a scene has fewer than 2^32 vertices");
        let moved = |vertex: u32| first as u32 + vertex;
        let corners = other.corners.iter();
        self.corners.extend(corners.map(|&[a, b, c, flags]| [moved(a), moved(b), moved(c), flags]));
        self.positions.extend_from_slice(&other.positions);
        for (table, rows) in [
            (&mut self.normals, &other.normals),
            (&mut self.colors, &other.colors),
            (&mut self.tangents, &other.tangents),
        ] {
            append_rows(table, rows.iter().copied(), first, end);
        }
    }

    /// Replaces the normal of each vertex by `f` of it.
    pub(super) fn map_normals(&mut self, f: impl Fn(Vec3) -> Vec3) {
        map_rows(&mut self.normals, f);
    }

    /// Replaces the tangent of each vertex by `f` of it.
    pub(super) fn map_tangents(&mut self, f: impl Fn(Vec3) -> Vec3) {
        map_rows(&mut self.tangents, f);
    }

    /// Exchanges two vertices of each triangle, so that the front becomes the back.
    pub(super) fn turn_over(&mut self) {
        self.corners.iter_mut().for_each(|corners| corners.swap(1, 2));
    }

    /// Removes the triangles without area.
    pub(super) fn remove_degenerate(&mut self) {
        let kept: Vec<bool> = self.iter().map(|triangle| !triangle.is_degenerate()).collect();
        self.retain(&kept);
    }

    /// Replaces the position of each vertex by `f` of it.
    pub fn map_vertices(&mut self, f: impl Fn(Vec3) -> Vec3) {
        map_rows(&mut self.positions, f);
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
        let Vertices { positions, normals, uvs, second_uvs, colors, tangents } = vertices;
        let first = self.positions.len();
        let count = positions.len();
        let end = first + count;
        assert!(u32::try_from(end).is_ok(), "a scene has fewer than 2^32 vertices");
        let lengths = [normals.len(), uvs.len(), second_uvs.len(), colors.len(), tangents.len()];
        assert!(lengths.iter().all(|len| [0, count].contains(len)), "vertices need the same data");
        self.positions.extend(rows(&positions, &uvs, 0));
        for (table, rows) in [
            (&mut self.normals, rows(&normals, &uvs, 1)),
            (&mut self.colors, rows(&colors, &second_uvs, 0)),
            (&mut self.tangents, rows(&tangents, &second_uvs, 1)),
        ] {
            append_rows(table, rows, first, end);
        }
        let flag = |flag: u32, is_set: bool| if is_set { flag } else { 0 };
        let smooth = !normals.is_empty();
        let flags = flag(SMOOTH, smooth)
            | flag(MAPPED, !uvs.is_empty())
            | flag(SOFT, smooth && soft)
            | flag(MAPPED_TWICE, !second_uvs.is_empty())
            | flag(COLORED, !colors.is_empty())
            | flag(TANGENT, !tangents.is_empty());
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
        let Self { corners, positions, normals, colors, tangents } = self;
        Rows { corners, positions, normals, colors, tangents }
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
