//! What comes before the pixels of an image: decoders take memory for it before they tell how large the image is.

use std::io::{self, BufRead, ErrorKind, Read, Seek, SeekFrom};

use image::ImageFormat;

/// Bytes that a header of text may have, or one of attributes.
pub(super) const MAX_HEADER: u64 = 1 << 16;
/// Chunks before the pixels of a PNG file.
const MAX_CHUNKS: usize = 256;

/// `Err` where the header of `file` has more than it may have; whether it is right is for the decoder to tell.
///
/// # Errors
/// Those of `file` too.
pub(super) fn check(
    format: Option<ImageFormat>,
    mut file: impl BufRead + Seek,
) -> Result<(), String> {
    match format {
        Some(ImageFormat::Png) => match chunks(&mut file) {
            Ok(count) if count > MAX_CHUNKS => {
                Err(format!("there can be {MAX_CHUNKS} chunks at most before its pixels"))
            }
            Ok(_) => Ok(()),
            // The decoder says it better.
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => Ok(()),
            Err(error) => Err(error.to_string()),
        },
        Some(ImageFormat::Hdr) => ends(file, b"\n\n"),
        _ => Ok(()),
    }
}

/// Chunks before the first of pixels; some more than there may be, where there are more.
fn chunks(file: &mut (impl Read + Seek)) -> io::Result<usize> {
    file.seek(SeekFrom::Start(8))?;
    for count in 0..=MAX_CHUNKS {
        let mut begin = [0; 8];
        file.read_exact(&mut begin)?;
        let [length @ .., k, i, n, d] = begin;
        if [k, i, n, d] == *b"IDAT" {
            return Ok(count);
        }
        let crc = 4;
        file.seek_relative(i64::from(u32::from_be_bytes(length)) + crc)?;
    }
    Ok(MAX_CHUNKS + 1)
}

/// Whether the header ends with `end`, soon enough.
fn ends(file: impl Read, end: &[u8]) -> Result<(), String> {
    let mut begin = Vec::new();
    let read = file.take(MAX_HEADER).read_to_end(&mut begin).map_err(|error| error.to_string())?;
    match begin.windows(end.len()).any(|bytes| bytes == end) || (read as u64) < MAX_HEADER {
        true => Ok(()),
        false => Err(format!("its header can have {MAX_HEADER} bytes at most")),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    #[test]
    fn chunks_before_the_pixels_are_counted() {
        let chunk = |name: &[u8]| [&4u32.to_be_bytes(), name, b"data", b"crc "].concat();
        let png = |texts: usize| {
            [vec![0; 8], chunk(b"IHDR"), chunk(b"tEXt").repeat(texts), chunk(b"IDAT")].concat()
        };
        let check = |bytes: Vec<u8>| check(Some(ImageFormat::Png), Cursor::new(bytes));
        assert!(check(png(MAX_CHUNKS - 1)).is_ok());
        assert!(check(png(MAX_CHUNKS)).unwrap_err().starts_with("there can be 256 chunks"));
        assert!(check(png(3)[..50].to_vec()).is_ok(), "the decoder tells");
    }

    #[test]
    fn headers_of_text_end_soon() {
        let check = |bytes: &[u8]| check(Some(ImageFormat::Hdr), Cursor::new(bytes));
        let text = [&b"#?RADIANCE\n"[..], &b"A=B\n".repeat(20_000), b"\n-Y 1 +X 1\n"].concat();
        assert!(check(&text).unwrap_err().contains("65536 bytes"));
        assert!(check(&[&text[..100], b"\n\n", &[0; 100_000]].concat()).is_ok());
        assert!(check(b"#?RADIANCE\n").is_ok(), "the decoder tells");
    }
}
