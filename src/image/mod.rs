//! Linear images, their hash, and the image files that ptfast reads and writes.

mod alpha;
mod colorimetry;
mod compare;
mod display;
mod exr;
mod format;
mod hdr;
mod header;
mod jpeg;
mod ktx2;
mod layer;
mod mend;
mod metadata;
mod pfm;
mod read;
mod size;
mod source;
mod texels;
mod tone_map;
mod transfer;
mod write;

pub(crate) use alpha::has_alpha;
pub(crate) use compare::compare;
pub(crate) use display::MAX_STOPS;
pub use display::{Display, Exposure};
pub(crate) use exr::{Channels, other_channels};
pub(crate) use format::Format;
pub use layer::ImageLayer;
pub(crate) use mend::Mended;
pub use metadata::Metadata;
pub(crate) use size::Size;
pub(crate) use source::{Source, split_layer};
pub(crate) use texels::Texels;
pub use tone_map::ToneMap;
pub use transfer::Transfer;
pub(crate) use write::layer_path;

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::Result;

/// What the integers in an image file mean. Floats are always linear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Encoding {
    /// Colours, with the transfer curve that ptfast recorded in the file, or else with sRGB.
    #[default]
    Auto,
    /// Numbers, such as the components of normals: fractions of the largest integer.
    Linear,
}

/// A linear RGB image of 32-bit floats, row 0 on top. It may have an alpha channel, by which its
/// colours are already multiplied.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
    /// One number for each pixel, or none at all.
    alpha: Vec<f32>,
    layers: Vec<ImageLayer>,
}

impl Image {
    /// A black image.
    pub fn new(width: u32, height: u32) -> Self {
        Self::from_pixels(width, height, vec![[0.0; 3]; width as usize * height as usize])
    }

    /// An image of the given pixels, row by row from the top.
    ///
    /// # Panics
    /// If the number of pixels is not `width × height`.
    pub fn from_pixels(width: u32, height: u32, pixels: Vec<[f32; 3]>) -> Self {
        assert_eq!(
            pixels.len(),
            width as usize * height as usize,
            "pixels do not match the size {width} × {height}"
        );
        Self { width, height, pixels, alpha: Vec::new(), layers: Vec::new() }
    }

    /// The image with an alpha channel: the coverage of each pixel, in [0, 1]. Only PNG and EXR
    /// files store it.
    ///
    /// # Panics
    /// If `alpha` does not have one number for each pixel.
    #[must_use]
    pub fn with_alpha(self, alpha: Vec<f32>) -> Self {
        assert_eq!(alpha.len(), self.pixels.len(), "alpha needs one number for each pixel");
        Self { alpha, ..self }
    }

    /// The coverage of each pixel, row by row from the top; `None` for an image without alpha
    /// channel.
    pub fn alpha(&self) -> Option<&[f32]> {
        (!self.alpha.is_empty()).then_some(&self.alpha)
    }

    /// Reads PNG, JPEG, WebP, EXR, HDR, PFM, BMP, TGA, PNM or KTX2 (Basis Universal) into linear values. `a.exr:LAYER` is
    /// a layer or part of an EXR file.
    ///
    /// 8- and 16-bit files are decoded with the transfer curve that ptfast recorded in the file, or
    /// else with sRGB. Alpha is dropped.
    ///
    /// # Errors
    /// If the file cannot be read, is damaged, has another format, or is an 8-bit file that ptfast
    /// wrote with an exposure or a tone map.
    pub fn read(path: &Path) -> Result<Self> {
        Self::read_where(path, &|_, _| Ok(()))
    }

    /// Like [`read`](Self::read), but calls `allow` with the number of pixels and the bytes of
    /// memory that reading them takes, before it allocates that memory.
    ///
    /// # Errors
    /// As for [`read`](Self::read), or if `allow` returns an error, whose message is then reported.
    #[doc(hidden)]
    pub fn read_where(path: &Path, allow: &dyn Fn(u64, u64) -> Result<(), String>) -> Result<Self> {
        Self::read_encoded(path, Encoding::Auto, allow)
    }

    /// Like [`read_where`](Self::read_where), for files of any encoding.
    pub(crate) fn read_encoded(
        path: &Path,
        encoding: Encoding,
        allow: &dyn Fn(u64, u64) -> Result<(), String>,
    ) -> Result<Self> {
        read::decode(&Source::file(path), encoding, &|size| allow(size.pixels, size.memory))
            .map(|decoded| decoded.into_image(encoding))
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The share of the pixels that are not black that 8-bit files with this appearance clip.
    pub(crate) fn clipped(&self, display: &Display) -> f64 {
        display.clipped(&self.pixels)
    }

    /// All pixels, row by row from the top.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// All rows, from the top.
    pub(crate) fn rows(&self) -> impl DoubleEndedIterator<Item = &[[f32; 3]]> {
        self.pixels.chunks_exact(self.width.max(1) as usize)
    }

    /// Mean of each channel, summed in f64.
    pub fn mean(&self) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for pixel in &self.pixels {
            for (sum, &value) in sum.iter_mut().zip(pixel) {
                *sum += f64::from(value);
            }
        }
        sum.map(|s| s / self.pixels.len() as f64)
    }

    /// The identity of the image: the BLAKE3 hash, in hexadecimal, of width and height (u32
    /// little-endian) and the rows of f32 RGB (little-endian, top row first), without alpha.
    pub fn hash(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&self.width.to_le_bytes());
        hasher.update(&self.height.to_le_bytes());
        for row in self.rows() {
            hasher.update(&row_bytes(row));
        }
        hasher.finalize().to_hex().to_string()
    }
}

/// A row as little-endian f32 RGB.
fn row_bytes(row: &[[f32; 3]]) -> Vec<u8> {
    row.iter().flatten().flat_map(|value| value.to_le_bytes()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hash_is_blake3_of_size_and_rows() {
        let image = Image::from_pixels(1, 2, vec![[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]]);
        let mut bytes = vec![1, 0, 0, 0, 2, 0, 0, 0];
        for i in 0..6u8 {
            bytes.extend(f32::from(i).to_le_bytes());
        }
        assert_eq!(image.hash(), blake3::hash(&bytes).to_hex().to_string());
        assert_ne!(image.hash(), Image::new(1, 2).hash());
        assert_ne!(Image::new(2, 1).hash(), Image::new(1, 2).hash());
    }

    #[test]
    fn rows_and_mean() {
        let mut pixels = vec![[0.0; 3]; 6];
        (pixels[4], pixels[5]) = ([6.0, 0.0, 0.0], [0.0, 12.0, 0.0]);
        let image = Image::from_pixels(3, 2, pixels);
        assert_eq!(image.mean(), [1.0, 2.0, 0.0]);
        assert_eq!(image.rows().nth(1).unwrap()[1], [6.0, 0.0, 0.0]);
    }
}
