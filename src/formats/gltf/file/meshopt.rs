//! Buffer views that are compressed by meshoptimizer (EXT_meshopt_compression, KHR_meshopt_compression).

use meshoptimizer_rs::{Error, Limits, Workspace, codec};

use super::Gltf;
use super::document::MeshoptView;
use crate::limits::Budget;

/// What restores elements of this number and stride.
type Filter = fn(&mut [u8], usize, usize, &mut Workspace) -> Result<(), Error>;

/// Decompresses a buffer view.
pub(crate) fn decoded(gltf: &Gltf<'_>, view: &MeshoptView) -> Result<Vec<u8>, String> {
    let bytes = gltf.bytes(view.buffer, view.byte_offset, view.byte_length)?;
    decompressed(bytes.ok_or("the compressed data exceed their buffer")?, view, gltf.budget)
}

/// The elements of `view`, whose compressed data are `bytes`. Both versions of the streams are read under both names of
/// the extension, although the older one has only version 0.
fn decompressed(bytes: &[u8], view: &MeshoptView, budget: &Budget) -> Result<Vec<u8>, String> {
    let bad = |error| format!("cannot decompress: {error}");
    let size = |number: u64| usize::try_from(number).map_err(|_| "too many elements".to_owned());
    let (count, stride) = (size(view.count)?, size(view.byte_stride)?);
    let decode = match &*view.mode {
        "ATTRIBUTES" => codec::decode_vertex_buffer,
        "TRIANGLES" => codec::decode_index_buffer,
        "INDICES" => codec::decode_index_sequence,
        mode => return Err(format!("the compression mode `{mode}` is not supported")),
    };
    let filter: Option<Filter> = match view.filter.as_deref().unwrap_or("NONE") {
        "NONE" => None,
        _ if view.mode != "ATTRIBUTES" => {
            return Err("only the compression mode ATTRIBUTES can have a filter".to_owned());
        }
        "OCTAHEDRAL" => Some(codec::decode_filter_oct),
        "QUATERNION" => Some(codec::decode_filter_quat),
        "EXPONENTIAL" => Some(codec::decode_filter_exp),
        "COLOR" => Some(codec::decode_filter_color),
        filter => return Err(format!("the compression filter `{filter}` is not supported")),
    };
    if count == 0 {
        return Ok(Vec::new());
    }
    let length = count.checked_mul(stride).ok_or("too many elements")?;
    budget.hold(length as u64)?;
    let max_bytes = length.saturating_mul(2).saturating_add(1 << 16);
    let mut workspace = Workspace::new(Limits { max_bytes, ..Limits::default() });
    let mut elements = decode(count, stride, bytes, &mut workspace).map_err(bad)?;
    if let Some(filter) = filter {
        filter(&mut elements, count, stride, &mut workspace).map_err(bad)?;
    }
    Ok(elements)
}

#[cfg(test)]
mod tests {
    use meshoptimizer_rs::codec::VertexEncoding;
    use serde_json::{Value, json};

    use super::*;

    fn decode(bytes: &[u8], view: &Value) -> Result<Vec<u8>, String> {
        let view = serde_json::from_value(view.clone()).unwrap();
        decompressed(bytes, &view, &Budget::new(&crate::limits::Limits::default(), 0))
    }

    /// The vertices of a triangle, as gltfpack 1.3 writes them with `-cz`.
    #[test]
    fn streams_of_version_1_are_read() {
        let mut stream = vec![0xa1, 0xff, 0xaa, 0, 1, 2, 0, 0x7e, 0x3d, 0, 0, 1, 0, 0, 0x7e];
        stream.resize(39, 0);
        let view = json!({ "buffer": 0, "byteLength": 39, "byteStride": 8, "mode": "ATTRIBUTES", "count": 3 });
        let shorts: Vec<u16> = decode(&stream, &view)
            .unwrap()
            .chunks(2)
            .map(|pair| u16::from_le_bytes([pair[0], pair[1]]))
            .collect();
        assert_eq!(shorts, [0, 0, 0, 0, 16383, 0, 0, 0, 8192, 16383, 0, 0]);
        let newer = [&[0xa2], &stream[1..]].concat();
        assert!(decode(&newer, &view).unwrap_err().contains("unsupported stream version"));
        assert!(decode(&stream[..20], &view).is_err());
    }

    /// KHR_meshopt_compression, filter COLOR: red is y + co − cg, green y + cg, and blue y − co − cg.
    #[test]
    fn filters_are_applied() {
        let stream = codec::encode_vertex_buffer(
            &[100, 20, 30, 255],
            1,
            4,
            VertexEncoding::DEFAULT,
            &mut Workspace::default(),
        )
        .unwrap();
        let mut view = json!({
            "buffer": 0, "byteLength": 9, "byteStride": 4, "mode": "ATTRIBUTES", "filter": "COLOR", "count": 1
        });
        assert_eq!(decode(&stream, &view).unwrap(), [90, 130, 50, 255]);
        view["filter"] = json!("SEPIA");
        assert!(decode(&stream, &view).unwrap_err().contains("filter `SEPIA` is not supported"));
        view["mode"] = json!("TRIANGLES");
        assert!(decode(&stream, &view).unwrap_err().contains("only the compression mode"));
    }
}
