//! Writes images in the format of their file extension.
//!
//! Files are written atomically: they appear complete or not at all.

use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};

use super::{Display, Format, Image, Metadata, Transfer, row_bytes};
use crate::error::Result;
use crate::output::write_atomically;

impl Image {
    /// Writes the image to `path` in the format of its extension (PNG, EXR, HDR, PFM). `display`, a
    /// [`Display`] or just a [`Transfer`], is the appearance of 8-bit files. The file is written
    /// atomically: it appears complete or not at all. EXR files contain the layers; beside files of other formats, each
    /// layer is a PFM file, such as `a.depth.pfm` beside `a.png`.
    ///
    /// # Errors
    /// If no writer supports the extension, if the image has an alpha channel and the format has not,
    /// or if the file cannot be written.
    pub fn write(
        &self,
        path: &Path,
        display: impl Into<Display>,
        metadata: &Metadata,
    ) -> Result<()> {
        let (format, display) = (Format::of_path(path)?, display.into());
        if self.alpha().is_some() {
            format.check_alpha(path)?;
        }
        if format != Format::Exr {
            // Before the image, which says that all is written.
            self.layers().iter().try_for_each(|layer| {
                let image = self.layer_image(layer);
                write_atomically(&layer_path(path, layer.name()), |file| write_pfm(&image, file))
            })?;
        }
        write_atomically(path, |file| match format {
            Format::Png => self.write_png(file, display, metadata),
            Format::Exr => {
                let metadata = display.noted(format, metadata.clone());
                write_exr(self, file, display.half_layers, &metadata)
            }
            Format::Hdr => write_hdr(self, file),
            Format::Pfm => write_pfm(self, file),
        })
    }

    /// Writes the image to `out` as PNG.
    ///
    /// # Errors
    /// If `out` cannot be written.
    pub(crate) fn write_png(
        &self,
        out: impl Write,
        display: Display,
        metadata: &Metadata,
    ) -> io::Result<()> {
        let mut encoder = png::Encoder::new(out, self.width(), self.height());
        encoder.set_color(match self.alpha() {
            Some(_) => png::ColorType::Rgba,
            None => png::ColorType::Rgb,
        });
        encoder.set_depth(png::BitDepth::Eight);
        // Fast compression takes a quarter of the time of the default, and compresses noisy images
        // equally well.
        encoder.set_compression(png::Compression::Fast);
        match display.transfer {
            Transfer::Srgb => encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual),
            Transfer::Gamma2 => encoder.set_source_gamma(png::ScaledFloat::new(0.5)),
        }
        for (key, value) in &display.noted(Format::Png, metadata.clone()).0 {
            encoder.add_itxt_chunk(key.clone(), value.clone())?;
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&match self.alpha() {
            Some(alpha) => display.encode_with_alpha(self.pixels(), alpha),
            None => display.encode(self.pixels()),
        })?;
        writer.finish()?;
        Ok(())
    }
}

/// The file of a layer, beside the image in `path`, whose format has one layer. PFM alone holds any number.
pub(crate) fn layer_path(path: &Path, layer: &str) -> PathBuf {
    path.with_extension(format!("{layer}.pfm"))
}

/// Writes all channels, which EXR files hold in the order of their names. Those of layers are called `layer.channel`.
fn write_exr(
    image: &Image,
    file: impl Write + Seek,
    half: bool,
    metadata: &Metadata,
) -> io::Result<()> {
    use exr::prelude::{AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Text, f16};
    use exr::prelude::{Image as Exr, Layer, LayerAttributes, WritableImage};
    // All entries go into one attribute of several lines: the crate writes custom attributes in an
    // order that changes from run to run.
    let lines: Vec<String> =
        metadata.0.iter().map(|(key, value)| format!("{key}: {value}")).collect();
    let attributes = LayerAttributes {
        comments: Text::new_or_none(lines.join("\n")),
        ..LayerAttributes::default()
    };
    fn of(values: &[[f32; 3]], channel: usize) -> impl Iterator<Item = f32> {
        values.iter().map(move |value| value[channel])
    }
    let floats = |name: &str, values| AnyChannel::new(name, FlatSamples::F32(values));
    let mut channels: Vec<_> = ["R", "G", "B"]
        .into_iter()
        .zip(0..)
        .map(|(name, channel)| floats(name, of(image.pixels(), channel).collect()))
        .collect();
    channels.extend(image.alpha().map(|alpha| floats("A", alpha.to_vec())));
    for layer in image.layers() {
        for (channel, name) in layer.channels().iter().enumerate() {
            let name = format!("{}.{name}", layer.name());
            let values = of(layer.values(), channel);
            channels.push(match half && !layer.numbers {
                true => {
                    let halves = values.map(f16::from_f32).collect();
                    AnyChannel::new(&*name, FlatSamples::F16(halves))
                }
                false => floats(&name, values.collect()),
            });
        }
    }
    let size = (image.width() as usize, image.height() as usize);
    let channels = AnyChannels::sort(channels.into());
    // Noise hardly compresses: ZIP takes 7 to 20 times as long, and the files have 0.6 to 0.9 of the size.
    let encoding = Encoding { compression: Compression::RLE, ..Encoding::SMALL_LOSSLESS };
    let exr = Exr::from_layer(Layer::new(size, attributes, encoding, channels));
    exr.write().non_parallel().to_buffered(file).map_err(|error| match error {
        exr::error::Error::Io(error) => error,
        other => io::Error::other(other.to_string()),
    })
}

fn write_hdr(image: &Image, file: impl Write) -> io::Result<()> {
    let pixels: Vec<image::Rgb<f32>> = image.pixels().iter().map(|&p| image::Rgb(p)).collect();
    image::codecs::hdr::HdrEncoder::new(file)
        .encode(&pixels, image.width() as usize, image.height() as usize)
        .map_err(|error| match error {
            image::ImageError::IoError(error) => error,
            other => io::Error::other(other.to_string()),
        })
}

/// In PFM, rows run from the bottom up, and a negative scale means little-endian.
fn write_pfm(image: &Image, mut file: impl Write) -> io::Result<()> {
    write!(file, "PF\n{} {}\n-1.0\n", image.width(), image.height())?;
    image.rows().rev().try_for_each(|row| file.write_all(&row_bytes(row)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    fn sample() -> Image {
        let pixels = (0..20u8).map(|i| [f32::from(i) * 0.05, 0.5, 1e-3]).collect();
        Image::from_pixels(5, 4, pixels)
    }

    #[test]
    fn float_formats_keep_the_bits_and_equal_renders_give_equal_files() {
        let folder = tempfile::tempdir().unwrap();
        let metadata = Metadata::default().with("hash", "abc").with("seed", 1).with("x", "y");
        for name in ["a.pfm", "a.exr", "a.PNG", "a.hdr"] {
            let path = folder.path().join(name);
            sample().write(&path, Transfer::Srgb, &metadata).unwrap();
            let first = fs::read(&path).unwrap();
            sample().write(&path, Transfer::Srgb, &metadata).unwrap();
            assert_eq!(fs::read(&path).unwrap(), first, "{name}");
            let back = Image::read(&path).unwrap();
            let tolerance = match name {
                "a.PNG" => 0.01,
                "a.hdr" => 0.005,
                _ => 0.0,
            };
            for (a, b) in sample().pixels().iter().flatten().zip(back.pixels().iter().flatten()) {
                assert!((a - b).abs() <= tolerance, "{name}: {a} {b}");
            }
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4, "no temporary file is left");
    }

    #[test]
    fn folders_and_unknown_extensions_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("folder.png");
        fs::create_dir(&path).unwrap();
        let error = sample().write(&path, Transfer::Srgb, &Metadata::default()).unwrap_err();
        assert!(error.to_string().ends_with("cannot write: it is a folder"), "{error}");
        assert_eq!(error.exit_code(), 74);
        let error = Format::of_path(Path::new("a.jpeg")).unwrap_err();
        assert!(error.to_string().contains("`jpeg`, use .png"), "{error}");
        assert_eq!(error.exit_code(), 2);
    }
}
