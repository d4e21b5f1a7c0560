//! Decodes KTX2 files with Basis Universal textures, which glTF files have by `KHR_texture_basisu`.

use basisu::{DecodeFlags, TargetFormat, Transcoder};
use image::{DynamicImage, RgbaImage};

use super::size::{Allow, Size};
use crate::limits::MAX_SIDE;

/// How files begin.
pub(super) const SIGNATURE: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\n";
/// Bytes of the header before the index of levels.
const HEADER: usize = 80;
/// Bytes of memory per pixel: the blocks, the decoded colours, and a copy.
const PER_PIXEL: u64 = 12;

/// Decodes the largest level of a file with this content.
pub(super) fn decode(bytes: &[u8], allow: Allow<'_>) -> Result<DynamicImage, String> {
    let damaged = || "damaged image: it is not a valid KTX2 file".to_owned();
    let header = bytes.get(..HEADER).ok_or_else(damaged)?;
    let word = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|i| header[at + i]));
    let [format, width, height, depth, layers, faces] = [12, 20, 24, 28, 32, 36].map(word);
    if format != 0 {
        return Err("unsupported image: KTX2 files must have Basis Universal textures".to_owned());
    }
    if depth > 1 || layers > 1 || faces > 1 {
        return Err(
            "unsupported image: KTX2 files must have one image, not an array, cube or volume"
                .to_owned(),
        );
    }
    if ![width, height].iter().all(|side| (1..=MAX_SIDE).contains(side)) {
        return Err(format!("damaged image: its size is {width} × {height} pixels"));
    }
    let pixels = u64::from(width) * u64::from(height);
    allow(Size { pixels, deep: false, memory: bytes.len() as u64 + PER_PIXEL * pixels })?;
    let file = Transcoder::new(bytes).map_err(|_| damaged())?;
    let colors = file.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE);
    let colors = colors.map_err(|error| match error {
        basisu::Error::Unsupported { source, .. } => {
            format!("unsupported image: KTX2 files with {source:?} blocks")
        }
        _ => damaged(),
    })?;
    RgbaImage::from_raw(width, height, colors).map(DynamicImage::from).ok_or_else(damaged)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 8 × 4 pixels, half of them with an alpha of 100, as ktx2-encoder 0.6.0 wrote them and Basis Universal reads them.
    #[test]
    fn both_kinds_of_blocks_have_the_values_of_the_reference() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/images");
        let read = |name: &str| std::fs::read(format!("{folder}/{name}.ktx2")).unwrap();
        let corner = |name: &str| {
            let colors = decode(&read(name), &|_| Ok(())).unwrap().into_rgba8();
            assert_eq!(colors.dimensions(), (8, 4));
            [(0, 0), (3, 1), (7, 3)].map(|(x, y)| colors.get_pixel(x, y).0)
        };
        assert_eq!(corner("etc1s"), [[0, 30, 72, 255], [23, 72, 114, 255], [225, 150, 192, 101]]);
        assert_eq!(corner("uastc"), [[0, 0, 129, 255], [89, 59, 129, 255], [212, 179, 131, 97]]);
        let said = |at: usize, byte: u8| {
            let mut bytes = read("uastc");
            bytes[at] = byte;
            decode(&bytes, &|_| Ok(())).unwrap_err()
        };
        for (at, byte, want) in [
            (12, 37, "Basis Universal"),
            (36, 6, "not an array, cube or volume"),
            (23, 9, "damaged image: its size"),
            (44, 77, "not a valid KTX2 file"),
        ] {
            assert!(said(at, byte).contains(want), "{at}: {}", said(at, byte));
        }
        for name in ["etc1s", "uastc"] {
            for length in 0..read(name).len() {
                assert!(decode(&read(name)[..length], &|_| Ok(())).is_err(), "{name} {length}");
            }
        }
        assert_eq!(decode(&read("etc1s"), &|_| Err("no".to_owned())).unwrap_err(), "no");
    }
}
