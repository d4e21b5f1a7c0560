//! Indexed triangle meshes.

use std::collections::BTreeSet;
use std::ops::Range;

use glam::{DAffine3, DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::normals::{add_normals, unit};
use crate::checks::MAX_COORDINATE;
use crate::error::suggestion;
use crate::geometry::{Triangle, Vertices};
use crate::image::Transfer;
use crate::limits::Budget;
use crate::math::precise::{rotate, turns};

/// A mesh as read from its file. Its indices are in range and its coordinates are finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct IndexedMesh {
    pub(crate) vertices: Vertices,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Its materials. Formats without them have neither names nor ranges.
    pub(crate) materials: Labels,
    /// Its groups, and the objects that consist of groups.
    pub(crate) groups: [Labels; 2],
    /// Names of the ignored data in the file.
    pub(crate) ignored: BTreeSet<&'static str>,
}

/// Names that a file gives to its triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Labels {
    pub(crate) names: Vec<String>,
    /// Ranges of triangles with the same name: one past the last triangle, and the index of the name,
    /// which is out of range for triangles without a name.
    pub(crate) ranges: Vec<(u32, u32)>,
}

impl Labels {
    /// The ranges of the triangles called `name`.
    fn find(&self, name: &str) -> Vec<Range<u32>> {
        let number = self.names.iter().position(|known| known == name);
        let begins = std::iter::once(0).chain(self.ranges.iter().map(|&(end, _)| end));
        let ranges = begins.zip(&self.ranges);
        let ranges = ranges.filter(|&(_, &(_, label))| Some(label as usize) == number);
        ranges.map(|(begin, &(end, _))| begin..end).collect()
    }

    /// Whether every triangle has a name.
    pub(crate) fn name_all(&self) -> bool {
        let named = |&(_, name): &(u32, u32)| (name as usize) < self.names.len();
        !self.ranges.is_empty() && self.ranges.iter().all(named)
    }

    /// The names of triangles.
    fn used(&self) -> impl Iterator<Item = &str> {
        self.ranges
            .iter()
            .filter_map(|&(_, name)| self.names.get(name as usize).map(String::as_str))
    }

    /// Bytes of memory that the lists take.
    fn memory(&self) -> usize {
        let names = self.names.iter().map(|name| size_of::<String>() + name.len());
        size_of_val(&*self.ranges) + names.sum::<usize>()
    }
}

/// The vertices of a transformed mesh, its triangles, and their ranges as in [`Labels::ranges`].
pub(crate) struct Transformed {
    pub(crate) vertices: Vertices,
    pub(crate) faces: Vec<[u32; 3]>,
    pub(crate) ranges: Vec<(u32, u32)>,
}

/// Whether triangles are shaded with the interpolated normals of their vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Smooth {
    /// If the file has normals.
    #[default]
    Auto,
    /// Always. If the file has no normals, each vertex gets the mean normal of its triangles.
    On,
    /// Never: the triangles are flat.
    Off,
}

/// A scale about the origin, then rotations about the axes x, y and z in this order, then a
/// translation, then an affine map.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Transform {
    pub(crate) scale: f32,
    /// Rotation about each axis in degrees.
    pub(crate) rotation: [f32; 3],
    pub(crate) translation: [f32; 3],
    pub(crate) matrix: Option<DAffine3>,
}

impl IndexedMesh {
    /// If there are more than three vertices per triangle, keeps only those that triangles refer to,
    /// because each vertex takes time to transform.
    pub(crate) fn without_stray_vertices(mut self) -> Self {
        if self.vertices.positions.len() > 3 * self.triangles.len() {
            self.vertices = compact(&self.vertices, &mut self.triangles);
        }
        self
    }

    /// Returns the triangles of the group called `name`, or else of the object.
    ///
    /// # Errors
    /// If no triangle belongs to it.
    pub(crate) fn group(&self, name: &str) -> Result<Self, String> {
        let found = self.groups.iter().map(|groups| groups.find(name));
        let Some(ranges) = found.into_iter().find(|ranges| !ranges.is_empty()) else {
            let known = suggestion(name, self.groups.iter().flat_map(Labels::used));
            return Err(format!("no triangle belongs to a group `{name}`{known}"));
        };
        let mut part = Self::default();
        part.materials.names.clone_from(&self.materials.names);
        for range in ranges {
            // The ranges of materials that overlap this one.
            let materials = &self.materials.ranges;
            let first = materials.partition_point(|&(end, _)| end <= range.start);
            let mut begin = range.start;
            for &(end, material) in &materials[first..] {
                let end = end.min(range.end);
                part.triangles.extend(&self.triangles[begin as usize..end as usize]);
                part.materials.ranges.push((part.triangles.len() as u32, material));
                begin = end;
                if end == range.end {
                    break;
                }
            }
        }
        part.vertices = compact(&self.vertices, &mut part.triangles);
        Ok(part)
    }

    /// Converts the colours of the file from sRGB to linear RGB. If any is out of range, none is
    /// used.
    pub(crate) fn decode_colors(&mut self) {
        let colors = &mut self.vertices.colors;
        if colors.iter().all(|color| color.to_array().iter().all(|c| (0.0..=1.0).contains(c))) {
            for color in colors {
                *color = Vec3::from_array(
                    color.to_array().map(|c| Transfer::Srgb.to_linear(f64::from(c))),
                );
            }
        } else {
            colors.clear();
            self.ignored.insert("colours outside [0, 1]");
        }
    }

    /// Notes that none of its triangles has an area.
    pub(crate) fn ignore_all(&mut self) {
        self.ignored.insert("all triangles, since they have no area");
    }

    /// Notes that the names of the materials are ignored, if there are any.
    pub(crate) fn ignore_materials(&mut self) {
        if !self.materials.names.is_empty() {
            self.ignored.insert("materials");
        }
    }

    /// Returns the names of the ignored data in the file, if any.
    pub(crate) fn ignored(&self) -> Option<String> {
        let names: Vec<&str> = self.ignored.iter().copied().collect();
        (!names.is_empty()).then(|| names.join(", "))
    }

    /// Returns the bytes of memory that the mesh takes.
    pub(crate) fn memory(&self) -> u64 {
        let labels = self.groups.iter().chain([&self.materials]).map(Labels::memory);
        let lists = labels.sum::<usize>() + size_of_val(&*self.triangles);
        self.vertices.bytes() + lists as u64
    }

    /// Returns the transformed vertices, the triangles that have an area, and their ranges. Vertices
    /// are computed in f64 and rounded once. `smooth` decides whether the vertices have normals.
    ///
    /// No ray slips between triangles that share a whole edge. Rays may slip through at
    /// T-junctions, which are vertices on the edge of a neighbour. A triangle without area
    /// is left out even if it closes the crack at a T-junction, because it has no normal.
    ///
    /// # Errors
    /// If a vertex ends up too far away, or the memory limit is exceeded.
    pub(crate) fn transformed(
        &self,
        transform: &Transform,
        smooth: Smooth,
        budget: &Budget,
    ) -> Result<Transformed, String> {
        let Vertices { positions, normals, uvs, second_uvs, colors, tangents } = &self.vertices;
        let (vertices, triangles) = (positions.len() as u64, self.triangles.len() as u64);
        // Includes the spare capacity of growing lists.
        budget.check(68 * vertices + 144 * triangles + self.vertices.bytes())?;
        let turns = turns(transform.rotation);
        let transformed = |vertex: &Vec3| {
            let scaled = vertex.to_array().map(|c| f64::from(c) * f64::from(transform.scale));
            let turned = rotate(scaled, turns);
            let moved: [f64; 3] =
                std::array::from_fn(|i| turned[i] + f64::from(transform.translation[i]));
            let placed = match transform.matrix {
                None => moved,
                Some(matrix) => matrix.transform_point3(moved.into()).into(),
            };
            let moved = placed.map(|c| c as f32);
            let placed = Vec3::from_array(moved);
            if in_range(placed) {
                Ok(placed)
            } else {
                Err(format!("a vertex is placed at {moved:?}, coordinates must be within ±1e9"))
            }
        };
        let positions = positions.iter().map(transformed).collect::<Result<Vec<_>, _>>()?;
        let has_area = |face: &[u32; 3]| {
            !Triangle { vertices: face.map(|vertex| positions[vertex as usize]) }.is_degenerate()
        };
        let (mut faces, mut ranges) = (Vec::with_capacity(self.triangles.len()), Vec::new());
        let all = [(self.triangles.len() as u32, u32::MAX)];
        let mut begin = 0;
        let named = &self.materials.ranges[..];
        for &(end, name) in if named.is_empty() { &all } else { named } {
            let range = &self.triangles[begin..end as usize];
            faces.extend(range.iter().copied().filter(has_area));
            ranges.push((faces.len() as u32, name));
            begin = end as usize;
        }
        if transform.matrix.is_some_and(|matrix| matrix.matrix3.determinant() < 0.0) {
            faces.iter_mut().for_each(|face| face.swap(1, 2));
        }
        let inverse = transform.matrix.map(|matrix| matrix.matrix3.inverse().transpose());
        let turned = |normal: &Vec3| {
            let turned = DVec3::from_array(rotate(normal.to_array().map(f64::from), turns));
            unit(inverse.map_or(turned, |inverse| inverse * turned))
        };
        // Tangents lie in the surface, so they turn as its edges do.
        let along = |tangent: &Vec3| {
            let turned = DVec3::from_array(rotate(tangent.to_array().map(f64::from), turns));
            unit(transform.matrix.map_or(turned, |matrix| matrix.matrix3 * turned))
        };
        let tangents = tangents.iter().map(along).collect();
        let (uvs, second_uvs, colors) = (uvs.clone(), second_uvs.clone(), colors.clone());
        let mut vertices =
            Vertices { positions, uvs, second_uvs, colors, tangents, ..Vertices::default() };
        if smooth == Smooth::On || smooth == Smooth::Auto && !normals.is_empty() {
            vertices.normals = normals.iter().map(turned).collect();
            // Even in a file with normals, some corners may lack them.
            let lacks = vertices.normals.is_empty() || vertices.normals.contains(&Vec3::ZERO);
            if lacks {
                add_normals(&mut vertices, &faces);
            }
        }
        Ok(Transformed { vertices, faces, ranges })
    }
}

/// Returns the vertices that `triangles` refer to, and changes the indices of `triangles` to theirs.
fn compact(vertices: &Vertices, triangles: &mut [[u32; 3]]) -> Vertices {
    let mut kept = triangles.as_flattened().to_vec();
    kept.sort_unstable();
    kept.dedup();
    for corner in triangles.as_flattened_mut() {
        *corner = kept.partition_point(|vertex| vertex < corner) as u32;
    }
    vertices.select(&kept)
}

/// Whether the coordinates of a vertex are within the range of a scene.
pub(crate) fn in_range(vertex: Vec3) -> bool {
    vertex.to_array().iter().all(|c| c.abs() <= MAX_COORDINATE)
}

/// Returns the triangles of the polygon with these corners, as a fan about the first corner.
pub(crate) fn fan<T: Copy>(corners: &[T]) -> impl Iterator<Item = [T; 3]> + '_ {
    corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]])
}
