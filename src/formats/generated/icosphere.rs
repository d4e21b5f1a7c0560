//! Triangulated spheres.

use std::collections::HashMap;

use glam::Vec3;

use crate::math::normalize;

/// An icosahedron inscribed in the unit sphere. Each face is split into four smaller ones, and this
/// is done `levels` times.
pub(super) fn icosphere(levels: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    const GOLDEN: f32 = 1.618_034;
    let mut vertices: Vec<Vec3> = Vec::new();
    for [a, b, c] in [[0, 1, 2], [2, 0, 1], [1, 2, 0]] {
        for (one, golden) in [(-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
            let corner = [one, golden * GOLDEN, 0.0];
            vertices.push(normalize(Vec3::new(corner[a], corner[b], corner[c])));
        }
    }
    let mut faces = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push(normalize(vertices[a as usize] + vertices[b as usize]));
                vertices.len() as u32 - 1
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (x, y, z) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, x, z], [b, y, x], [c, z, y], [x, y, z]]
            })
            .collect();
    }
    (vertices, faces)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_icosphere_is_closed_and_round() {
        let (vertices, faces) = icosphere(2);
        assert_eq!((vertices.len(), faces.len()), (162, 320));
        let mut edges = HashMap::new();
        for [a, b, c] in faces {
            for edge in [(a, b), (b, c), (c, a)] {
                *edges.entry(edge).or_insert(0) += 1;
            }
        }
        // Every edge occurs once in each direction, so the surface is closed and its faces are
        // oriented consistently.
        assert!(edges.iter().all(|(&(a, b), &n)| n == 1 && edges[&(b, a)] == 1));
        assert!(vertices.iter().all(|v| (v.length_squared() - 1.0).abs() < 1e-6));
    }
}
