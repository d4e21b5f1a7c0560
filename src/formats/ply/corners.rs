//! Texture coordinates and colours that faces or their corners have, instead of vertices.

use std::collections::HashMap;

use glam::{Vec2, Vec3};
use ply_rs_bw::ply::Header;

use super::row::{COLOR, CORNER_COLORS, CORNER_UVS, Row, has};
use crate::scene::mesh::{IndexedMesh, fan};

/// Bytes of memory for each corner of a triangle, with its entry in a table and its vertex.
const CORNER: usize = 150;

/// The data of the corners of all triangles.
#[derive(Default)]
pub(super) struct Corners {
    has_uvs: bool,
    /// Whether faces have colours, and whether their corners have.
    has_colors: [bool; 2],
    uvs: Vec<Vec2>,
    colors: Vec<Vec3>,
}

impl Corners {
    pub(super) fn new(header: &Header) -> Self {
        let has = |names: &[&str]| has(header, "face", names);
        Self {
            has_uvs: has(&[CORNER_UVS]),
            has_colors: [has(&COLOR), has(&[CORNER_COLORS])],
            ..Self::default()
        }
    }

    /// Whether there are any such data.
    pub(super) fn exist(&self) -> bool {
        self.has_uvs || self.has_colors != [false; 2]
    }

    /// Bytes of memory for the data, and for vertices with them.
    pub(super) fn memory(&self) -> u64 {
        (CORNER * self.uvs.len().max(self.colors.len())) as u64
    }

    /// Adds the data of a face, whose triangles are a fan.
    ///
    /// # Errors
    /// If the data are not numbers for each of its corners.
    pub(super) fn add(&mut self, face: &Row) -> Result<(), &'static str> {
        let count = face.corners.len();
        let (own_uvs, own_colors) =
            face.data.as_ref().map_or((&[][..], &[][..]), |data| (&data.uvs, &data.colors));
        let of = |numbers: &[f32], each: usize| {
            // An empty list stands for a face without the data.
            let fits = numbers.is_empty() || numbers.len() == each * count;
            fits && numbers.iter().all(|number| number.is_finite())
        };
        if self.has_uvs {
            if !of(own_uvs, 2) {
                return Err("`texcoord` must have two finite numbers for each corner of the face");
            }
            let (pairs, _) = own_uvs.as_chunks::<2>();
            let uv = |i: usize| pairs.get(i).map_or(Vec2::ZERO, |pair| Vec2::from_array(*pair));
            let uvs: Vec<Vec2> = (0..count).map(uv).collect();
            self.uvs.extend(fan(&uvs).flatten());
        }
        if self.has_colors != [false; 2] {
            let (own, (triples, _)) = (face.color, own_colors.as_chunks::<3>());
            if !of(own_colors, 3) {
                return Err("`color` must have three finite numbers for each corner of the face");
            }
            let color = |i: usize| match triples.get(i) {
                Some(color) => Vec3::from_array(*color),
                None if self.has_colors[0] => own,
                None => Vec3::ONE,
            };
            let colors: Vec<Vec3> = (0..count).map(color).collect();
            self.colors.extend(fan(&colors).flatten());
        }
        Ok(())
    }

    /// Gives each triangle vertices with its data. Corners with the same vertex and data share one.
    pub(super) fn split(self, mesh: &mut IndexedMesh) {
        let (mut known, mut vertices) = (HashMap::new(), Vec::new());
        let (mut uvs, mut colors) = (Vec::new(), Vec::new());
        for (i, corner) in mesh.triangles.as_flattened_mut().iter_mut().enumerate() {
            let (uv, color) = (self.uvs.get(i), self.colors.get(i));
            let [u, v] = uv.copied().unwrap_or_default().to_array().map(f32::to_bits);
            let [r, g, b] = color.copied().unwrap_or_default().to_array().map(f32::to_bits);
            let key = [*corner, u, v, r, g, b];
            *corner = *known.entry(key).or_insert_with(|| {
                vertices.push(*corner);
                uvs.extend(uv);
                colors.extend(color);
                vertices.len() as u32 - 1
            });
        }
        mesh.vertices = mesh.vertices.select(&vertices);
        if self.has_uvs {
            mesh.vertices.uvs = uvs;
        }
        if self.has_colors != [false; 2] {
            mesh.vertices.colors = colors;
        }
    }
}
