//! Upper bounds on the content of a PLY file, from its header and its length.
//!
//! The length matters because headers may claim any number of rows.

use ply_rs_bw::ply::{ElementDef, Encoding, Header, PropertyDef, PropertyType, ScalarType};

use super::{ROWS, STRIPS};

/// Upper bounds on the content of a PLY file.
pub(crate) struct Most {
    triangles: usize,
    /// Number of list entries that are in memory at once.
    entries: usize,
}

impl Most {
    /// Returns the bounds for `bytes` bytes after `header`.
    ///
    /// # Errors
    /// If `bytes` is too small for the rows of an element. `Err` holds the name of the
    /// element and the message.
    pub(crate) fn new(header: &Header, bytes: usize) -> Result<Self, (String, String)> {
        let is_text = header.encoding == Encoding::Ascii;
        let size = |scalar: &ScalarType| match scalar {
            // A digit and a separator.
            _ if is_text => 2,
            ScalarType::Char | ScalarType::UChar => 1,
            ScalarType::Short | ScalarType::UShort => 2,
            ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
            ScalarType::Double => 8,
        };
        let least = |property: &PropertyDef| match &property.data_type {
            PropertyType::Scalar(scalar) | PropertyType::List(scalar, _) => size(scalar),
        };
        // The last line may lack its line break.
        let mut rest = bytes + usize::from(is_text);
        for element in header.elements.values() {
            let least: usize = element.properties.values().map(least).sum();
            // Even an empty line of text takes one byte.
            let row = if is_text { least.max(1) } else { least };
            let most = rest.checked_div(row).unwrap_or(0);
            if element.count > most {
                let count = element.count;
                let message = format!(
                    "the header says {count} rows, but the file has room for at most {most}"
                );
                return Err((element.name.clone(), message));
            }
            rest -= row * element.count;
        }
        let lists = |element: &ElementDef| {
            let list = |property: &PropertyDef| match &property.data_type {
                PropertyType::Scalar(_) => None,
                PropertyType::List(count, entry) => Some((count.clone(), rest / size(entry))),
            };
            element.properties.values().filter_map(list).collect::<Vec<_>>()
        };
        let faces = header.elements.get("face");
        let strips = header.elements.get(STRIPS);
        let strips = strips.iter().flat_map(|strips| lists(strips)).map(|(_, entries)| entries);
        let corners = faces.iter().flat_map(|faces| lists(faces)).map(|(_, entries)| entries);
        let twice = 2 * faces.map_or(0, |faces| faces.count);
        let at_once = |(count, entries): (ScalarType, usize)| match count {
            _ if is_text => entries,
            ScalarType::Char | ScalarType::UChar => entries.min(ROWS << 8),
            ScalarType::Short | ScalarType::UShort => entries.min(ROWS << 16),
            _ => entries,
        };
        let all = header.elements.values().flat_map(lists).map(at_once);
        Ok(Self {
            triangles: (corners.max().unwrap_or(0).saturating_sub(twice))
                .max(strips.max().unwrap_or(0)),
            entries: all.max().unwrap_or(0),
        })
    }

    /// Returns the bytes of memory for reading a mesh whose vertices take `vertices` bytes. `text` is the content
    /// of a text file, or `None` for a binary one.
    pub(crate) fn memory(&self, vertices: usize, text: Option<&[u8]>) -> u64 {
        let longest = |text: &[u8]| text.split(|byte| *byte == b'\n').map(<[u8]>::len).max();
        // The bytes of ROWS rows. Each word takes at least two bytes and is held both as text and
        // as a number.
        let rows = text.map_or(usize::MAX, |text| {
            longest(text).unwrap_or(0).saturating_mul(ROWS).min(text.len())
        });
        let entries = 32 * self.entries.min(rows);
        let line = 32 * text.and_then(longest).unwrap_or(0);
        // While the lists of triangles and polygons grow, they are in memory twice.
        (vertices + 48 * self.triangles + entries + line) as u64
    }
}
