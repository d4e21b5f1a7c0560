//! Whether an image file has an alpha channel, from its header alone.

use std::io::Read;

use image::{ImageDecoder, ImageFormat, ImageReader, Limits};

use super::{Source, exr, header, ktx2};
use crate::limits::MAX_SIDE;

/// Bytes that a decoder may allocate for a header.
const MAX_HEADER: u64 = 1 << 23;

/// Whether the image has an alpha channel. False for files that cannot be read, which the reader of their pixels
/// reports.
pub(crate) fn has_alpha(source: &Source<'_>) -> bool {
    let found = || {
        let mut begin = [0; ktx2::SIGNATURE.len()];
        if source.open().ok()?.read_exact(&mut begin).is_ok() && begin == ktx2::SIGNATURE {
            return Some(ktx2::has_alpha(&source.bytes().ok()?));
        }
        let mut reader = ImageReader::new(source.open().ok()?).with_guessed_format().ok()?;
        // TGA files do not start with a signature.
        if reader.format().is_none() && source.has_extension("tga") {
            reader.set_format(ImageFormat::Tga);
        }
        if reader.format() == Some(ImageFormat::OpenExr) {
            return Some(exr::has_alpha(source));
        }
        header::check(reader.format(), source.open().ok()?).ok()?;
        let mut limits = Limits::default();
        limits.max_image_width = Some(MAX_SIDE);
        limits.max_image_height = Some(MAX_SIDE);
        limits.max_alloc = Some(MAX_HEADER);
        reader.limits(limits);
        Some(reader.into_decoder().ok()?.color_type().has_alpha())
    };
    found().unwrap_or(false)
}
