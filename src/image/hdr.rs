//! Reads Radiance HDR files of all orientations, whatever program they name.

use std::io::{BufRead, Cursor, Read};

use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, Rgb32FImage};

use super::size::{Allow, Size};
use crate::limits::MAX_SIDE;

/// How files begin. `RADIANCE` or `RGBE` follows, or another name, which has no meaning.
pub(super) const SIGNATURE: &[u8] = b"#?";
/// Largest size in bytes of a header.
const MAX_HEADER: u64 = 1 << 16;
/// Bytes of memory per pixel: two copies while it is decoded and turned, and the linear pixels.
const PER_PIXEL: u64 = 56;

/// The order of the pixels in a file.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Order {
    /// Number of scanlines, and the length of each.
    lines: u32,
    length: u32,
    /// Whether scanlines are columns.
    columns: bool,
    /// Whether the first pixel is on the right or at the bottom.
    right: bool,
    bottom: bool,
}

/// Decodes a file of `length` bytes.
pub(super) fn decode(
    mut file: impl BufRead,
    length: u64,
    allow: Allow<'_>,
) -> Result<DynamicImage, String> {
    let damaged = |error: &dyn std::fmt::Display| format!("damaged image: {error}");
    let order = header(&mut file)?;
    let Order { lines, length: line, .. } = order;
    let pixels = u64::from(lines) * u64::from(line);
    allow(Size { pixels, deep: true, memory: length.saturating_add(PER_PIXEL * pixels) })?;
    // The decoder reads one orientation and one name.
    let usual = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {lines} +X {line}\n");
    let decoder = HdrDecoder::new(Cursor::new(usual).chain(file));
    let decoded = decoder.and_then(DynamicImage::from_decoder).map_err(|error| damaged(&error))?;
    Ok(match order {
        Order { columns: false, right: false, bottom: false, .. } => decoded,
        order => turned(&decoded.into_rgb32f(), order).into(),
    })
}

/// Reads the header to its end.
fn header(file: &mut impl BufRead) -> Result<Order, String> {
    let mut file = file.take(MAX_HEADER);
    let mut line = || {
        let mut line = Vec::new();
        file.read_until(b'\n', &mut line).map_err(|error| format!("damaged image: {error}"))?;
        match line.pop() {
            Some(b'\n') => Ok(String::from_utf8_lossy(&line).trim_end().to_owned()),
            _ if file.limit() == 0 => {
                Err(format!("the header is too long (at most {MAX_HEADER} bytes are allowed)"))
            }
            _ => Err("damaged image: its header has no end".to_owned()),
        }
    };
    loop {
        let line = line()?;
        if line.is_empty() {
            break;
        }
        match line.split_once('=') {
            Some(("FORMAT", format)) if format.trim() == "32-bit_rle_xyze" => {
                return Err("unsupported image: its colours are XYZ, convert it with `ra_xyze -r`"
                    .to_owned());
            }
            Some(("FORMAT", format)) if format.trim() != "32-bit_rle_rgbe" => {
                return Err(format!("damaged image: unknown FORMAT `{}`", format.trim()));
            }
            _ => {}
        }
    }
    let line = line()?;
    Order::parse(&line).ok_or_else(|| {
        format!("damaged image: expected its size as in `-Y 512 +X 1024`, with sides of 1 to {MAX_SIDE}, not `{line}`")
    })
}

impl Order {
    /// Reads a line such as `-Y 512 +X 1024`: the axis and the number of the scanlines, then of the pixels in one.
    fn parse(line: &str) -> Option<Self> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [first, lines, second, length] = words[..] else { return None };
        let side = |word: &str| word.parse().ok().filter(|side| (1..=MAX_SIDE).contains(side));
        let (lines, length) = (side(lines)?, side(length)?);
        let (columns, x, y) = match (first, second) {
            ("-Y" | "+Y", "-X" | "+X") => (false, second, first),
            ("-X" | "+X", "-Y" | "+Y") => (true, first, second),
            _ => return None,
        };
        Some(Self { lines, length, columns, right: x == "-X", bottom: y == "+Y" })
    }
}

/// The image whose scanlines are the rows of `decoded`.
fn turned(decoded: &Rgb32FImage, order: Order) -> Rgb32FImage {
    let Order { lines, length, columns, right, bottom } = order;
    let (width, height) = if columns { (lines, length) } else { (length, lines) };
    Rgb32FImage::from_fn(width, height, |x, y| {
        let x = if right { width - 1 - x } else { x };
        let y = if bottom { height - 1 - y } else { y };
        let (column, row) = if columns { (y, x) } else { (x, y) };
        *decoded.get_pixel(column, row)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn red(header: &str, pixels: &[u8]) -> Result<Vec<f32>, String> {
        let pixels = pixels.iter().flat_map(|&red| [red, 0, 0, 136]);
        let bytes: Vec<u8> = header.bytes().chain(pixels).collect();
        let image = decode(Cursor::new(bytes), 0, &|_| Ok(()))?.into_rgb32f();
        Ok(image.pixels().map(|pixel| pixel.0[0]).collect())
    }

    /// Radiance's "picture" file format: the first axis is that of scanlines, `-Y` runs down, `+X` to the right.
    #[test]
    fn all_orientations_are_turned_upright() {
        // The picture is 3 wide: 1 2 3 above 4 5 6.
        for (size, stored) in [
            ("-Y 2 +X 3", [1, 2, 3, 4, 5, 6]),
            ("-Y 2 -X 3", [3, 2, 1, 6, 5, 4]),
            ("+Y 2 -X 3", [6, 5, 4, 3, 2, 1]),
            ("+Y 2 +X 3", [4, 5, 6, 1, 2, 3]),
            ("+X 3 -Y 2", [1, 4, 2, 5, 3, 6]),
            ("-X 3 -Y 2", [3, 6, 2, 5, 1, 4]),
            ("-X 3 +Y 2", [6, 3, 5, 2, 4, 1]),
            ("+X 3 +Y 2", [4, 1, 5, 2, 6, 3]),
        ] {
            let header = format!("#?RGBE\r\nEXPOSURE=x\nFORMAT=32-bit_rle_rgbe\n\n{size}\n");
            let found = red(&header, &stored).unwrap();
            assert_eq!(found, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], "{size}");
        }
    }

    #[test]
    fn bad_headers_are_rejected() {
        let fails = |header: &str, message: &str| {
            let error = red(header, &[1]).unwrap_err();
            assert!(error.contains(message), "{header}: {error}");
        };
        fails("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n", "its colours are XYZ");
        fails("#?RADIANCE\n\n-Y 0 +X 1\n", "sides of 1 to 65536");
        fails("#?RADIANCE\n\n-Y 1 +Y 1\n", "not `-Y 1 +Y 1`");
        fails("#?RADIANCE\n\n-Y 2 +X 1\n", "damaged image");
        fails("#?RADIANCE\n", "its header has no end");
        let long = format!("#?RADIANCE\n{}\n-Y 1 +X 1\n", "A=B\n".repeat(20_000));
        fails(&long, "at most 65536 bytes");
    }
}
