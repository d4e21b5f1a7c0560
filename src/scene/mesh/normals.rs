//! Normals of the vertices of meshes that have none.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use crate::geometry::Vertices;
use crate::math::atan2;

/// Sets the normal of each vertex that has none to the mean of the normals of the triangles at its
/// position, weighted by their angles there (Thürmer and Wüthrich 1998, "Computing Vertex Normals
/// from Polygonal Facets"). Vertices at one position get the same normal even if their texture
/// coordinates differ; without a triangle they get the normal 0.
pub(crate) fn add_normals(vertices: &mut Vertices, triangles: &[[u32; 3]]) {
    let positions = &vertices.positions;
    let mut sums: HashMap<[u32; 3], DVec3> = HashMap::new();
    // Adding 0 turns −0 into 0.
    let key = |vertex: usize| positions[vertex].to_array().map(|c| (c + 0.0).to_bits());
    for triangle in triangles {
        let corners = triangle.map(|vertex| positions[vertex as usize].as_dvec3());
        for corner in 0..3 {
            let at = |i: usize| corners[(corner + i) % 3];
            let (u, v) = (at(1) - at(0), at(2) - at(0));
            let across = u.cross(v);
            let lengths = (u.dot(u) * v.dot(v)).sqrt();
            let size = across.dot(across).sqrt();
            if size > 0.0 {
                let angle = f64::from(atan2((size / lengths) as f32, (u.dot(v) / lengths) as f32));
                *sums.entry(key(triangle[corner] as usize)).or_default() += across * (angle / size);
            }
        }
    }
    let mean = |vertex: usize| sums.get(&key(vertex)).copied().map_or(Vec3::ZERO, unit);
    let given = std::mem::take(&mut vertices.normals);
    let normal = |vertex: usize| match given.get(vertex) {
        Some(normal) if *normal != Vec3::ZERO => *normal,
        _ => mean(vertex),
    };
    vertices.normals = (0..positions.len()).map(normal).collect();
}

/// `v` scaled to unit length, or 0 if it has no length.
pub(crate) fn unit(v: DVec3) -> Vec3 {
    let length = v.dot(v).sqrt();
    if length > 0.0 { (v * (1.0 / length)).as_vec3() } else { Vec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_of_a_cube_point_along_its_diagonals() {
        // Triangles split each face differently, so weights by area or by number would be uneven.
        let positions: Vec<Vec3> = (0..8)
            .map(|i| {
                let side = |axis: i32| if i >> axis & 1 == 1 { 1.0 } else { -1.0 };
                Vec3::from_array([0, 1, 2].map(side))
            })
            .collect();
        let faces =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> =
            faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        // Also with vertices of its own for each triangle, as along the seams of a texture.
        let apart: Vec<Vec3> =
            triangles.as_flattened().iter().map(|&corner| positions[corner as usize]).collect();
        let each = (0..12).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        for (positions, triangles) in [(positions, triangles), (apart, each)] {
            let mut vertices = Vertices { positions: positions.clone(), ..Vertices::default() };
            vertices.normals = vec![Vec3::ZERO; positions.len()];
            vertices.normals[1] = Vec3::X;
            add_normals(&mut vertices, &triangles);
            assert_eq!(vertices.normals[1], Vec3::X, "normals of the file stay");
            for i in (0..positions.len()).filter(|i| *i != 1) {
                let off = vertices.normals[i] - positions[i] / 3.0f32.sqrt();
                assert!(off.abs().max_element() < 1e-5, "{} {off}", positions[i]);
            }
        }
    }
}
