//! Normals of the vertices of meshes that have none.

use glam::{DVec3, Vec3};

use crate::geometry::Vertices;
use crate::math::trig::acos;

/// Sets the normal of each vertex to the mean of the normals of its triangles, weighted by the angle
/// of the triangle at the vertex (Thürmer and Wüthrich 1998, "Computing Vertex Normals from
/// Polygonal Facets"). Vertices without a triangle get the normal 0.
pub(super) fn add_normals(vertices: &mut Vertices, triangles: &[[u32; 3]]) {
    let mut sums = vec![DVec3::ZERO; vertices.positions.len()];
    for triangle in triangles {
        let corners = triangle.map(|vertex| vertices.positions[vertex as usize].as_dvec3());
        for corner in 0..3 {
            let at = |i: usize| corners[(corner + i) % 3];
            let (u, v) = (at(1) - at(0), at(2) - at(0));
            let across = u.cross(v);
            let lengths = (u.dot(u) * v.dot(v)).sqrt();
            let size = across.dot(across).sqrt();
            if size > 0.0 {
                let angle = f64::from(acos((u.dot(v) / lengths) as f32));
                sums[triangle[corner] as usize] += across * (angle / size);
            }
        }
    }
    vertices.normals = sums.into_iter().map(unit).collect();
}

/// `v` scaled to unit length, or 0 if it has no length.
pub(in crate::scene) fn unit(v: DVec3) -> Vec3 {
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
                Vec3::from_array([0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 }))
            })
            .collect();
        let faces =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> =
            faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let mut vertices = Vertices { positions: positions.clone(), ..Vertices::default() };
        add_normals(&mut vertices, &triangles);
        for (position, normal) in positions.into_iter().zip(vertices.normals) {
            let off = normal - position / 3.0f32.sqrt();
            assert!(off.abs().max_element() < 1e-5, "{position} {normal}");
        }
    }
}
