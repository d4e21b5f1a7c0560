//! Reads image files, as linear f32 or in the form of textures.

use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read, Seek};
use std::path::Path;

use image::error::UnsupportedErrorKind;
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};
use png::text_metadata::ITXtChunk;

use super::display::{GRADE_KEYS, TRANSFER_KEY};
use super::header;
use super::pfm::Pfm;
use super::size::Allow;
use super::{
    Encoding, Format, Image, Mended, Metadata, Size, Source, Texels, Transfer, exr, hdr, jpeg, ktx2,
};
use crate::error::{Error, Result};
use crate::input;
use crate::limits::MAX_SIDE;

/// Bytes that a decoder may allocate in addition to the pixels.
const MAX_BESIDES: u64 = 1 << 23;
/// Largest size in bytes of a text in a PNG file.
const MAX_TEXT: usize = 1 << 16;
/// Largest size in bytes of the header of a PFM file.
const MAX_PFM_HEADER: u64 = 1 << 10;

/// The pixels of a file, and the transfer curve of its integers.
pub(super) struct Decoded {
    pixels: DynamicImage,
    transfer: Transfer,
    /// Whether the colours are multiplied by alpha.
    associated: bool,
}

/// Reads and decodes an image file, whose integers will be read as `encoding` says. `allow` is called
/// before memory for it is allocated.
pub(super) fn decode(source: &Source<'_>, encoding: Encoding, allow: Allow<'_>) -> Result<Decoded> {
    let (path, length) = (source.path(), source.length()?);
    let open = || source.open();
    let bad = |message: String| source.bad(message);
    if source.has_extension("pfm") {
        let mut begin = Vec::new();
        let head = open()?.take(MAX_PFM_HEADER).read_to_end(&mut begin);
        head.map_err(Error::io(path, "read"))?;
        let pfm = Pfm::parse(&begin).map_err(bad)?;
        let (pixels, memory) = (pfm.pixels(), length + 32 * pfm.pixels());
        pfm.check_length(length)
            .and_then(|()| allow(Size { pixels, deep: true, memory }))
            .map_err(bad)?;
        let bytes = source.bytes()?;
        pfm.check_length(bytes.len() as u64).map_err(bad)?;
        return Ok(Decoded {
            pixels: pfm.image(&bytes).into(),
            transfer: Transfer::default(),
            associated: false,
        });
    }
    // A text header may be as long as the file, and decoders load headers into memory.
    let memory = length.saturating_mul(3);
    allow(Size { pixels: 0, deep: false, memory }).map_err(bad)?;
    let mut begin = Vec::new();
    let read = open()?.take(ktx2::SIGNATURE.len() as u64).read_to_end(&mut begin);
    read.map_err(Error::io(path, "read"))?;
    if begin == ktx2::SIGNATURE {
        let pixels = ktx2::decode(&source.bytes()?, allow).map_err(bad)?;
        return Ok(Decoded { pixels, transfer: Transfer::Srgb, associated: false });
    }
    if begin.starts_with(hdr::SIGNATURE) {
        let pixels = hdr::decode(open()?, length, allow).map_err(bad)?;
        return Ok(Decoded { pixels, transfer: Transfer::default(), associated: false });
    }
    let mut reader =
        ImageReader::new(open()?).with_guessed_format().map_err(Error::io(path, "read"))?;
    // TGA files do not start with a signature.
    if reader.format().is_none() && source.has_extension("tga") {
        reader.set_format(ImageFormat::Tga);
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_BESIDES);
    reader.limits(limits.clone());
    if reader.format() == Some(ImageFormat::OpenExr) {
        let pixels = exr::decode(source, encoding, allow)?;
        let associated = pixels.color().has_alpha();
        return Ok(Decoded { pixels, transfer: Transfer::default(), associated });
    }
    header::check(reader.format(), open()?)
        .map_err(|message| bad(format!("damaged image: {message}")))?;
    if reader.format() == Some(ImageFormat::Jpeg) {
        let pixels = jpeg::decode(open()?, length, allow).map_err(bad)?;
        return Ok(Decoded { pixels, transfer: Transfer::Srgb, associated: false });
    }
    let png = png_decoder(open()?).read_info().ok();
    let texts = png.as_ref().map_or(&[][..], |png| &png.info().utf8_text);
    let transfer = noted_transfer(texts).unwrap_or_default();
    let is_graded = texts.iter().any(|text| GRADE_KEYS.contains(&text.keyword.as_str()));
    if is_graded && encoding == Encoding::Auto {
        return Err(bad(
            "has no linear values, because it was written with an exposure or a tone map: \
             use an .exr, .hdr or .pfm file of the same render"
                .to_owned(),
        ));
    }
    let explain = |error| match error {
        ImageError::IoError(error) if error.kind() != ErrorKind::UnexpectedEof => {
            Error::io(path, "read")(error)
        }
        ImageError::Unsupported(error)
            if matches!(error.kind(), UnsupportedErrorKind::Format(_)) =>
        {
            bad("unsupported image: ptfast reads PNG, JPEG, WebP, EXR, HDR, PFM, BMP, TGA, PNM \
                 and KTX2"
                .into())
        }
        other => bad(format!("damaged image: {other}")),
    };
    let mut decoder = reader.into_decoder().map_err(explain)?;
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 {
        return Err(bad(format!("damaged image: its size is {width} × {height} pixels")));
    }
    let pixels = u64::from(width) * u64::from(height);
    // Memory for the stored pixels, another copy while they are decoded, and the linear pixels.
    let decoding = decoder.total_bytes().saturating_mul(2);
    let deep = decoder.color_type().bytes_per_pixel() > decoder.color_type().channel_count();
    let memory = decoding.saturating_add(32 * pixels);
    allow(Size { pixels, deep, memory }).map_err(bad)?;
    limits.max_alloc = Some(decoding.saturating_add(MAX_BESIDES));
    decoder.set_limits(limits).map_err(explain)?;
    let pixels = DynamicImage::from_decoder(decoder).map_err(explain)?;
    Ok(Decoded { pixels, transfer, associated: false })
}

impl Decoded {
    /// The value of a fraction of the largest integer.
    fn value(&self, encoding: Encoding) -> impl Fn(f64) -> f32 + use<> {
        let transfer = self.transfer;
        move |fraction| match encoding {
            Encoding::Auto => transfer.to_linear(fraction),
            Encoding::Linear => fraction as f32,
        }
    }

    /// The linear values of all integers from 0 to `most`.
    fn table(&self, encoding: Encoding, most: u16) -> Vec<f32> {
        let value = self.value(encoding);
        (0..=most).map(|code| value(f64::from(code) / f64::from(most))).collect()
    }

    /// The number of bits of an integer channel, or `None` for floats.
    fn bits(&self) -> Option<u32> {
        match self.pixels {
            DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => None,
            DynamicImage::ImageRgb16(_)
            | DynamicImage::ImageRgba16(_)
            | DynamicImage::ImageLuma16(_)
            | DynamicImage::ImageLumaA16(_) => Some(16),
            _ => Some(8),
        }
    }

    /// The colours without alpha, as `encoding` says.
    pub(super) fn into_image(self, encoding: Encoding) -> Image {
        let (width, height) = (self.pixels.width(), self.pixels.height());
        let pixels = match self.bits() {
            None => self.pixels.into_rgb32f().pixels().map(|p| p.0).collect(),
            Some(16) => {
                let table = self.table(encoding, u16::MAX);
                let pixels = self.pixels.into_rgb16();
                pixels.pixels().map(|p| p.0.map(|c| table[usize::from(c)])).collect()
            }
            _ => {
                let table = self.table(encoding, u8::MAX.into());
                let pixels = self.pixels.into_rgb8();
                pixels.pixels().map(|p| p.0.map(|c| table[usize::from(c)])).collect()
            }
        };
        Image::from_pixels(width, height, pixels)
    }

    /// The pixels in the form of textures, with alpha. Channels of 8 bits are kept as they are.
    pub(super) fn into_texels(self, encoding: Encoding) -> Texels {
        let (width, height, associated) =
            (self.pixels.width(), self.pixels.height(), self.associated);
        match self.bits() {
            None => {
                let mut mended = Mended::default();
                let pixels = self.pixels.into_rgba32f().into_raw();
                let mend = |texel: &[f32; 4]| mended.mend(*texel);
                let texels = pixels.as_chunks().0.iter().map(mend).collect();
                Texels::from_floats(width, height, texels)
                    .with_mended(mended)
                    .with_associated(associated)
            }
            Some(16) => {
                let table = self.table(encoding, u16::MAX);
                let value = |p: &image::Rgba<u16>| {
                    let [r, g, b, a] = p.0.map(usize::from);
                    [table[r], table[g], table[b], a as f32 / f32::from(u16::MAX)]
                };
                let texels = self.pixels.into_rgba16().pixels().map(value).collect();
                Texels::from_floats(width, height, texels)
            }
            _ => {
                let table = self.table(encoding, u8::MAX.into());
                let values = table.try_into().expect("a byte has 256 values");
                let codes = self.pixels.into_rgba8().into_raw().as_chunks().0.to_vec();
                Texels::from_bytes(width, height, codes, Box::new(values))
            }
        }
    }
}

impl Texels {
    /// Reads an image file of any format that [`Image::read`] reads. Calls `allow` before it allocates
    /// memory.
    ///
    /// # Errors
    /// If the file cannot be read, is damaged, or has another format, or if `allow` fails.
    pub(crate) fn read(source: &Source<'_>, encoding: Encoding, allow: Allow<'_>) -> Result<Self> {
        decode(source, encoding, allow).map(|decoded| decoded.into_texels(encoding))
    }
}

impl Metadata {
    /// Reads the metadata of the file `path`. PNG and EXR files have metadata if ptfast wrote them.
    ///
    /// # Errors
    /// If the file cannot be read, or is not a PNG or EXR image.
    pub fn read(path: &Path) -> Result<Self> {
        metadata(path)
    }
}

fn metadata(path: &Path) -> Result<Metadata> {
    let bad = |message: String| Error::input(path.display().to_string(), "", message);
    input::length(path)?;
    if Format::of_path(path)? == Format::Exr {
        return exr::metadata(&Source::file(path));
    }
    let mut file = File::open(path).map(BufReader::new).map_err(Error::io(path, "read"))?;
    let entries = |all: Metadata, (key, value): (&str, String)| all.with(key, value);
    header::check(Some(ImageFormat::Png), &mut file).map_err(bad)?;
    file.rewind().map_err(Error::io(path, "read"))?;
    let reader = png_decoder(file).read_info().map_err(|error| bad(error.to_string()))?;
    let texts = reader.info().utf8_text.iter();
    let texts = texts.filter_map(|chunk| Some((chunk.keyword.as_str(), text(chunk)?)));
    Ok(texts.fold(Metadata::default(), entries))
}

/// A decoder that rejects texts and profiles that are too long.
fn png_decoder<S: BufRead + Seek>(file: S) -> png::Decoder<S> {
    png::Decoder::new_with_limits(file, png::Limits { bytes: MAX_BESIDES as usize })
}

fn noted_transfer(texts: &[ITXtChunk]) -> Option<Transfer> {
    let note = texts.iter().find(|chunk| chunk.keyword == TRANSFER_KEY)?;
    Transfer::from_name(&text(note)?)
}

/// The text of a chunk; `None` if it is too long. A short compressed text can expand to any length.
fn text(chunk: &ITXtChunk) -> Option<String> {
    let mut chunk = chunk.clone();
    chunk.decompress_text_with_limit(MAX_TEXT).ok()?;
    chunk.get_text().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tga_is_recognized_by_its_extension() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.TGA");
        // True colour, 1 × 1 pixel of 24 bits: blue, green, red.
        let header = [0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1, 0, 24, 0];
        std::fs::write(&path, [&header[..], &[0, 0, 255]].concat()).unwrap();
        let image = Image::read(&path).unwrap();
        assert_eq!(image.pixels(), [[1.0, 0.0, 0.0]]);
    }

    /// Two files of 3 × 2 pixels that OpenImageIO 3.2 wrote, and the values that it reads.
    #[test]
    fn webp_images_are_read() {
        let lossless: &[u8] = b"\
        \x52\x49\x46\x46\x48\x00\x00\x00\x57\x45\x42\x50\x56\x50\x38\x4c\x3b\x00\
        \x00\x00\x2f\x02\x40\x00\x10\x2f\x40\x90\x6d\x53\x89\x79\xdd\x5f\xe6\x1a\
        \x64\xd2\x36\xed\x5b\xff\x7a\x66\x6d\x64\xd2\x36\xad\x87\xde\xf3\xef\x72\
        \x04\x92\x36\x36\x1f\x4f\xfe\x00\x9c\x9f\xa3\xab\xb5\x05\x02\x12\x32\x25\
        \x8f\x7c\x11\xd1\xff\x88\x05\x00\
        ";
        let lossy: &[u8] = b"\
        \x52\x49\x46\x46\x7e\x00\x00\x00\x57\x45\x42\x50\x56\x50\x38\x20\x72\x00\
        \x00\x00\xf0\x03\x00\x9d\x01\x2a\x03\x00\x02\x00\x00\x00\x00\x25\xa8\x02\
        \x74\xba\x01\xf2\x01\x4a\x02\xa8\x03\xf8\x06\x50\x07\xe8\x00\xe7\x40\xfc\
        \x00\x34\x29\x5e\xaa\x00\x00\xfe\xf5\x63\xff\xf0\xa8\xff\xeb\xac\xff\xfc\
        \x93\x05\x2f\xfc\xdb\x27\xa0\x60\x00\x79\x74\x7b\xb6\x92\x19\xfb\xec\xba\
        \x9b\xb2\x8e\xa2\xff\xfd\x21\xbf\xb8\xc5\x46\xc6\xaf\xff\xd2\xf6\x7f\xf4\
        \x86\xfe\xe3\x15\x1b\x1a\xbf\xfe\x97\xb3\xf8\x5f\x83\x33\x1a\xfc\x0c\xd4\
        \x7e\x0c\xcc\x6b\xfc\x3d\x80\x00\
        ";
        let codes = |bytes: &[u8]| {
            let source = Source::part(Path::new("a.webp"), 0, bytes);
            let decoded = decode(&source, Encoding::Auto, &|_| Ok(()))?;
            Ok::<_, Error>(decoded.pixels.into_rgba8().pixels().map(|p| p.0).collect::<Vec<_>>())
        };
        let found = codes(lossless).unwrap();
        assert_eq!(found[0..2], [[255, 0, 0, 255], [0, 255, 0, 128]]);
        assert_eq!(found[2][3], 0);
        assert_eq!(found[3..], [[10, 20, 30, 255], [200, 100, 50, 255], [255; 4]]);
        // The arithmetic of the decoder is that of integers, so these are the same on every CPU.
        let want = [
            [98, 78, 14],
            [163, 148, 137],
            [22, 18, 113],
            [41, 21, 0],
            [136, 122, 110],
            [246, 242, 255],
        ];
        let found: Vec<[u8; 3]> =
            codes(lossy).unwrap().into_iter().map(|[r, g, b, _]| [r, g, b]).collect();
        assert_eq!(found, want);
        for length in [12, 30, lossy.len() - 40] {
            let error = codes(&lossy[..length]).unwrap_err().to_string();
            assert!(error.contains("damaged image"), "{length}: {error}");
        }
    }

    #[test]
    fn damaged_and_foreign_files_are_rejected() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        std::fs::write(&path, b"\x89PNG\r\n\x1a\n and then nonsense").unwrap();
        assert!(Image::read(&path).unwrap_err().to_string().contains("damaged image"));
        std::fs::write(&path, b"no image at all").unwrap();
        assert!(Image::read(&path).unwrap_err().to_string().contains("PNG, JPEG, WebP, EXR"));
        let error = Image::read(folder.path()).unwrap_err();
        assert_eq!(error.exit_code(), 74);
        assert_eq!(Image::read(Path::new("nosuch.png")).unwrap_err().exit_code(), 74);
    }
}
