//! Reader of PLY files, ASCII and binary, on top of ply-rs-bw.

mod corners;
mod header;
mod mesh;
mod most;
mod row;

use std::io::ErrorKind;

use glam::DVec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::Encoding;

use self::corners::Corners;
use self::header::Header;
use self::mesh::{Attributes, add_faces, add_strips, add_vertices};
use self::most::Most;
use self::row::Row;
use super::mesh::Format;
use super::polygons::clip_concave;
use crate::error::{Error, Result};
use crate::limits::Budget;
use crate::scene::IndexedMesh;

/// The Polygon File Format.
pub(crate) static FORMAT: Format = Format { extension: "ply", parse: parse_from };

/// Largest size of a header in bytes.
const MAX_HEADER: usize = 1 << 16;
/// Number of rows that are in memory at once.
const ROWS: usize = 1024;
/// The element of triangle strips.
const STRIPS: &str = "tristrips";

/// As [`parse`], relative to `origin`, which is subtracted after the library has rounded the positions.
fn parse_from(name: &str, bytes: &[u8], origin: DVec3, budget: &Budget) -> Result<IndexedMesh> {
    let mut mesh = parse(name, bytes, budget)?;
    if origin != DVec3::ZERO {
        for position in &mut mesh.vertices.positions {
            *position = (position.as_dvec3() - origin).as_vec3();
        }
    }
    Ok(mesh)
}

/// Reads the vertices and faces in `bytes`. Errors call the file `name`.
pub(crate) fn parse(name: &str, bytes: &[u8], budget: &Budget) -> Result<IndexedMesh> {
    let parser = Parser::<Row>::new();
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    let Header { text, bytes: begin } =
        Header::new(bytes, MAX_HEADER).map_err(|message| Error::input(name, "", message))?;
    let header = parser
        .read_header(&mut Reader::new(text.as_bytes()))
        .map_err(|error| bad_header(name, &text, &error))?;
    let rows = &bytes[begin..];
    let (mut reader, lines_before) = (Reader::new(rows), text.lines().count());
    let is_text = header.encoding == Encoding::Ascii;
    let most = Most::new(&header, rows.len())
        .map_err(|(place, message)| Error::input(name, place, message))?;
    let count = header.elements.get("vertex").map_or(0, |vertex| vertex.count);
    let attributes = Attributes::new(&header);
    budget
        .check(most.memory(count * attributes.bytes(), is_text.then_some(rows)))
        .map_err(|message| Error::input(name, "", message))?;
    let (mut mesh, mut polygons) = (IndexedMesh::default(), Vec::new());
    let mut corners = Corners::new(&header);
    for (element, all) in &header.elements {
        let mut some = all.clone();
        for first in (0..all.count).step_by(ROWS) {
            some.count = ROWS.min(all.count - first);
            let first_line = lines_before + reader.line().max(1);
            let rows = parser.read_payload_for_element(&mut reader, &some, &header);
            let rows = rows.map_err(|error| match error.kind() {
                ErrorKind::UnexpectedEof => {
                    let message = format!("the file ends before the last of {} rows", all.count);
                    Error::input(name, element, message)
                }
                _ if is_text => {
                    let line = lines_before + error.line().unwrap_or(1);
                    let message = "the row must have a number for each property in the header";
                    Error::input(name, line.to_string(), format!("PLY syntax: {message}"))
                }
                _ => Error::input(name, element, "PLY syntax: the length of a list is invalid"),
            })?;
            let added = match element.as_str() {
                "vertex" => add_vertices(&mut mesh, &rows, attributes),
                "face" => add_faces(&mut mesh, &mut polygons, &mut corners, &rows, count),
                STRIPS => add_strips(&mut mesh, &rows, count),
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
            budget
                .check(corners.memory())
                .map_err(|message| Error::input(name, element, message))?;
        }
    }
    // Strips have no such data, so that faces beside them lose theirs.
    if corners.exist() && !header.elements.contains_key(STRIPS) {
        corners.split(&mut mesh);
    }
    let left = clip_concave(&mesh.vertices.positions, &mut mesh.triangles, &polygons);
    mesh.ignored.extend(left);
    Ok(mesh)
}

/// The error of a header that ply-rs-bw does not read. Its own messages have several lines and Rust's names.
fn bad_header(name: &str, text: &str, error: &ParseError) -> Error {
    let Some(line) = error.line() else {
        return Error::input(
            name,
            "",
            "PLY syntax: the header needs a line `format ascii 1.0`, \
             `format binary_little_endian 1.0` or `format binary_big_endian 1.0`",
        );
    };
    let message = match text.lines().nth(line - 1) {
        None if text.is_empty() => "the file is empty".to_owned(),
        None => "the header must end with `end_header`".to_owned(),
        Some(_) if line == 1 => "the first line must be `ply`".to_owned(),
        Some(wrong) => {
            let wrong: String = wrong.trim().chars().take(80).collect();
            format!("`{}` is not a line of a header", wrong.escape_debug())
        }
    };
    Error::input(name, line.to_string(), format!("PLY syntax: {message}"))
}

#[cfg(test)]
mod tests;
