//! Reads OpenEXR files.

mod header;
mod layer;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;

use ::exr::block::UncompressedBlock;
use ::exr::block::chunk::{Chunk, CompressedBlock};
use ::exr::block::reader::ChunksReader;
use ::exr::error::{Error as ExrError, UnitResult};
use ::exr::math::Vec2;
use ::exr::meta::MetaData;
use ::exr::meta::attribute::{EnvironmentMap, SampleType, Text};
use ::exr::meta::header::Header;
use ::exr::prelude::{Compression, f16};
use image::{DynamicImage, Rgb32FImage, Rgba32FImage};
use layer::{ExrLayer, Kind};

use super::colorimetry::Conversion;
use super::size::{Allow, Size};
use super::{Encoding, Format, Metadata, Source};
use crate::error::{Error, Result};
use crate::limits::MAX_SIDE;

/// Estimated bytes of memory for each compressed block: its place in the file and in the picture.
const PER_BLOCK: u64 = 100;

/// Channels by name, each with one value per pixel, row by row from the top.
pub(crate) type Channels = BTreeMap<String, Vec<f32>>;

/// The error of a method of compression that the decoder lacks.
fn compression(name: &str) -> String {
    format!("unsupported image: its compression is {name}, write it with another, such as ZIP")
}

/// The headers of all parts, whose kinds the decoder reads.
fn headers(source: &Source<'_>) -> Result<Vec<Header>> {
    header::check(source.open()?).map_err(|message| source.bad(message))?;
    let all = MetaData::read_from_buffered(source.open()?, false);
    let headers = all.map_err(|error| failed(source, error))?.headers;
    for header in &headers {
        let channels = &header.channels.list;
        if header.deep {
            return Err(source.bad("unsupported image: it has deep data, flatten it".to_owned()));
        }
        if channels.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
            let is_chroma = |name: &Text| name.eq("RY") || name.eq("BY");
            return Err(source.bad(
                match channels.iter().any(|channel| is_chroma(&channel.name)) {
                    true => luma(),
                    false => {
                        "unsupported image: its channels have different resolutions".to_owned()
                    }
                },
            ));
        }
    }
    Ok(headers.into_vec())
}

fn luma() -> String {
    "unsupported image: it has luminance and chroma (Y, RY, BY), write it as RGB".to_owned()
}

fn failed(source: &Source<'_>, error: ExrError) -> Error {
    match error {
        // A file may point to a place before its beginning.
        ExrError::Io(error) if error.kind() != ErrorKind::InvalidInput => {
            Error::io(source.path(), "read")(error)
        }
        ExrError::NotSupported(what) => source.bad(format!("unsupported image: {what}")),
        other => source.bad(format!("damaged image: {other}")),
    }
}

/// Reads the image of the file, as linear Rec. 709 unless its values are numbers. `allow` is called before memory
/// for it is allocated.
pub(super) fn decode(
    source: &Source<'_>,
    encoding: Encoding,
    allow: Allow<'_>,
) -> Result<DynamicImage> {
    let bad = |message: String| source.bad(message);
    let headers = headers(source)?;
    let layer = layer::choose(&headers, source.layer()).map_err(bad)?;
    let header = &headers[layer.part];
    check_kind(header, &layer).map_err(bad)?;
    let conversion = conversion(header, &layer, encoding).map_err(bad)?;
    let shown = header.shared_attributes.display_window;
    let (width, height) = (shown.size.width(), shown.size.height());
    let memory = memory(header).saturating_add(area(shown.size).saturating_mul(32));
    let pixels = area(header.layer_size).max(area(shown.size));
    allow(Size { pixels, deep: true, memory }).map_err(bad)?;
    if !(1..=MAX_SIDE as usize).contains(&width) || !(1..=MAX_SIDE as usize).contains(&height) {
        let message = "its sides must have 1 to";
        return Err(bad(format!(
            "damaged image: {message} {MAX_SIDE} pixels, not {width} × {height}"
        )));
    }
    let [r, g, b] = layer.colors;
    let channels = [Some(r), Some(g), Some(b), layer.alpha];
    let count = if layer.alpha.is_some() { 4 } else { 3 };
    let mut values = vec![0.0; count * width * height];
    let moved = header.own_attributes.layer_position - shown.position;
    read(source, layer.part, |channel, Vec2(x, y), line| {
        // Pixels outside the display window are not shown.
        let y = i64::try_from(y).unwrap_or(i64::MAX).saturating_add(moved.y().into());
        let Some(row) = usize::try_from(y).ok().filter(|&y| y < height) else { return };
        let row = &mut values[row * width * count..(row + 1) * width * count];
        let first = i64::try_from(x).unwrap_or(i64::MAX).saturating_add(moved.x().into());
        for target in (0..count).filter(|&target| channels[target] == Some(channel)) {
            for (x, &value) in (first..).zip(line) {
                if let Some(x) = usize::try_from(x).ok().filter(|&x| x < width) {
                    row[x * count + target] = value;
                }
            }
        }
    })?;
    if let Some(conversion) = conversion {
        values.chunks_exact_mut(count).for_each(|pixel| conversion.apply(pixel));
    }
    let (width, height) = (width as u32, height as u32);
    let image = match count {
        3 => Rgb32FImage::from_raw(width, height, values).map(DynamicImage::from),
        _ => Rgba32FImage::from_raw(width, height, values).map(DynamicImage::from),
    };
    Ok(image.expect("there is a value for each channel of each pixel"))
}

/// Checks that the decoder can read the part of the layer.
fn check_kind(header: &Header, layer: &ExrLayer) -> Result<(), String> {
    if layer.kind == Kind::Luma {
        return Err(luma());
    }
    if header.own_attributes.environment_map == Some(EnvironmentMap::Cube) {
        return Err("unsupported image: it is a cube map, make it latitude-longitude with \
                    `exrenvmap -latlong`"
            .to_owned());
    }
    match header.compression {
        Compression::HTJ2K32 | Compression::HTJ2K256 => Err(compression("HTJ2K")),
        _ => Ok(()),
    }
}

/// How the colours become linear Rec. 709, if they are not.
fn conversion(
    header: &Header,
    layer: &ExrLayer,
    encoding: Encoding,
) -> Result<Option<Conversion>, String> {
    if encoding == Encoding::Linear || !matches!(layer.kind, Kind::Colors | Kind::Grey) {
        return Ok(None);
    }
    let id = header.own_attributes.other.get(&Text::from("colorInteropID"));
    let id = id.and_then(|id| id.to_text().ok()).map(ToString::to_string);
    let xy = |Vec2(x, y): Vec2<f32>| [f64::from(x), f64::from(y)];
    let primaries = header.shared_attributes.chromaticities;
    let primaries = primaries.map(|all| [all.red, all.green, all.blue, all.white].map(xy));
    Conversion::of(id.as_deref(), primaries)
}

fn area(size: Vec2<usize>) -> u64 {
    (size.width() as u64).saturating_mul(size.height() as u64)
}

/// Bytes of memory of the decoder for a part: its values, several blocks, and the list of blocks.
fn memory(header: &Header) -> u64 {
    let values = area(header.layer_size).saturating_mul(header.channels.bytes_per_pixel as u64);
    let block = (header.max_block_byte_size() as u64).saturating_mul(8);
    let list = PER_BLOCK.saturating_mul(header.chunk_count as u64);
    values.saturating_add(block).saturating_add(list)
}

/// Checks the counts at the beginning of a block in DWA compression, for which the decoder allocates memory.
fn check_counts(chunk: &Chunk, header: &Header) -> UnitResult {
    let bytes = match &chunk.compressed_block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return Ok(()),
    };
    let is_dwa = matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_));
    let place = header.get_block_data_indices(&chunk.compressed_block)?;
    let size = header.get_absolute_block_pixel_coordinates(place)?.size;
    if !is_dwa || bytes.len() == size.area() * header.channels.bytes_per_pixel {
        // Blocks that compression does not shrink are stored as they are.
        return Ok(());
    }
    // A block is padded to squares of 8 × 8 values.
    let most = (header.max_block_byte_size() as u64).saturating_mul(8).saturating_add(1 << 20);
    let counts = bytes.as_chunks().0.iter().take(10).map(|count| u64::from_le_bytes(*count));
    if counts.max().is_some_and(|count| count > most) {
        return Err(ExrError::Invalid("a block has too many values".into()));
    }
    Ok(())
}

/// Calls `put` with the lines of all channels of a part: the number of the channel, the place of the first value in
/// the data window, and the values.
fn read(
    source: &Source<'_>,
    part: usize,
    mut put: impl FnMut(usize, Vec2<usize>, &[f32]),
) -> Result<()> {
    let mut line = Vec::new();
    let mut decode = || -> UnitResult {
        let Ok(stream) = source.open() else { return Err(ExrError::Aborted) };
        let top = Vec2(0, 0);
        let chunks = ::exr::block::read(stream, false)?
            .filter_chunks(false, |_, tile, block| {
                block.layer == part && tile.level_index == top
            })?;
        let all = chunks.meta_data().clone();
        for chunk in chunks {
            let chunk = chunk?;
            check_counts(&chunk, &all.headers[part])?;
            let block = UncompressedBlock::decompress_chunk(chunk, &all, false)?;
            // A file may point to blocks of other parts.
            if block.index.layer != part || block.index.level != top {
                return Err(ExrError::Invalid("a block is of another part".into()));
            }
            let channels = &all.headers[part].channels;
            for found in block.lines(channels) {
                let place = found.location;
                line.clear();
                let bytes = found.value;
                match channels.list[place.channel].sample_type {
                    SampleType::F16 => line.extend(
                        bytes.as_chunks().0.iter().map(|b| f16::from_ne_bytes(*b).to_f32()),
                    ),
                    SampleType::F32 => {
                        line.extend(bytes.as_chunks().0.iter().map(|b| f32::from_ne_bytes(*b)));
                    }
                    SampleType::U32 => line
                        .extend(bytes.as_chunks().0.iter().map(|b| u32::from_ne_bytes(*b) as f32)),
                }
                put(place.channel, place.position, &line);
            }
        }
        Ok(())
    };
    decode().map_err(|error| failed(source, error))
}

/// Reads the channels of all parts of the file `path` besides those of its image. The size of the image has been
/// checked by [`Image::read_where`](super::Image). Only OpenEXR files have any, and none if the path names a layer.
///
/// # Errors
/// If the file cannot be read, is damaged, or `allow` fails, as for [`Image::read_where`](super::Image).
pub(crate) fn other_channels(
    path: &Path,
    allow: &dyn Fn(u64, u64) -> Result<(), String>,
) -> Result<Channels> {
    let source = Source::file(path);
    let mut channels = Channels::new();
    if source.layer().is_some() || Format::of_path(path).ok() != Some(Format::Exr) {
        return Ok(channels);
    }
    let headers = headers(&source)?;
    let chosen = layer::choose(&headers, None).map_err(|message| source.bad(message))?;
    for (part, header) in headers.iter().enumerate() {
        let size = header.layer_size;
        let floats = area(size).saturating_mul(4 * header.channels.list.len() as u64);
        let allowed = allow(area(size), memory(header).saturating_add(floats));
        allowed.map_err(|message| source.bad(message))?;
        let mut others: Vec<Option<Vec<f32>>> = (0..header.channels.list.len())
            .map(|channel| {
                let is_image = part == chosen.part && chosen.colors.contains(&channel);
                (!is_image).then(|| vec![0.0; size.area()])
            })
            .collect();
        read(&source, part, |channel, place, line| {
            if let Some(values) = &mut others[channel] {
                let first = place.y() * size.width() + place.x();
                values[first..first + line.len()].copy_from_slice(line);
            }
        })?;
        let name = header.own_attributes.layer_name.as_ref().filter(|_| headers.len() > 1);
        for (channel, values) in header.channels.list.iter().zip(others) {
            let own = channel.name.to_string();
            let full = match name {
                Some(part) if !own.starts_with(&part.to_string()) => format!("{part}.{own}"),
                _ => own,
            };
            channels.extend(values.map(|values| (full, values)));
        }
    }
    Ok(channels)
}

/// Whether the layer that the file shows has an alpha channel.
pub(super) fn has_alpha(source: &Source<'_>) -> bool {
    let layer = |headers: Vec<Header>| layer::choose(&headers, source.layer()).ok();
    headers(source).ok().and_then(layer).is_some_and(|layer| layer.alpha.is_some())
}

/// The text entries that ptfast wrote to the file.
pub(super) fn metadata(source: &Source<'_>) -> Result<Metadata> {
    let headers = headers(source)?;
    let comments = headers.first().and_then(|header| header.own_attributes.comments.as_ref());
    let text = comments.map(ToString::to_string).unwrap_or_default();
    let lines = text.lines().filter_map(|line| line.split_once(": "));
    Ok(lines.fold(Metadata::default(), |all, (key, value)| all.with(key, value)))
}
