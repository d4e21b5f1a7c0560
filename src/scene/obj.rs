//! Meshes in Wavefront OBJ files, read by tobj.

use glam::Vec3;
use tobj::LoadError;

use super::mesh::{Mesh, in_range};
use crate::error::{Error, Result};

/// The vertices and faces of all groups in `bytes`; `name` is what errors call the file.
pub(super) fn parse(name: &str, bytes: &[u8]) -> Result<Mesh> {
    let text = String::from_utf8_lossy(bytes);
    let positions = Positions::new(&text);
    let mut rest = positions.text.as_bytes();
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..tobj::LoadOptions::default()
    };
    let loaded = tobj::load_obj_buf(&mut rest, &options, |_| Ok(Default::default()));
    let (models, _) = loaded.map_err(|error| {
        // The reader stops at the line that it cannot understand.
        let read = &positions.text[..positions.text.len() - rest.len()];
        let (line, message) = positions.explain(&error, read.lines().count());
        Error::input(name, line.map_or(String::new(), |line| line.to_string()), message)
    })?;
    let mut mesh = Mesh::default();
    for model in &models {
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(model.mesh.positions.chunks_exact(3).map(Vec3::from_slice));
        let indices = model.mesh.indices.chunks_exact(3);
        mesh.triangles.extend(indices.map(|i| [first + i[0], first + i[1], first + i[2]]));
    }
    if mesh.vertices.iter().all(|vertex| in_range(*vertex)) {
        return Ok(mesh);
    }
    let line = positions.first_line(|words| {
        words[0] == "v" && !words[1..].iter().take(3).all(|word| is_coordinate(word))
    });
    let line = line.map_or(String::new(), |line| line.to_string());
    Err(Error::input(name, line, "coordinates must be finite and within ±1e9"))
}

fn is_coordinate(word: &str) -> bool {
    word.parse().is_ok_and(|c: f32| in_range(Vec3::splat(c)))
}

/// An OBJ file without all that a mesh here does not need, so that nothing there can be wrong:
/// line by line the `v` and `f` of the file, faces with positions only.
struct Positions {
    text: String,
    vertices: i64,
}

impl Positions {
    fn new(file: &str) -> Self {
        let (mut text, mut vertices) = (String::with_capacity(file.len()), 0);
        for line in file.lines() {
            let mut words = line.split_whitespace();
            match words.next() {
                Some("v") => {
                    // Three numbers and w, or three and a colour.
                    let count = if words.clone().count() > 4 { 3 } else { 4 };
                    text.push('v');
                    words.take(count).for_each(|word| text.extend([" ", word]));
                    vertices += 1;
                }
                Some("f") => {
                    text.push('f');
                    for word in words {
                        text.push(' ');
                        text.push_str(word.split('/').next().unwrap_or_default());
                    }
                }
                _ => {}
            }
            text.push('\n');
        }
        Self { text, vertices }
    }

    /// The first line whose words are `wanted`, from 1.
    fn first_line(&self, mut wanted: impl FnMut(&[&str]) -> bool) -> Option<usize> {
        let mut lines = self.text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
        lines.position(|words| !words.is_empty() && wanted(&words)).map(|index| index + 1)
    }

    /// Line and message of an error, after `read` lines.
    fn explain(&self, error: &LoadError, read: usize) -> (Option<usize>, String) {
        match error {
            LoadError::PositionParseError | LoadError::ColorParseError => {
                (Some(read), "a vertex is `v` and three numbers".to_owned())
            }
            LoadError::FaceParseError => {
                (Some(read), "a face is `f` and three or more numbers of vertices".to_owned())
            }
            // Found when the whole file is read.
            LoadError::FaceVertexOutOfBounds => {
                let mut before = 0;
                let line = self.first_line(|words| {
                    before += i64::from(words[0] == "v");
                    let is_wrong = |word: &&str| {
                        let number = word.parse().unwrap_or(0);
                        number == 0 || number > self.vertices || number < -before
                    };
                    words[0] == "f" && words[1..].iter().any(is_wrong)
                });
                (line, format!("the face names a vertex beyond the {} of the file", self.vertices))
            }
            LoadError::InvalidPolygon => {
                let line = self.first_line(|words| words == ["f"]);
                (line, "a face is `f` and three or more numbers of vertices".to_owned())
            }
            other => (Some(read), other.to_string()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        parse("a.obj", text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn groups_polygons_and_relative_indices() {
        let text = "# caf\u{e9}\nmtllib none.mtl\no one\nv 0 0 0\nv 1 0 0 1\nv 1 1 0 0.1 0.2 0.3\n\
                    vt 0 0\nvn 0 0 1\nusemtl red\nf 1/1/1 2/9/1 3//7\ng two\nv 0 1 0\n\
                    f -4 -3 -2 -1\nl 1 2\np 1\n";
        let mesh = parse("a.obj", text.as_bytes()).unwrap();
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
        let face = "a face is `f` and three or more numbers of vertices";
        assert_eq!(message(&format!("{vertices}\nf 1 2 x\n")), format!("a.obj:5: {face}"));
        assert_eq!(message(&format!("{vertices}\nf\nf 1 2 3")), format!("a.obj:5: {face}"));
        let beyond = "the face names a vertex beyond the 3 of the file";
        for face in ["1 2 4", "0 1 2", "1 2 -4", "1 2 99999999999"] {
            let text = format!("{vertices}\no a\nf 1 2 3\nf {face}\no b\nf 1 2 3\n");
            assert_eq!(message(&text), format!("a.obj:7: {beyond}"));
        }
        for bad in ["nan", "inf", "1e39", "2e9"] {
            let text = format!("{vertices}v 0 {bad} 0\nf 1 2 4\n");
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
            if let Ok(mesh) = parse("a.obj", &bytes) {
                let count = mesh.vertices.len() as u32;
                assert!(mesh.triangles.iter().flatten().all(|i| *i < count));
            }
        }
    }
}
