//! Decodes KTX2 files with Basis Universal textures, which glTF files have by `KHR_texture_basisu`.

use basisu::{DecodeFlags, TargetFormat, Transcoder};
use image::{DynamicImage, RgbaImage};

use super::size::{Allow, Size};
use crate::limits::MAX_SIDE;

/// How files begin.
pub(super) const SIGNATURE: [u8; 12] = *b"\xabKTX 20\xbb\r\n\x1a\n";
/// Bytes of the header before the index of levels, and of each level in it.
const HEADER: usize = 80;
const LEVEL: usize = 24;
/// The schemes of supercompression that are read: none, BasisLZ and Zstandard.
const SCHEMES: std::ops::RangeInclusive<u32> = 0..=2;
/// Bytes of memory per pixel: the blocks, the decoded colours, and a copy.
const PER_PIXEL: u64 = 12;

fn damaged() -> String {
    "damaged image: it is not a valid KTX2 file".to_owned()
}

/// Checks what the decoder takes for granted: that the image is one that it reads, and that no length in the header
/// asks for more than there is. Returns width and height.
fn check(bytes: &[u8]) -> Result<[u32; 2], String> {
    if bytes.len() < HEADER {
        return Err(damaged());
    }
    let word = |at: usize| u32::from_le_bytes([0, 1, 2, 3].map(|i| bytes[at + i]));
    let long = |at: usize| u64::from(word(at)) | u64::from(word(at + 4)) << 32;
    let [format, width, height, depth, layers, faces] = [12, 20, 24, 28, 32, 36].map(word);
    let [levels, scheme] = [40, 44].map(word);
    if format != 0 {
        return Err("unsupported image: KTX2 files must have Basis Universal textures".to_owned());
    }
    if !SCHEMES.contains(&scheme) || levels == 0 {
        return Err("unsupported image: KTX2 files must have BasisLZ, Zstandard or no supercompression, and their levels".to_owned());
    }
    if depth > 0 || layers > 1 || faces > 1 {
        return Err(
            "unsupported image: KTX2 files must have one image, not an array, cube or volume"
                .to_owned(),
        );
    }
    if ![width, height].iter().all(|side| (1..=MAX_SIDE).contains(side)) {
        return Err(format!("damaged image: its size is {width} × {height} pixels"));
    }
    let within = |offset: u64, length: u64| {
        offset.checked_add(length).is_some_and(|end| end <= bytes.len() as u64)
    };
    if levels > 32
        || bytes.len() < HEADER + LEVEL * levels as usize
        || !within(word(48).into(), word(52).into())
        || !within(word(56).into(), word(60).into())
        || !within(long(64), long(72))
    {
        return Err(damaged());
    }
    for level in 0..levels {
        let at = HEADER + LEVEL * level as usize;
        let blocks = |side: u32| u64::from((side >> level).max(1).div_ceil(4));
        // A level has 16 bytes for each block once Zstandard has expanded it. BasisLZ has no such number.
        let expands = scheme == 2 && long(at + 16) != 16 * blocks(width) * blocks(height);
        if !within(long(at), long(at + 8)) || expands {
            return Err(damaged());
        }
    }
    Ok([width, height])
}

/// Whether a file with this content has an alpha channel. False if it cannot be read.
pub(super) fn has_alpha(bytes: &[u8]) -> bool {
    check(bytes).is_ok() && Transcoder::new(bytes).is_ok_and(|file| file.has_alpha())
}

/// Decodes the largest level of a file with this content.
pub(super) fn decode(bytes: &[u8], allow: Allow<'_>) -> Result<DynamicImage, String> {
    let [width, height] = check(bytes)?;
    let pixels = u64::from(width) * u64::from(height);
    allow(Size { pixels, deep: false, memory: bytes.len() as u64 + PER_PIXEL * pixels })?;
    let file = Transcoder::new(bytes).map_err(|_| damaged())?;
    let colors = file.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE);
    let colors = colors.map_err(|error| match error {
        basisu::Error::Unsupported { source, .. } => {
            format!("unsupported image: KTX2 files with {source:?} blocks")
        }
        basisu::Error::VideoRequiresState => "unsupported image: it is a video".to_owned(),
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
        assert!(has_alpha(&read("etc1s")) && has_alpha(&read("uastc")));
        let said = |name: &str, at: usize, byte: u8| {
            let mut bytes = read(name);
            bytes[at] = byte;
            decode(&bytes, &|_| Ok(())).unwrap_err()
        };
        for (name, at, byte, want) in [
            ("uastc", 12, 37, "Basis Universal"),
            ("uastc", 28, 1, "not an array, cube or volume"),
            ("uastc", 36, 6, "not an array, cube or volume"),
            ("uastc", 23, 9, "damaged image: its size"),
            ("uastc", 40, 0, "and their levels"),
            ("uastc", 44, 3, "must have BasisLZ, Zstandard or no supercompression"),
            // Lengths that would wrap, or ask for more memory than any machine has.
            ("etc1s", 71, 255, "not a valid KTX2 file"),
            ("etc1s", 79, 255, "not a valid KTX2 file"),
            ("uastc", 87, 255, "not a valid KTX2 file"),
            ("uastc", 101, 2, "not a valid KTX2 file"),
            ("uastc", 103, 128, "not a valid KTX2 file"),
        ] {
            let said = said(name, at, byte);
            assert!(said.contains(want), "{name} {at}: {said}");
        }
        for name in ["etc1s", "uastc"] {
            for length in 0..read(name).len() {
                assert!(decode(&read(name)[..length], &|_| Ok(())).is_err(), "{name} {length}");
            }
        }
        assert_eq!(decode(&read("etc1s"), &|_| Err("no".to_owned())).unwrap_err(), "no");
    }
}
