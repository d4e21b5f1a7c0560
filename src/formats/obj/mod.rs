//! Reader of Wavefront OBJ files.

mod lines;
mod mtl;

use std::collections::{BTreeSet, HashMap};

use glam::{DVec3, Vec2, Vec3};
use memchr::memchr;
use rayon::prelude::*;

use self::lines::{ABSENT, Kind, ParsedLines, continued};
pub(crate) use self::mtl::add_materials_of_meshes;
use super::mesh::Format;
use super::polygons::{Polygon, clip_concave};
use crate::error::{Error, Result};
use crate::geometry::Vertices;
use crate::limits::Budget;
use crate::scene::mesh::{IndexedMesh, Labels};

/// Wavefront OBJ.
pub(crate) static FORMAT: Format = Format { extension: "obj", parse };

/// Size in bytes from which a part of a file ends with the next line.
const PART: usize = 1 << 15;
/// Number of parts that threads parse together. More would take more memory and gain little, since one
/// thread adds them to the mesh.
const PARTS: usize = 4;
/// Number of vertices of one position that a corner is compared with. If none of them fits, it gets a
/// vertex of its own.
const MOST_COMPARED: usize = 32;

/// A corner without a normal, or without texture coordinates.
const NONE: u32 = u32::MAX;

/// A position with a normal and texture coordinates, which corners of faces share. Holds their
/// indices in the file.
struct Vertex {
    position: u32,
    uv: u32,
    normal: u32,
    /// The next vertex with the same position, or [`NONE`].
    next: u32,
}

/// The content of a file, as far as it has been read.
#[derive(Default)]
struct Reader {
    positions: Vec<Vec3>,
    /// The colour of each position, or empty if there is none so far.
    colors: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// For each position, the first vertex that has it, or [`NONE`].
    first: Vec<u32>,
    vertices: Vec<Vertex>,
    triangles: Vec<[u32; 3]>,
    /// The fans of faces with more than three corners.
    polygons: Vec<Polygon>,
    /// Materials, by `usemtl`.
    materials: Names,
    /// Groups, by `g`.
    groups: Names,
    /// Objects, by `o`.
    objects: Names,
    /// Number of lines that have been read.
    lines: usize,
}

/// The names that the file gives to triangles.
#[derive(Default)]
struct Names {
    /// The number of each name.
    numbers: HashMap<Vec<u8>, u32>,
    /// Number of bytes of all names.
    bytes: usize,
    /// The number of the current name.
    current: Option<u32>,
    /// Ranges of triangles with the same name: one past the last triangle, and the number of the
    /// name, or [`NONE`].
    ranges: Vec<(u32, u32)>,
}

impl Names {
    /// Gives the triangles that follow a name, which may contain blanks.
    fn begin(&mut self, name: &[u8]) {
        let next = self.numbers.len() as u32;
        self.bytes += if self.numbers.contains_key(name) { 0 } else { name.len() };
        self.current = Some(*self.numbers.entry(name.to_vec()).or_insert(next));
    }

    /// Gives the current name to the triangles before `end`.
    fn cover(&mut self, end: u32) {
        let name = self.current.unwrap_or(NONE);
        match self.ranges.last_mut() {
            Some(last) if last.1 == name => last.0 = end,
            _ => self.ranges.push((end, name)),
        }
    }

    /// Bytes of memory while the lists grow.
    fn memory(&self) -> usize {
        24 * self.ranges.len() + 200 * self.numbers.len() + 3 * self.bytes
    }

    fn labels(self) -> Labels {
        let mut names = vec![String::new(); self.numbers.len()];
        for (name, number) in self.numbers {
            names[number as usize] = String::from_utf8_lossy(&name).into_owned();
        }
        Labels { names, ranges: self.ranges }
    }
}

/// Reads the vertices and faces of all groups in `bytes`, and subtracts `origin` from positions. Errors call the file
/// `name`.
pub(crate) fn parse(
    name: &str,
    bytes: &[u8],
    origin: DVec3,
    budget: &Budget,
) -> Result<IndexedMesh> {
    let mut rest = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    let (mut reader, mut parts) = (Reader::default(), Vec::new());
    let error = |(line, message)| Error::input(name, format!("{}", line + 1), message);
    // While this thread adds parts to the mesh, others parse the next ones.
    while !(rest.is_empty() && parts.is_empty()) {
        let texts: Vec<_> = (0..PARTS).map_while(|_| next_part(&mut rest)).collect();
        let mut next = Vec::new();
        rayon::in_place_scope(|scope| {
            scope.spawn(|_| {
                let parse = |text| ParsedLines::parse(text, origin);
                next = texts.into_par_iter().map(parse).collect();
            });
            parts.drain(..).try_for_each(|part| reader.add(part, budget))
        })
        .map_err(error)?;
        parts = next;
    }
    Ok(reader.mesh())
}

/// Takes whole lines from the front of `rest`. `None` at its end.
fn next_part<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let last = rest.len().checked_sub(1)?;
    let line_end = |from: usize| memchr(b'\n', &rest[from..]).map_or(last, |i| from + i);
    let mut end = line_end(PART.min(last));
    let mut begin = rest[..end].iter().rposition(|byte| *byte == b'\n').map_or(0, |i| i + 1);
    while end < last && continued(&rest[begin..end]).is_some() {
        (begin, end) = (end + 1, line_end(end + 1));
    }
    let (part, after) = (&rest[..end + 1], &rest[end + 1..]);
    *rest = after;
    Some(part.strip_suffix(b"\n").unwrap_or(part))
}

impl Reader {
    /// Adds the content of a part, and checks the memory. `Err` holds the index of the invalid line
    /// and the reason.
    fn add(&mut self, part: ParsedLines<'_>, budget: &Budget) -> Result<(), (usize, String)> {
        let lines = self.lines;
        let before = [self.positions.len(), self.uvs.len(), self.normals.len()];
        if !(self.colors.is_empty() && part.colors.is_empty()) {
            self.colors.resize(before[0], Vec3::ONE);
            self.colors.extend(&part.colors);
            self.colors.resize(before[0] + part.positions.len(), Vec3::ONE);
        }
        self.positions.extend(part.positions);
        self.uvs.extend(part.uvs);
        self.normals.extend(part.normals);
        self.first.resize(self.positions.len(), NONE);
        budget.check(self.memory()).map_err(|message| (lines, message))?;
        let (mut names, mut first) = (part.names.into_iter().peekable(), 0);
        for (number, face) in part.faces.iter().enumerate() {
            while let Some((_, kind, name)) = names.next_if(|(faces, ..)| *faces <= number) {
                self.names(kind).begin(name);
            }
            let counts = std::array::from_fn(|i| before[i] + face.before[i] as usize);
            self.face(&part.corners[first..face.end as usize], counts)
                .map_err(|message| (lines + face.line as usize, message))?;
            first = face.end as usize;
        }
        names.for_each(|(_, kind, name)| self.names(kind).begin(name));
        self.lines += part.lines;
        match part.error {
            Some(message) => Err((self.lines, message.to_owned())),
            None => budget.check(self.memory()).map_err(|message| (self.lines, message)),
        }
    }

    fn names(&mut self, kind: Kind) -> &mut Names {
        match kind {
            Kind::Material => &mut self.materials,
            Kind::Group => &mut self.groups,
            Kind::Object => &mut self.objects,
        }
    }

    /// Adds a polygon as a fan of triangles about its first corner. `counts` are the numbers of
    /// positions, texture coordinates and normals before its line.
    fn face(&mut self, corners: &[[i32; 3]], counts: [usize; 3]) -> Result<(), String> {
        if corners.len() > 3 {
            let first = self.triangles.len() as u32;
            self.polygons.push(Polygon { first, corners: corners.len() as u32 });
        }
        let mut fan = [0; 2];
        for (i, corner) in corners.iter().enumerate() {
            let vertex = self.vertex(*corner, counts)?;
            if i < 2 {
                fan[i] = vertex;
            } else {
                self.triangles.push([fan[0], fan[1], vertex]);
                fan[1] = vertex;
            }
        }
        let end = self.triangles.len() as u32;
        for names in [&mut self.materials, &mut self.groups, &mut self.objects] {
            names.cover(end);
        }
        Ok(())
    }

    /// The index of the vertex for a corner.
    fn vertex(&mut self, corner: [i32; 3], counts: [usize; 3]) -> Result<u32, String> {
        let index = |i: usize, what: &str| {
            let (number, count) = (i64::from(corner[i]), counts[i]);
            if corner[i] == ABSENT {
                return Ok(NONE);
            }
            // Negative numbers count from the end.
            let index = if number < 0 { count as i64 + number } else { number - 1 };
            let found = u32::try_from(index).ok().filter(|index| (*index as usize) < count);
            found.ok_or_else(|| {
                format!(
                    "the face refers to a missing {what}, the file has {count} before this line"
                )
            })
        };
        let position = index(0, "vertex")?;
        let uv = index(1, "texture coordinate")?;
        let normal = index(2, "normal")?;
        let mut known = self.first[position as usize];
        for _ in 0..MOST_COMPARED {
            let Some(vertex) = self.vertices.get(known as usize) else { break };
            if (vertex.uv, vertex.normal) == (uv, normal) {
                return Ok(known);
            }
            known = vertex.next;
        }
        let new = self.vertices.len() as u32;
        let next = std::mem::replace(&mut self.first[position as usize], new);
        self.vertices.push(Vertex { position, uv, normal, next });
        Ok(new)
    }

    /// Bytes of memory that the lists take while they grow, together with the mesh.
    fn memory(&self) -> u64 {
        let lists = 16 * self.positions.len()
            + 12 * self.colors.len()
            + 8 * self.uvs.len()
            + 12 * self.normals.len()
            + 16 * self.vertices.len()
            + 12 * self.triangles.len()
            + size_of::<Polygon>() * self.polygons.len();
        let names = self.materials.memory() + self.groups.memory() + self.objects.memory();
        (3 * lists + 44 * self.vertices.len() + names) as u64
    }

    /// The vertices that faces refer to, and the faces.
    fn mesh(self) -> IndexedMesh {
        let Self { positions, colors, uvs, normals, vertices, mut triangles, polygons, .. } = self;
        let of = |list: &[Vec3], index: u32| list.get(index as usize).copied().unwrap_or_default();
        let has_normals = vertices.iter().any(|vertex| vertex.normal != NONE);
        let has_uvs = vertices.iter().any(|vertex| vertex.uv != NONE);
        let with = |is_needed: bool| vertices.iter().filter(move |_| is_needed);
        let uv = |vertex: &Vertex| uvs.get(vertex.uv as usize).copied().unwrap_or_default();
        let vertices = Vertices {
            positions: vertices.iter().map(|vertex| of(&positions, vertex.position)).collect(),
            normals: with(has_normals).map(|vertex| of(&normals, vertex.normal)).collect(),
            uvs: with(has_uvs).map(uv).collect(),
            colors: with(!colors.is_empty()).map(|vertex| of(&colors, vertex.position)).collect(),
            ..Vertices::default()
        };
        let left = clip_concave(&vertices.positions, &mut triangles, &polygons);
        let groups = [self.groups.labels(), self.objects.labels()];
        let (materials, mut ignored) = (self.materials.labels(), BTreeSet::new());
        ignored.extend(left);
        IndexedMesh { vertices, triangles, materials, groups, ignored }
    }
}

#[cfg(test)]
mod tests;
