//! Reader of Wavefront OBJ files.

use std::collections::{BTreeSet, HashMap};
use std::str;

use glam::{Vec2, Vec3};

use super::indexed::{Labels, Mesh, in_range};
use crate::error::{Error, Result};
use crate::geometry::Vertices;
use crate::scene::budget::Budget;

const VERTEX: &str = "a vertex is `v` and three numbers";
const RANGE: &str = "coordinates must be finite and within ±1e9";
const NORMAL: &str = "a normal is `vn` and three finite numbers";
const UV: &str = "texture coordinates are `vt` and one to three finite numbers";
const FACE: &str = "a face is `f` and three or more vertex numbers";
const CONTINUED: &str = "continued lines are not supported, join this line with the next";

/// Number of vertices of one position that a corner is compared with. If none of them fits, it gets a
/// vertex of its own.
const MOST_COMPARED: usize = 32;
/// Number of corners of a face after which the memory is checked.
const CORNERS: usize = 4096;

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
struct Reader<'a> {
    positions: Vec<Vec3>,
    /// The colour of each position, or empty if there is none so far.
    colors: Vec<Vec3>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// For each position, the first vertex that has it, or [`NONE`].
    first: Vec<u32>,
    vertices: Vec<Vertex>,
    triangles: Vec<[u32; 3]>,
    /// Materials, by `usemtl`.
    materials: Names,
    /// Groups, by `g`.
    groups: Names,
    /// Objects, by `o`.
    objects: Names,
    budget: Option<&'a Budget>,
    /// Bytes of memory up to which the budget has been checked.
    checked: u64,
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
        let name = name.trim_ascii();
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

/// Reads the vertices and faces of all groups in `bytes`. Errors call the file `name`.
pub(super) fn parse(name: &str, bytes: &[u8], budget: &Budget) -> Result<Mesh> {
    let mut reader = Reader { budget: Some(budget), ..Reader::default() };
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    for (line, number) in bytes.split(|byte| *byte == b'\n').zip(1..) {
        let error = |message: String| Error::input(name, format!("{number}"), message);
        reader.line(line).and_then(|()| reader.check()).map_err(error)?;
    }
    Ok(reader.mesh())
}

impl Reader<'_> {
    /// Reads a line.
    fn line(&mut self, line: &[u8]) -> Result<(), String> {
        let line = line.split(|byte| *byte == b'#').next().unwrap_or_default();
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let Some(keyword) = words.next() else { return Ok(()) };
        let is_data = matches!(keyword, b"v" | b"vt" | b"vn" | b"f");
        if is_data && line.trim_ascii_end().ends_with(b"\\") {
            return Err(CONTINUED.to_owned());
        }
        match keyword {
            b"v" => {
                let (numbers, count) = numbers::<6>(words).ok_or(VERTEX)?;
                let [x, y, z, w, g, b] = numbers;
                // After three coordinates, there may be w or a colour.
                let position = match count {
                    3 | 6 => Vec3::new(x, y, z),
                    4 | 5 if w != 0.0 => Vec3::new(x, y, z) / w,
                    _ => return Err(VERTEX.to_owned()),
                };
                if count >= 6 || !self.colors.is_empty() {
                    self.colors.resize(self.positions.len(), Vec3::ONE);
                    self.colors.push(if count >= 6 { Vec3::new(w, g, b) } else { Vec3::ONE });
                }
                if !(in_range(position) && [w, g, b].iter().all(|c| c.is_finite())) {
                    return Err(RANGE.to_owned());
                }
                self.positions.push(position);
                self.first.push(NONE);
            }
            b"vn" => {
                let normal = numbers::<3>(words).filter(|(_, count)| *count == 3);
                let normal = normal.map(|(numbers, _)| Vec3::from_array(numbers));
                self.normals.push(normal.filter(|normal| normal.is_finite()).ok_or(NORMAL)?);
            }
            b"vt" => {
                let uv = numbers::<3>(words).filter(|(_, count)| *count >= 1);
                let uv = uv.map(|([u, v, _], _)| Vec2::new(u, v));
                self.uvs.push(uv.filter(|uv| uv.is_finite()).ok_or(UV)?);
            }
            b"f" => {
                self.face(words)?;
                let end = self.triangles.len() as u32;
                self.materials.cover(end);
                self.groups.cover(end);
                self.objects.cover(end);
            }
            b"usemtl" => self.materials.begin(&line.trim_ascii_start()[keyword.len()..]),
            b"o" => self.objects.begin(&line.trim_ascii_start()[keyword.len()..]),
            b"g" => self.groups.begin(&line.trim_ascii_start()[keyword.len()..]),
            _ => {}
        }
        Ok(())
    }

    /// Adds a polygon as a fan of triangles about its first corner.
    fn face<'w>(&mut self, words: impl Iterator<Item = &'w [u8]>) -> Result<(), String> {
        let (mut corners, mut count) = ([0; 2], 0);
        for word in words {
            let vertex = self.vertex(word)?;
            if count < 2 {
                corners[count] = vertex;
            } else {
                self.triangles.push([corners[0], corners[1], vertex]);
                corners[1] = vertex;
            }
            count += 1;
            if count.is_multiple_of(CORNERS) {
                self.check()?;
            }
        }
        if count < 3 { Err(FACE.to_owned()) } else { Ok(()) }
    }

    /// The index of the vertex for a corner such as `1`, `1/2`, `1/2/3` or `1//3`.
    fn vertex(&mut self, word: &[u8]) -> Result<u32, String> {
        let mut parts = word.split(|byte| *byte == b'/');
        let mut index = |count: usize, what: &str| match parts.next() {
            None | Some(b"") => Ok(NONE),
            Some(part) => {
                let number: i64 =
                    str::from_utf8(part).ok().and_then(|part| part.parse().ok()).ok_or(FACE)?;
                // Negative numbers count from the end.
                let index = if number < 0 { count as i64 + number } else { number - 1 };
                let found = u32::try_from(index).ok().filter(|index| (*index as usize) < count);
                found.ok_or_else(|| {
                    format!(
                        "the face refers to a missing {what}, the file has {count} before this line"
                    )
                })
            }
        };
        let position = index(self.positions.len(), "vertex")?;
        if position == NONE {
            return Err(FACE.to_owned());
        }
        let uv = index(self.uvs.len(), "texture coordinate")?;
        let normal = index(self.normals.len(), "normal")?;
        if parts.next().is_some() {
            return Err(FACE.to_owned());
        }
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

    /// Checks the memory of the lists, at steps of a mebibyte.
    fn check(&mut self) -> Result<(), String> {
        let memory = self.memory();
        if memory > self.checked {
            self.budget.map_or(Ok(()), |budget| budget.check(memory))?;
            self.checked = memory + (1 << 20);
        }
        Ok(())
    }

    /// Bytes of memory that the lists take while they grow, together with the mesh.
    fn memory(&self) -> u64 {
        let lists = 16 * self.positions.len()
            + 12 * self.colors.len()
            + 8 * self.uvs.len()
            + 12 * self.normals.len()
            + 16 * self.vertices.len()
            + 12 * self.triangles.len();
        let names = self.materials.memory() + self.groups.memory() + self.objects.memory();
        (3 * lists + 44 * self.vertices.len() + names) as u64
    }

    /// The vertices that faces refer to, and the faces.
    fn mesh(self) -> Mesh {
        let Self { positions, colors, uvs, normals, vertices, triangles, .. } = self;
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
        let groups = [self.groups.labels(), self.objects.labels()];
        let (materials, ignored) = (self.materials.labels(), BTreeSet::new());
        Mesh { vertices, triangles, materials, groups, ignored }
    }
}

/// Up to N numbers, and how many there are. Missing ones are 0; further words are not read. `None`
/// if a word is not a number.
fn numbers<'a, const N: usize>(words: impl Iterator<Item = &'a [u8]>) -> Option<([f32; N], usize)> {
    let (mut numbers, mut count) = ([0.0; N], 0);
    for word in words.take(N) {
        numbers[count] = str::from_utf8(word).ok()?.parse().ok()?;
        count += 1;
    }
    Some((numbers, count))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::{Limit, Limits};

    fn read(text: &[u8]) -> Result<Mesh> {
        parse("a.obj", text, &Budget::new(&Limits::default(), 0))
    }

    fn message(text: &str) -> String {
        read(text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn groups_polygons_and_relative_indices() {
        let text = "\u{feff}v 0 0 0 # first\n# caf\u{e9}\nmtllib none.mtl\no one\r\nv 1 0 0 1\nv 1 1 0 0.1 0.2 0.3\n\
                    usemtl red\nf 1 2 3 # top\ng two\nv 0 2 0 2\n\
                    f -4 -3 -2 -1\nl 1 2\np 1\n";
        let mesh = read(text.as_bytes()).unwrap();
        let at = |t: [u32; 3]| t.map(|i| mesh.vertices.positions[i as usize].to_array());
        let (a, b, c, d) = ([0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]);
        let triangles: Vec<_> = mesh.triangles.iter().map(|t| at(*t)).collect();
        assert_eq!(triangles, [[a, b, c], [a, b, c], [a, c, d]]);
        assert!(mesh.vertices.normals.is_empty() && mesh.vertices.uvs.is_empty());
        let [groups, objects] = &mesh.groups;
        assert_eq!(
            (&groups.names[..], &objects.names[..]),
            (&["two".into()][..], &["one".into()][..])
        );
        assert_eq!((&groups.ranges[1], &objects.ranges[..]), (&(3, 0), &[(3, 0)][..]));
        assert_eq!(mesh.materials, Labels { names: vec!["red".into()], ranges: vec![(3, 0)] });
        assert_eq!(mesh.group("one").unwrap().triangles.len(), 3);
        assert_eq!(mesh.group("two").unwrap().triangles.len(), 2);
        // The other vertices are white.
        assert_eq!(mesh.vertices.colors[2].to_array(), [0.1, 0.2, 0.3]);
        assert_eq!(mesh.vertices.colors[0], Vec3::ONE);
    }

    #[test]
    fn a_group_keeps_its_vertices_and_materials() {
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red\ng a\nf 1 2 3\n\
                    g b\nf 2 3 4\nusemtl blue\nf 1 3 4\nf 1 2 4\ng a\nf 2 3 4\n";
        let mesh = read(text.as_bytes()).unwrap();
        let a = mesh.group("a").unwrap();
        assert_eq!(a.vertices.positions, [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y]);
        assert_eq!(
            (a.triangles, a.materials.ranges),
            (vec![[0, 1, 2], [1, 2, 3]], vec![(1, 0), (2, 1)])
        );
        let b = mesh.group("b").unwrap();
        assert_eq!((b.triangles.len(), b.materials.ranges), (3, vec![(1, 0), (3, 1)]));
        assert_eq!(b.materials.names, ["red", "blue"]);
        let error = mesh.group("c").unwrap_err();
        assert!(error.starts_with("no triangle belongs to a group `c`"), "{error}");
    }

    #[test]
    fn corners_with_equal_data_share_a_vertex() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nvt 0.5\nvt 0 1 0\nvn 0 0 2\nvn 1 0 0\n\
                    f 1/1/1 2/2/1 3//2\nf 1/1/-2 3//2 2/1/1\n";
        let Mesh { vertices, triangles, .. } = read(text.as_bytes()).unwrap();
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 3]]);
        let (x, y, z) = (Vec3::X, Vec3::Y, Vec3::Z);
        assert_eq!(vertices.positions, [Vec3::ZERO, x, y, x]);
        assert_eq!(vertices.normals, [z * 2.0, z * 2.0, x, z * 2.0]);
        assert_eq!(vertices.uvs, [Vec2::X * 0.5, Vec2::Y, Vec2::ZERO, Vec2::X * 0.5]);
    }

    #[test]
    fn errors_name_the_line() {
        let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        let wrong = format!("a.obj:3: {VERTEX}");
        assert_eq!(message("v 0 0 0\nv 1 0 0\nv 0 x 0\nf 1 2 3"), wrong);
        assert_eq!(message("v 0 0 0\nv 1 0 0\nv 0 1\nf 1 2 3\n"), wrong);
        for bad in ["1 2 x", "", "1 2", "1 2 3 /4", "1 2 /3", "1 2 3/1/1/1"] {
            let text = format!("{vertices}vt 0 0\nvn 1 0 0\nf {bad}\nf 1 2 3");
            assert_eq!(message(&text), format!("a.obj:6: {FACE}"));
        }
        for (line, says) in [("vn 1 0", NORMAL), ("vn 1 0 inf", NORMAL), ("vt", UV), ("vt x", UV)] {
            assert_eq!(message(&format!("{vertices}{line}\n")), format!("a.obj:4: {says}"));
        }
        let text = format!("{vertices}f 1 2 \\\n3\n");
        assert_eq!(message(&text), format!("a.obj:4: {CONTINUED}"));
        let beyond = "the face refers to a missing vertex, the file has 3 before this line";
        for face in ["1 2 4", "0 1 2", "1 2 -4", "1 2 99999999999"] {
            let text = format!("{vertices}\no a\nf 1 2 3\nf {face}\no b\nf 1 2 3\n");
            assert_eq!(message(&text), format!("a.obj:7: {beyond}"));
        }
        for (face, what) in [("1/1 2 3", "texture coordinate"), ("1//2 2 3", "normal")] {
            let message = message(&format!("{vertices}f {face}\n"));
            assert!(message.contains(&format!("a missing {what}, the file has 0")), "{message}");
        }
        for bad in ["nan 0", "inf 0", "1e39 0", "2e9 0", "5e8 0 0.25", "0 0 nan", "0 1 1e-45"] {
            let text = format!("{vertices}v 0 {bad}\nf 1 2 4\n");
            assert_eq!(message(&text), format!("a.obj:4: {RANGE}"));
        }
    }

    /// Many vertices at one position must not take quadratic time.
    #[test]
    fn many_vertices_at_one_position_are_read() {
        let count = 200_000;
        let faces: String = (0..count / 3)
            .map(|i| format!("f 1/{} 1/{} 1/{}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3))
            .collect();
        let text = format!("v 0 0 0\n{}{faces}", "vt 0\n".repeat(count));
        assert_eq!(read(text.as_bytes()).unwrap().triangles.len(), count / 3);
    }

    #[test]
    fn memory_is_limited() {
        let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{}", "f 1 2 3\n".repeat(100_000));
        let within = |bytes| {
            let budget = Budget::new(&Limits::default().with(Limit::Memory, bytes), 0);
            parse("a.obj", text.as_bytes(), &budget)
        };
        assert!(within(8 << 20).is_ok());
        let error = within(1 << 20).unwrap_err().to_string();
        assert!(error.contains("the limit of memory is"), "{error}");
        // Within a line, too.
        let polygon = format!("v 0 0 0\nf{}\n", " 1".repeat(200_000));
        let budget = Budget::new(&Limits::default().with(Limit::Memory, 3 << 20), 0);
        let mut reader = Reader { budget: Some(&budget), ..Reader::default() };
        assert!(polygon.lines().any(|line| reader.line(line.as_bytes()).is_err()));
        assert!(reader.triangles.len() < 130_000, "{}", reader.triangles.len());
    }

    #[test]
    fn damaged_files_are_errors_not_panics() {
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 1\nvn 0 0 1\nf 1/1/1 2//1 3/1\nf -4 -3 -2 -1\n";
        let mut random = crate::math::random::Stream::new(6);
        let mut read_well = 0;
        for _ in 0..20_000 {
            let mut bytes = text.as_bytes().to_vec();
            for _ in 0..1 + random.bits() % 4 {
                let place = (random.bits() % bytes.len() as u64) as usize;
                bytes[place] = b"0123456789 -/.\nvfe\xff"[(random.bits() % 19) as usize];
            }
            if let Ok(Mesh { vertices, triangles, .. }) = read(&bytes) {
                let count = vertices.positions.len();
                assert!(triangles.iter().flatten().all(|i| (*i as usize) < count));
                assert!([0, count].contains(&vertices.normals.len()));
                assert!([0, count].contains(&vertices.uvs.len()));
                read_well += 1;
            }
        }
        assert!(read_well > 1000);
    }
}
