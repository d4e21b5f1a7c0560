//! Tangents of the vertices of meshes that have none.

use std::collections::HashMap;

use bevy_mikktspace::{Geometry, Ops, TangentSpace, generate_tangents};
use glam::Vec3;

use crate::geometry::Vertices;
use crate::math::acos;

/// Whether vertices have all that their tangents depend on, and no tangents yet.
pub(crate) fn lacks_tangents(vertices: &Vertices) -> bool {
    let Vertices { normals, uvs, tangents, .. } = vertices;
    !normals.is_empty() && !uvs.is_empty() && tangents.is_empty()
}

/// Sets the tangents of vertices that have normals and texture coordinates, as MikkTSpace defines
/// them (Mikkelsen 2008, "Simulation of Wrinkled Surfaces Revisited"): programs that make normal
/// maps use these. Where triangles with one vertex disagree, as along the seam of a mirrored
/// texture, each gets a vertex of its own.
///
/// # Errors
/// If more than [`MOST_AT_POINT`] triangles meet at a point.
pub(crate) fn add_tangents(
    vertices: &mut Vertices,
    triangles: &mut [[u32; 3]],
) -> Result<(), String> {
    check_points(&vertices.positions, triangles)?;
    let corners = vec![[Vec3::ZERO; 3]; triangles.len()];
    let mut mesh = Corners { vertices, triangles, tangents: corners };
    generate_tangents(&mut mesh).map_err(|error| format!("tangents: {error:?}"))?;
    let tangents = mesh.tangents;
    let mut given: Vec<Option<Vec3>> = vec![None; vertices.positions.len()];
    let mut indices: Vec<u32> = (0..given.len() as u32).collect();
    let mut copies: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
    for (triangle, tangents) in triangles.iter_mut().zip(tangents) {
        for (corner, tangent) in triangle.iter_mut().zip(tangents) {
            let own = given[*corner as usize].get_or_insert(tangent);
            if *own != tangent {
                let key = (*corner, tangent.to_array().map(f32::to_bits));
                *corner = *copies.entry(key).or_insert_with(|| {
                    indices.push(*corner);
                    given.push(Some(tangent));
                    indices.len() as u32 - 1
                });
            }
        }
    }
    if indices.len() > vertices.positions.len() {
        *vertices = vertices.select(&indices);
    }
    vertices.tangents = given.into_iter().map(Option::unwrap_or_default).collect();
    Ok(())
}

/// Largest number of triangles at a point. The time for a point grows with its square, and the stack
/// in proportion to it.
const MOST_AT_POINT: u32 = 4096;

fn check_points(positions: &[Vec3], triangles: &[[u32; 3]]) -> Result<(), String> {
    let mut counts: HashMap<[u32; 3], u32> = HashMap::new();
    for &corner in triangles.as_flattened() {
        // Adding 0 turns −0 into 0.
        let position = positions[corner as usize].to_array();
        let count = counts.entry(position.map(|c| (c + 0.0).to_bits())).or_default();
        *count += 1;
        if *count > MOST_AT_POINT {
            return Err(format!(
                "a smooth mesh in a scene with normal maps can have at most {MOST_AT_POINT} triangles at a point, but more meet at {position:?}"
            ));
        }
    }
    Ok(())
}

/// A mesh, and the tangents at the corners of its triangles.
struct Corners<'a> {
    vertices: &'a Vertices,
    triangles: &'a [[u32; 3]],
    tangents: Vec<[Vec3; 3]>,
}

impl Corners<'_> {
    fn of<T: Copy>(&self, list: &[T], triangle: usize, corner: usize) -> T {
        list[self.triangles[triangle][corner] as usize]
    }
}

/// Functions with the same results on every machine.
struct Exact;

impl Ops for Exact {
    fn sqrt(x: f32) -> f32 {
        x.sqrt()
    }

    fn acos(x: f32) -> f32 {
        acos(x)
    }
}

impl Geometry<Exact> for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.triangles.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, triangle: usize, corner: usize) -> [f32; 3] {
        self.of(&self.vertices.positions, triangle, corner).to_array()
    }

    fn normal(&self, triangle: usize, corner: usize) -> [f32; 3] {
        self.of(&self.vertices.normals, triangle, corner).to_array()
    }

    fn tex_coord(&self, triangle: usize, corner: usize) -> [f32; 2] {
        self.of(&self.vertices.uvs, triangle, corner).to_array()
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, triangle: usize, corner: usize) {
        // Extreme coordinates overflow.
        let tangent = tangent.map(|tangent| Vec3::from_array(tangent.tangent()));
        if let Some(tangent) = tangent.filter(|tangent| tangent.is_finite()) {
            self.tangents[triangle][corner] = tangent;
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::math::{Stream, cross, dot, length};

    #[test]
    fn tangents_follow_the_texture_and_split_at_its_mirror() {
        // Two squares side by side; u grows toward their common edge from both sides.
        let positions: Vec<Vec3> = [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]]
            .map(|[x, y]: [i16; 2]| Vec3::new(x.into(), y.into(), 0.0))
            .to_vec();
        let uvs = positions.iter().map(|p| Vec2::new(1.0 - (p.x - 1.0).abs(), p.y)).collect();
        let normals = vec![Vec3::Z; 6];
        let mut vertices = Vertices { positions, normals, uvs, ..Vertices::default() };
        let mut faces = vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]];
        let before = faces.iter().map(|face| face.map(|i| vertices.positions[i as usize]));
        let before: Vec<_> = before.collect();
        add_tangents(&mut vertices, &mut faces).unwrap();
        assert_eq!(vertices.positions.len(), 8, "both vertices of the common edge are split");
        assert_eq!(vertices.uvs.len(), 8);
        for (face, before) in faces.iter().zip(before) {
            assert_eq!(face.map(|i| vertices.positions[i as usize]), before);
            let left = before.iter().all(|p| p.x <= 1.0);
            for i in face {
                let tangent = vertices.tangents[*i as usize];
                assert!(length(tangent - if left { Vec3::X } else { Vec3::NEG_X }) < 1e-6);
            }
        }
    }

    #[test]
    fn too_many_triangles_at_a_point_are_an_error() {
        for (count, ok) in [(4096, true), (4097, false)] {
            let around = |i: u32| Vec3::new(i as f32, (i * i) as f32 * 1e-4, 0.0);
            let positions: Vec<Vec3> = (0..count + 2).map(around).collect();
            let uvs = positions.iter().map(|p| Vec2::new(p.x, p.y)).collect();
            let normals = vec![Vec3::Z; positions.len()];
            let mut vertices = Vertices { positions, normals, uvs, ..Vertices::default() };
            let mut faces: Vec<_> = (0..count).map(|i| [0, i + 1, i + 2]).collect();
            assert_eq!(add_tangents(&mut vertices, &mut faces).is_ok(), ok, "{count}");
        }
    }

    #[test]
    fn tangents_of_random_meshes_are_unit_vectors_across_the_normal() {
        let mut random = Stream::new(3);
        let mut defined = 0;
        for round in 0..300 {
            let count = 3 + random.bits() as usize % 30;
            let mut vector =
                |size: f32| Vec3::from_array([(); 3].map(|()| random.between(-size, size)));
            let positions: Vec<Vec3> = (0..count).map(|_| vector(1.0)).collect();
            let normals: Vec<Vec3> =
                (0..count).map(|_| crate::math::normalize(vector(1.0))).collect();
            // Some have no extent, or extreme ones.
            let size = [1.0, 0.0, 1e20, 1e-20, 1e38][round % 5];
            let uv = |v: Vec3| Vec2::new(v.x, v.y);
            let uvs: Vec<Vec2> = (0..count).map(|_| uv(vector(size))).collect();
            let mut vertices = Vertices { positions, normals, uvs, ..Vertices::default() };
            let mut corner = || (random.bits() % count as u64) as u32;
            let mut faces: Vec<[u32; 3]> =
                (0..2 * count).map(|_| [(); 3].map(|()| corner())).collect();
            add_tangents(&mut vertices, &mut faces).unwrap();
            let found = vertices.tangents.iter().zip(&vertices.normals);
            for (tangent, normal) in found.filter(|(tangent, _)| **tangent != Vec3::ZERO) {
                assert!((length(*tangent) - 1.0).abs() < 1e-4, "{tangent}");
                assert!(dot(*tangent, *normal).abs() < 1e-3, "{tangent} {normal}");
                assert!(length(cross(*tangent, *normal)) > 0.9);
                defined += 1;
            }
        }
        assert!(defined > 2000, "{defined}");
    }
}
