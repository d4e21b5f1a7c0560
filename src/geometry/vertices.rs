//! The vertices of a mesh.

use glam::{Vec2, Vec3};

use crate::math::{Row, row};

/// The vertices of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Vertices {
    /// Their positions.
    pub positions: Vec<Vec3>,
    /// Their unit normals, or empty if the triangles are flat.
    pub normals: Vec<Vec3>,
    /// Their texture coordinates, or empty if the mesh has no texture coordinates.
    pub uvs: Vec<Vec2>,
    /// Their texture coordinates of the second set, or empty.
    pub second_uvs: Vec<Vec2>,
    /// Their colours in linear RGB, or empty.
    pub colors: Vec<Vec3>,
    /// Their tangents, or empty: the directions of the first axis of normal maps, in which the first
    /// texture coordinate grows. The texture coordinates decide on which side the second axis is.
    pub tangents: Vec<Vec3>,
}

impl Vertices {
    /// The vertices at these indices, in this order.
    pub(crate) fn select(&self, indices: &[u32]) -> Self {
        fn of<T: Copy>(list: &[T], indices: &[u32]) -> Vec<T> {
            indices.iter().filter_map(|&index| list.get(index as usize).copied()).collect()
        }
        let Self { positions, normals, uvs, second_uvs, colors, tangents } = self;
        Self {
            positions: of(positions, indices),
            normals: of(normals, indices),
            uvs: of(uvs, indices),
            second_uvs: of(second_uvs, indices),
            colors: of(colors, indices),
            tangents: of(tangents, indices),
        }
    }

    /// Size of the lists in memory.
    pub(crate) fn bytes(&self) -> u64 {
        let Self { positions, normals, uvs, second_uvs, colors, tangents } = self;
        let vectors = [positions, normals, colors, tangents].map(|list| size_of_val(&**list));
        let pairs = [uvs, second_uvs].map(|list| size_of_val(&**list));
        vectors.into_iter().chain(pairs).sum::<usize>() as u64
    }
}

/// One row for each vertex, of its vector and a coordinate of its pair. Either may be missing.
pub(super) fn rows<'a>(
    vectors: &'a [Vec3],
    pairs: &'a [Vec2],
    axis: usize,
) -> impl ExactSizeIterator<Item = Row> + 'a {
    let vector = |i: usize| vectors.get(i).copied().unwrap_or_default();
    let number = move |i: usize| pairs.get(i).map_or(0.0, |pair| pair[axis]);
    (0..vectors.len().max(pairs.len())).map(move |i| row(vector(i), number(i)))
}
