//! Reader of Wavefront OBJ files, on top of tobj.

use std::collections::BTreeSet;

use glam::Vec3;
use tobj::LoadError;

use super::indexed::{Mesh, in_range};
use crate::error::{Error, Result};
use crate::scene::budget::Budget;

const VERTEX: &str = "a vertex is `v` and three numbers";
const FACE: &str = "a face is `f` and three or more vertex numbers";

/// Keywords of ignored data, each with the name of that data in messages.
const IGNORED: [(&str, &str); 3] =
    [("vn", "normals"), ("vt", "texture coordinates"), ("usemtl", "materials")];

/// Reads the vertices and faces of all groups in `bytes`. Errors call the file `name`.
pub(super) fn parse(name: &str, bytes: &[u8], budget: &Budget) -> Result<Mesh> {
    let check = |more| budget.check(more).map_err(|message| Error::input(name, "", message));
    check(text_memory(bytes))?;
    let text = String::from_utf8_lossy(bytes);
    let error = |(line, message): (usize, String)| Error::input(name, line.to_string(), message);
    let positions = Positions::new(text.trim_start_matches('\u{feff}')).map_err(error)?;
    check(positions.memory())?;
    let mut rest = positions.text.as_bytes();
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..tobj::LoadOptions::default()
    };
    let loaded = tobj::load_obj_buf(&mut rest, &options, |_| Ok(Default::default()));
    let (models, _) = loaded.map_err(|what| {
        // tobj stops at the line that it cannot parse.
        let read = &positions.text[..positions.text.len() - rest.len()];
        error(positions.explain(&what, read.lines().count()))
    })?;
    let mut mesh = Mesh { ignored: positions.ignored.clone(), ..Mesh::default() };
    for model in &models {
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(model.mesh.positions.chunks_exact(3).map(Vec3::from_slice));
        let indices = model.mesh.indices.chunks_exact(3);
        mesh.triangles.extend(indices.map(|i| [first + i[0], first + i[1], first + i[2]]));
    }
    Ok(mesh)
}

/// An OBJ file reduced to its `v` and `f` lines. Faces keep only the indices of positions.
///
/// The other lines are blank, so that line numbers stay the same and errors in data that a mesh
/// does not need are ignored.
struct Positions {
    text: String,
    vertices: i64,
    faces: u64,
    corners: u64,
    /// Names of the ignored data.
    ignored: BTreeSet<&'static str>,
}

/// Bytes of memory for two copies of the text and for the words of its longest line.
fn text_memory(bytes: &[u8]) -> u64 {
    // Each byte of invalid UTF-8 becomes three bytes, in a string that is reallocated as it
    // grows.
    let texts = if std::str::from_utf8(bytes).is_ok() { 2 } else { 12 };
    let longest = bytes.split(|byte| *byte == b'\n').map(<[u8]>::len).max().unwrap_or(0);
    (texts * bytes.len() + 32 * longest) as u64
}

impl Positions {
    /// Reduces the text of a file. `Err` holds the line number and the message.
    fn new(file: &str) -> Result<Self, (usize, String)> {
        let (mut text, mut vertices) = (String::with_capacity(file.len()), 0);
        let (mut faces, mut corners_of_all, mut ignored) = (0, 0, BTreeSet::new());
        for (line, number) in file.lines().zip(1..) {
            let line = line.split('#').next().unwrap_or_default();
            let mut words: Vec<&str> = line.split_whitespace().collect();
            let wrong = |message: &str| Err((number, message.to_owned()));
            match words.first() {
                Some(&"v" | &"f") if words.last() == Some(&"\\") => {
                    return wrong(
                        "continued lines are not supported, join this line with the next",
                    );
                }
                Some(&"v") => {
                    // Three coordinates and w, or three coordinates and a colour.
                    if words.len() > 5 {
                        ignored.insert("colours");
                    }
                    words.truncate(if words.len() > 5 { 4 } else { 5 });
                    if !is_in_range(&words[1..]) {
                        return wrong("coordinates must be finite and within ±1e9");
                    }
                    text.push_str(&words.join(" "));
                    vertices += 1;
                }
                Some(&"f") => {
                    let corners = words[1..].iter().map(|word| word.split('/').next());
                    let corners: Vec<&str> = corners.flatten().collect();
                    if corners.len() < 3 || corners.contains(&"") {
                        return wrong(FACE);
                    }
                    faces += 1;
                    corners_of_all += corners.len() as u64;
                    text.push_str("f ");
                    text.push_str(&corners.join(" "));
                }
                Some(word) => {
                    ignored.extend(
                        IGNORED.iter().filter(|(key, _)| key == word).map(|(_, name)| *name),
                    );
                }
                None => {}
            }
            text.push('\n');
        }
        Ok(Self { text, vertices, faces, corners: corners_of_all, ignored })
    }

    /// Bytes of memory for tobj's data and for the mesh. The factors were measured on vertices,
    /// triangles and polygons, and include the growth of the lists.
    fn memory(&self) -> u64 {
        2 * self.text.len() as u64
            + 120 * self.vertices as u64
            + 320 * self.faces
            + 120 * self.corners
    }

    /// Returns the line and message of an error that occurred after `read` lines.
    fn explain(&self, error: &LoadError, read: usize) -> (usize, String) {
        match error {
            LoadError::PositionParseError => (read, VERTEX.to_owned()),
            LoadError::FaceParseError => (read, FACE.to_owned()),
            // tobj finds this error only after reading the whole file.
            LoadError::FaceVertexOutOfBounds => (
                self.first_face_beyond().unwrap_or(read),
                format!(
                    "the face refers to a missing vertex, the file has {} vertices",
                    self.vertices
                ),
            ),
            other => (read, other.to_string()),
        }
    }

    /// Returns the line of the first face that refers to a missing vertex.
    fn first_face_beyond(&self) -> Option<usize> {
        let mut before = 0;
        let line = self.text.lines().position(|line| {
            before += i64::from(line.starts_with('v'));
            let is_wrong = |word: &str| {
                let number = word.parse().unwrap_or(0);
                number == 0 || number > self.vertices || number < -before
            };
            line.starts_with('f') && line.split_whitespace().skip(1).any(is_wrong)
        })?;
        Some(line + 1)
    }
}

/// Whether the coordinates, divided by w if it is given, are within the range of a scene. Words
/// that are not numbers are ignored here, because tobj reports them.
fn is_in_range(words: &[&str]) -> bool {
    let numbers: Vec<f32> = words.iter().filter_map(|word| word.parse().ok()).collect();
    let w = if let [_, _, _, w] = numbers[..] { w } else { 1.0 };
    w == 0.0 || numbers.iter().take(3).all(|c| in_range(Vec3::splat(c / w)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;

    fn message(text: &str) -> String {
        parse("a.obj", text.as_bytes(), &Budget::new(&Limits::default(), 0))
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn groups_polygons_and_relative_indices() {
        let text = "\u{feff}v 0 0 0 # first\n# caf\u{e9}\nmtllib none.mtl\no one\nv 1 0 0 1\nv 1 1 0 0.1 0.2 0.3\n\
                    vt 0 0\nvn 0 0 1\nusemtl red\nf 1/1/1 2/9/1 3//7 # top\ng two\nv 0 1 0\n\
                    f -4 -3 -2 -1\nl 1 2\np 1\n";
        let mesh = parse("a.obj", text.as_bytes(), &Budget::new(&Limits::default(), 0)).unwrap();
        let at = |t: [u32; 3]| t.map(|i| mesh.vertices[i as usize].to_array());
        let (a, b, c, d) = ([0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]);
        let triangles: Vec<_> = mesh.triangles.iter().map(|t| at(*t)).collect();
        assert_eq!(triangles, [[a, b, c], [a, b, c], [a, c, d]]);
    }

    #[test]
    fn errors_name_the_line() {
        let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        let wrong = "a.obj:3: a vertex is `v` and three numbers";
        assert_eq!(message("v 0 0 0\nv 1 0 0\nv 0 x 0\nf 1 2 3"), wrong);
        assert_eq!(message("v 0 0 0\nv 1 0 0\nv 0 1\nf 1 2 3\n"), wrong);
        for bad in ["1 2 x", "", "1 2", "1 2 3 /4", "1 2 /3"] {
            let text = format!("{vertices}\nf {bad}\nf 1 2 3");
            assert_eq!(message(&text), format!("a.obj:5: {FACE}"));
        }
        let text = format!("{vertices}f 1 2 \\\n3\n");
        assert!(message(&text).starts_with("a.obj:4: continued lines are not supported"));
        let beyond = "the face refers to a missing vertex, the file has 3 vertices";
        for face in ["1 2 4", "0 1 2", "1 2 -4", "1 2 99999999999"] {
            let text = format!("{vertices}\no a\nf 1 2 3\nf {face}\no b\nf 1 2 3\n");
            assert_eq!(message(&text), format!("a.obj:7: {beyond}"));
        }
        for bad in ["nan 0", "inf 0", "1e39 0", "2e9 0", "5e8 0 0.25", "0 0 nan", "0 1 1e-45"] {
            let text = format!("{vertices}v 0 {bad}\nf 1 2 4\n");
            let range = "a.obj:4: coordinates must be finite and within ±1e9";
            assert_eq!(message(&text), range);
        }
    }

    #[test]
    fn damaged_files_are_errors_not_panics() {
        let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/1/1 2/2/2 3/3/3\nf -4 -3 -2 -1\n";
        let mut random = crate::math::random::Stream::new(6);
        for _ in 0..20_000 {
            let mut bytes = text.as_bytes().to_vec();
            for _ in 0..1 + random.bits() % 4 {
                let place = (random.bits() % bytes.len() as u64) as usize;
                bytes[place] = b"0123456789 -/.\nvfe\xff"[(random.bits() % 19) as usize];
            }
            if let Ok(mesh) = parse("a.obj", &bytes, &Budget::new(&Limits::default(), 0)) {
                let count = mesh.vertices.len() as u32;
                assert!(mesh.triangles.iter().flatten().all(|i| *i < count));
            }
        }
    }
}
