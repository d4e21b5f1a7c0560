//! Decodes JPEG files, to the same bits on every CPU.

use std::io::{self, BufRead, Seek, SeekFrom};

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
    mut file: impl BufRead + Seek,
    length: u64,
    allow: Allow<'_>,
) -> Result<DynamicImage, String> {
    if let Ok(Some(kind)) = unsupported(&mut file) {
        return Err(format!("unsupported image: {kind}, write it as a baseline JPEG"));
    }
    file.rewind().map_err(|error| format!("damaged image: {error}"))?;
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

/// The kind of a file that the decoder lacks, or decodes to other colours: it takes chroma for a whole fraction of luma.
/// The validity of the file is left to the decoder.
fn unsupported(file: &mut (impl BufRead + Seek)) -> io::Result<Option<&'static str>> {
    file.seek(SeekFrom::Start(2))?;
    loop {
        let mut marker = [0; 4];
        file.read_exact(&mut marker)?;
        let [0xff, kind, length @ ..] = marker else { return Ok(None) };
        if kind == 0xff {
            // Any number of these may stand before a marker.
            file.seek_relative(-3)?;
            continue;
        }
        let length = i64::from(u16::from_be_bytes(length)) - 2;
        match kind {
            0xc0..=0xc2 => {}
            0xc3 => return Ok(Some("it is a lossless JPEG")),
            0xc5..=0xc7 => return Ok(Some("it is a hierarchical JPEG")),
            0xc9..=0xcb | 0xcd..=0xcf => return Ok(Some("it is a JPEG with arithmetic coding")),
            0xda | 0xd9 => return Ok(None),
            _ => {
                file.seek_relative(length)?;
                continue;
            }
        }
        let mut frame = [0; 6];
        file.read_exact(&mut frame)?;
        if frame[0] != 8 {
            return Ok(Some("its channels have more than 8 bits"));
        }
        let mut samples = Vec::new();
        for _ in 0..frame[5] {
            let mut component = [0; 3];
            file.read_exact(&mut component)?;
            samples.push([component[1] >> 4, component[1] & 15]);
        }
        if !samples.as_flattened().iter().all(|samples| samples.is_power_of_two()) {
            return Ok(Some("the samples of a channel are no power of two"));
        }
        let [luma, chroma @ ..] = &samples[..] else { return Ok(None) };
        let fits = |luma: u8, chroma: u8| chroma == 0 || luma.is_multiple_of(chroma);
        let fit = chroma.iter().all(|[x, y]| fits(luma[0], *x) && fits(luma[1], *y));
        return Ok((!fit).then_some("its chroma has more samples than its luma"));
    }
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

    /// Patches the frame of a baseline file.
    #[test]
    fn kinds_that_the_decoder_lacks_are_unsupported_by_name() {
        let photo = std::fs::read("tests/data/photo.jpg").unwrap();
        let frame = photo.windows(2).position(|bytes| bytes == [0xff, 0xc0]).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpg");
        // The samples of the components follow their names, 11, 14 and 17 bytes after the marker.
        for (at, value, name) in [
            (1, 0xc9, "it is a JPEG with arithmetic coding"),
            (1, 0xca, "it is a JPEG with arithmetic coding"),
            (1, 0xc3, "it is a lossless JPEG"),
            (4, 12, "its channels have more than 8 bits"),
            (14, 0x41, "its chroma has more samples than its luma"),
            (17, 0x14, "its chroma has more samples than its luma"),
            (14, 0x31, "the samples of a channel are no power of two"),
        ] {
            let mut bytes = photo.clone();
            (bytes[frame + 11], bytes[frame + at]) = (0x21, value);
            std::fs::write(&path, &bytes).unwrap();
            let error = Image::read(&path).unwrap_err().to_string();
            assert!(error.contains(&format!("unsupported image: {name}")), "{error}");
        }
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
