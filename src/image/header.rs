//! Limits on headers of PNG files, which the decoder loads into memory before it reports the image size.

use std::io::{self, BufRead, ErrorKind, Read, Seek, SeekFrom};

use image::ImageFormat;

/// Largest number of chunks before the pixels of a PNG file.
const MAX_CHUNKS: usize = 256;

/// Checks that the header of `file` is within the limits. Its validity is left to the decoder.
///
/// # Errors
/// If the header exceeds a limit, or `file` cannot be read.
pub(super) fn check(
    format: Option<ImageFormat>,
    mut file: impl BufRead + Seek,
) -> Result<(), String> {
    match format {
        Some(ImageFormat::Png) => match chunks(&mut file) {
            Ok(count) if count > MAX_CHUNKS => {
                Err(format!("too many chunks before the pixels (at most {MAX_CHUNKS} are allowed)"))
            }
            Ok(_) => Ok(()),
            // The decoder reports truncated files with a better message.
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => Ok(()),
            Err(error) => Err(error.to_string()),
        },
        _ => Ok(()),
    }
}

/// Number of chunks before the first one with pixels, counted up to `MAX_CHUNKS + 1`.
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
        assert!(check(png(MAX_CHUNKS)).unwrap_err().starts_with("too many chunks"));
        assert!(check(png(3)[..50].to_vec()).is_ok(), "left to the decoder");
    }
}
