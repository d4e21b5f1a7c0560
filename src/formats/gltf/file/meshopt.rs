//! Buffer views that are compressed by meshoptimizer (EXT_meshopt_compression).

use meshoptimizer_rs::codec::{BufferView, Filter, Mode};
use meshoptimizer_rs::{Limits, Workspace};

use super::Gltf;
use super::document::MeshoptView;

/// Decompresses a buffer view.
pub(crate) fn decoded(gltf: &Gltf<'_>, view: &MeshoptView) -> Result<Vec<u8>, String> {
    let bytes = gltf.bytes(view.buffer, view.byte_offset, view.byte_length)?;
    let bytes = bytes.ok_or("the compressed data exceed their buffer")?;
    let bad = |error| format!("cannot decompress: {error}");
    let mode = Mode::parse(&view.mode).map_err(bad)?;
    let filter = Filter::parse(view.filter.as_deref().unwrap_or("NONE")).map_err(bad)?;
    let size = |number: u64| usize::try_from(number).map_err(|_| "too many elements".to_owned());
    let (count, stride) = (size(view.count)?, size(view.byte_stride)?);
    if count == 0 {
        return Ok(Vec::new());
    }
    let layout = BufferView::new(mode, filter, count, stride).map_err(bad)?;
    let length = layout.byte_length() as u64;
    gltf.budget.hold(length)?;
    let max_bytes = 2 * layout.byte_length() + (1 << 16);
    let mut workspace = Workspace::new(Limits { max_bytes, ..Limits::default() });
    layout.decode(bytes, &mut workspace).map_err(bad)
}
