//! What a PLY file can have at most, by its header and its length: headers lie.

use ply_rs_bw::ply::{ElementDef, Encoding, Header, PropertyDef, PropertyType, ScalarType};

use super::ROWS;

/// What there can be at most in a file of a header.
pub(super) struct Most {
    triangles: usize,
    /// Entries of lists that are in memory at once.
    entries: usize,
}

impl Most {
    /// In `bytes` bytes after `header`; `Err` where there cannot be as many rows of an element, with its name.
    pub(super) fn new(header: &Header, bytes: usize) -> Result<Self, (String, String)> {
        let is_text = header.encoding == Encoding::Ascii;
        let size = |scalar: &ScalarType| match scalar {
            // A digit and what parts it from the next.
            _ if is_text => 2,
            ScalarType::Char | ScalarType::UChar => 1,
            ScalarType::Short | ScalarType::UShort => 2,
            ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
            ScalarType::Double => 8,
        };
        let least = |property: &PropertyDef| match &property.data_type {
            PropertyType::Scalar(scalar) | PropertyType::List(scalar, _) => size(scalar),
        };
        // The last line need not end.
        let mut rest = bytes + usize::from(is_text);
        for element in header.elements.values() {
            let least: usize = element.properties.values().map(least).sum();
            // Even an empty line of text is one.
            let row = if is_text { least.max(1) } else { least };
            let most = rest.checked_div(row).unwrap_or(0);
            if element.count > most {
                let count = element.count;
                let message = format!("the header says {count} rows, there can be {most} at most");
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
            triangles: corners.max().unwrap_or(0).saturating_sub(twice),
            entries: all.max().unwrap_or(0),
        })
    }

    /// Bytes of memory for a mesh of so many vertices, while `text`, if it is one, is read.
    pub(super) fn memory(&self, vertices: usize, text: Option<&[u8]>) -> u64 {
        let longest = |text: &[u8]| text.split(|byte| *byte == b'\n').map(<[u8]>::len).max();
        // Rows of words of two bytes, as text and as numbers.
        let rows = text.map_or(usize::MAX, |text| {
            longest(text).unwrap_or(0).saturating_mul(ROWS).min(text.len())
        });
        let entries = 32 * self.entries.min(rows);
        let line = 32 * text.and_then(longest).unwrap_or(0);
        // While the list of triangles grows, it is there twice.
        (12 * vertices + 36 * self.triangles + entries + line) as u64
    }
}
