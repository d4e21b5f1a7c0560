//! Reader of PLY files, ASCII and binary, on top of ply-rs-bw.

mod mesh;
mod most;
mod row;

use std::io::ErrorKind;

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::Encoding;

use self::mesh::{Attributes, add_faces, add_vertices};
use self::most::Most;
use self::row::Row;
use super::mesh::Format;
use crate::error::{Error, Result};
use crate::limits::Budget;
use crate::scene::IndexedMesh;

/// The Polygon File Format.
pub(crate) static FORMAT: Format = Format { extension: "ply", parse };

/// Largest size of a header in bytes.
const MAX_HEADER: usize = 1 << 16;
/// Last line of a header.
const END: &[u8] = b"end_header";
/// Number of rows that are in memory at once.
const ROWS: usize = 1024;

/// Reads the vertices and faces in `bytes`. Errors call the file `name`.
pub(crate) fn parse(name: &str, bytes: &[u8], budget: &Budget) -> Result<IndexedMesh> {
    let parser = Parser::<Row>::new();
    let mut reader = Reader::new(bytes);
    let mut lines = bytes[..bytes.len().min(MAX_HEADER)].split(|byte| *byte == b'\n');
    if bytes.len() > MAX_HEADER && !lines.any(|line| line.trim_ascii_end() == END) {
        let message = format!("the header must end with `end_header` within {MAX_HEADER} bytes");
        return Err(Error::input(name, "", message));
    }
    let header = parser.read_header(&mut reader).map_err(|error| explain(name, &error, None))?;
    let is_text = header.encoding == Encoding::Ascii;
    let most = Most::new(&header, reader.get_ref().len())
        .map_err(|(place, message)| Error::input(name, place, message))?;
    let count = header.elements.get("vertex").map_or(0, |vertex| vertex.count);
    let attributes = Attributes::new(&header);
    budget
        .check(most.memory(count * attributes.bytes(), is_text.then_some(*reader.get_ref())))
        .map_err(|message| Error::input(name, "", message))?;
    let mut mesh = IndexedMesh::default();
    for (element, all) in &header.elements {
        let mut some = all.clone();
        for first in (0..all.count).step_by(ROWS) {
            some.count = ROWS.min(all.count - first);
            let first_line = reader.line();
            let rows = parser.read_payload_for_element(&mut reader, &some, &header);
            let rows = rows.map_err(|error| match error.kind() {
                ErrorKind::UnexpectedEof => {
                    let message = format!("the file ends before the last of {} rows", all.count);
                    Error::input(name, element, message)
                }
                _ => explain(name, &error, (!is_text).then_some(element)),
            })?;
            let added = match element.as_str() {
                "vertex" => add_vertices(&mut mesh, &rows, attributes),
                "face" => add_faces(&mut mesh, &rows, count),
                _ => Ok(()),
            };
            added.map_err(|(row, message)| {
                // The line in a text file, or the row number in a binary one.
                let place = match is_text {
                    true => (first_line + row).to_string(),
                    false => format!("{element}[{}]", first + row),
                };
                Error::input(name, place, message)
            })?;
        }
    }
    Ok(mesh)
}

/// Converts an error of ply-rs-bw. The place is `element` if given, else the line that the error
/// reports.
fn explain(name: &str, error: &ParseError, element: Option<&String>) -> Error {
    let (place, text) = match error.line() {
        Some(line) => {
            (line.to_string(), error.to_string().replacen(&format!("Line {line}: "), "", 1))
        }
        None => (String::new(), error.to_string()),
    };
    // Line numbers mean nothing in binary data.
    let place = element.cloned().unwrap_or(place);
    // The library's messages span several lines and may repeat a whole line of the file.
    let short: String = text.chars().take(400).collect();
    let text = short.split_whitespace().collect::<Vec<_>>().join(" ");
    let short: String = text.chars().take(200).collect();
    Error::input(name, place, format!("PLY syntax: {short}"))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::limits::{Limit, Limits};

    const HEADER: &str = "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\n\
        property float x\nproperty double y\nproperty int z\nproperty uchar red\n\
        element face 2\nproperty list uchar int vertex_indices\nend_header\n";
    const VERTICES: &str = "0 0 0 255\n1 0.5 0 255\n1 1 0 255\n0 1 2 255\n";

    fn budget() -> Budget {
        Budget::new(&Limits::default(), 0)
    }

    fn message(text: &str) -> String {
        let message = parse("a.ply", text.as_bytes(), &budget()).unwrap_err().to_string();
        assert!(!message.contains('\n') && message.len() < 300);
        message
    }

    #[test]
    fn text_of_any_types_with_polygons() {
        let text = format!("{HEADER}{VERTICES}3 0 1 2\n4 0 1 2 3\n");
        let mesh = parse("a.ply", text.as_bytes(), &budget()).unwrap();
        assert_eq!(mesh.vertices.positions[1], Vec3::new(1.0, 0.5, 0.0));
        assert_eq!(mesh.vertices.positions[3], Vec3::new(0.0, 1.0, 2.0));
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn binary_of_both_orders() {
        for (format, little) in [("binary_little_endian", true), ("binary_big_endian", false)] {
            let header = format!(
                "ply\nformat {format} 1.0\nelement vertex 3\nproperty float x\n\
                 property float y\nproperty float z\nelement face 1\n\
                 property list uchar uint vertex_index\nend_header\n"
            );
            let mut bytes = header.into_bytes();
            for c in [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.5] {
                bytes.extend(if little { c.to_le_bytes() } else { c.to_be_bytes() });
            }
            bytes.push(3);
            for i in [2u32, 0, 1] {
                bytes.extend(if little { i.to_le_bytes() } else { i.to_be_bytes() });
            }
            let mesh = parse("a.ply", &bytes, &budget()).unwrap();
            assert_eq!(mesh.vertices.positions[2], Vec3::new(0.0, 1.0, 0.5));
            assert_eq!(mesh.triangles, [[2, 0, 1]]);
            let cut = parse("a.ply", &bytes[..bytes.len() - 2], &budget()).unwrap_err().to_string();
            assert!(
                cut.starts_with("a.ply:face: the file ends before the last of 1 rows"),
                "{cut}"
            );
            let last = bytes.len() - 1;
            bytes[if little { last - 3 } else { last }] = 3;
            let wrong = parse("a.ply", &bytes, &budget()).unwrap_err().to_string();
            assert_eq!(
                wrong,
                "a.ply:face[0]: the face refers to a missing vertex, the file has 3 vertices"
            );
        }
    }

    #[test]
    fn errors_name_the_line() {
        let faces = "3 0 1 2\n3 0 2 3\n";
        let beyond = "the face refers to a missing vertex, the file has 4 vertices";
        let text = format!("{HEADER}{VERTICES}3 0 1 2\n3 0 2 4\n");
        assert_eq!(message(&text), format!("a.ply:17: {beyond}"));
        let text = format!("{HEADER}{VERTICES}3 0 -1 2\n3 0 2 3\n");
        assert_eq!(message(&text), format!("a.ply:16: {beyond}"));
        let text = format!("{HEADER}{VERTICES}2 0 1\n3 0 2 3\n");
        assert!(message(&text).starts_with("a.ply:16: a face needs"));
        let text = format!("{HEADER}{}{faces}", VERTICES.replace("0.5", "2e9"));
        assert!(message(&text).starts_with("a.ply:13: a vertex needs x, y and z"));
        let text = format!("{}{VERTICES}{faces}", HEADER.replace("float x", "float u"));
        assert!(message(&text).starts_with("a.ply:12: a vertex needs x, y and z"));
        let text = format!("{HEADER}{}{faces}", VERTICES.replace("0.5", "half"));
        assert!(message(&text).starts_with("a.ply:13: PLY syntax"), "{}", message(&text));
        let text = format!("{}{VERTICES}{faces}", HEADER.replace("vertex 4", "vertex four"));
        assert!(message(&text).starts_with("a.ply:4: PLY syntax"), "{}", message(&text));
        let cut = format!("{HEADER}{VERTICES}3 0 1 2    \n");
        assert_eq!(message(&cut), "a.ply:face: the file ends before the last of 2 rows");
        assert!(message("solid cube\n").starts_with("a.ply:1: PLY syntax"));
        assert!(message("").starts_with("a.ply"));
    }

    #[test]
    fn headers_alone_allocate_nothing() {
        for (format, properties, count) in [
            ("binary_little_endian", "", 1_000_000_000_000u64),
            ("binary_big_endian", "", 1),
            ("binary_big_endian", "property uchar x\nelement face 2\nproperty uchar y\n", 0),
            ("binary_little_endian", "property uchar x\n", 1_000_000_000_000),
            ("ascii", "", 1_000_000_000_000),
        ] {
            let text = format!(
                "ply\nformat {format} 1.0\nelement vertex {count}\n{properties}end_header\n"
            );
            let error = message(&text);
            let element = if count == 0 { "face" } else { "vertex" };
            assert!(error.starts_with(&format!("a.ply:{element}: the header says")), "{error}");
        }
    }

    /// The limit is checked before memory is allocated. Typical meshes need little memory, but
    /// polygons with many corners need much.
    #[test]
    fn memory_is_limited() {
        let text = format!("{HEADER}{VERTICES}3 0 1 2\n4 0 1 2 3\n");
        let least = (0..).find(|&bytes| {
            let budget = Budget::new(&Limits::default().with(Limit::Memory, bytes), 0);
            parse("a.ply", text.as_bytes(), &budget).is_ok()
        });
        // Four vertices, at most five triangles, and lines of at most 9 bytes.
        assert!((84..2000).contains(&least.unwrap()), "{least:?}");
        let budget = Budget::new(&Limits::default().with(Limit::Memory, 10), 0);
        let error = parse("a.ply", text.as_bytes(), &budget).unwrap_err().to_string();
        assert!(error.starts_with("a.ply: the limit of memory is 10 bytes, this needs"), "{error}");
    }

    #[test]
    fn damaged_files_are_errors_not_panics() {
        let text = format!("{HEADER}{VERTICES}3 0 1 2\n4 0 1 2 3\n").into_bytes();
        let mut random = crate::math::random::Stream::new(5);
        for _ in 0..20_000 {
            let mut bytes = text.clone();
            bytes.truncate(bytes.len() - (random.bits() % 40) as usize);
            for _ in 0..random.bits() % 4 {
                let place = (random.bits() % bytes.len() as u64) as usize;
                bytes[place] = random.bits() as u8;
            }
            if let Ok(mesh) = parse("a.ply", &bytes, &budget()) {
                let count = mesh.vertices.positions.len() as u32;
                assert!(mesh.triangles.iter().flatten().all(|i| *i < count));
            }
        }
    }
}
