//! Decodes JPEG files, to the same bits on every CPU.

use std::io::{BufRead, Seek};

use image::{DynamicImage, RgbImage};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::size::{Allow, Size};
use crate::limits::MAX_SIDE;

/// Bytes of memory per pixel: the coefficients of a progressive file, and the decoded colours.
const PER_PIXEL: u64 = 16;

/// Decodes a file of `length` bytes. Greys and four-colour separations become RGB.
pub(super) fn decode(
    file: impl BufRead + Seek,
    length: u64,
    allow: Allow<'_>,
) -> Result<DynamicImage, String> {
    let damaged = |error| format!("damaged image: {error}");
    let options = DecoderOptions::default()
        .set_strict_mode(true)
        .set_max_width(MAX_SIDE as usize)
        .set_max_height(MAX_SIDE as usize)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(file, options);
    decoder.decode_headers().map_err(damaged)?;
    let (width, height) = decoder.dimensions().expect("the headers are decoded");
    let pixels = width as u64 * height as u64;
    allow(Size { pixels, deep: false, memory: length.saturating_add(PER_PIXEL * pixels) })?;
    let colors = decoder.decode().map_err(damaged)?;
    RgbImage::from_raw(width as u32, height as u32, colors)
        .map(DynamicImage::from)
        .ok_or_else(|| "damaged image: its pixels do not match its size".to_owned())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::image::{Encoding, Image, Source, Texels};

    /// The bytes come from integer arithmetic, so that every CPU must give this hash.
    #[test]
    fn pixels_are_pinned_and_do_not_depend_on_the_order_of_coefficients() {
        let read = |name: &str| {
            let path = Path::new("tests/data").join(name);
            Texels::read(&Source::file(&path), Encoding::Auto, &|_| Ok(())).unwrap()
        };
        let (photo, progressive) = (read("photo.jpg"), read("photo-progressive.jpg"));
        assert_eq!((photo.width(), photo.height()), (37, 21));
        assert_eq!(photo.hash(), progressive.hash());
        assert_eq!(&photo.hash()[..16], "d3214b9583eaafee");
    }

    #[test]
    fn truncated_files_are_rejected() {
        let bytes = std::fs::read("tests/data/photo.jpg").unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpg");
        for length in [3, 20, 300, bytes.len() - 200] {
            std::fs::write(&path, &bytes[..length]).unwrap();
            let error = Image::read(&path).unwrap_err().to_string();
            assert!(error.contains("damaged image"), "{length}: {error}");
        }
    }
}
