//! Reads what an OpenEXR file holds besides colour.

use std::collections::BTreeMap;
use std::path::Path;

use exr::prelude::{ReadChannels, ReadLayers, read};

use super::Format;
use super::source::Source;
use crate::error::Result;

/// Channels by name, each with one value per pixel, row by row from the top.
pub(crate) type Channels = BTreeMap<String, Vec<f32>>;

/// Reads the channels besides R, G and B of the file `path`, whose size [`Image::read_where`](super::Image) has
/// checked. Only OpenEXR files have any.
///
/// # Errors
/// If the file cannot be read, or is damaged.
pub(crate) fn other_channels(path: &Path) -> Result<Channels> {
    if Format::of_path(path).ok() != Some(Format::Exr) {
        return Ok(Channels::new());
    }
    let source = Source::file(path);
    let all = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
    let image = all.all_attributes().non_parallel().from_buffered(source.open()?);
    let image = image.map_err(|error| source.bad(format!("damaged image: {error}")))?;
    let channels = image.layer_data.channel_data.list.into_iter();
    let channels = channels.map(|channel| (channel.name.to_string(), channel.sample_data));
    let others = channels.filter(|(name, _)| !["R", "G", "B"].contains(&name.as_str()));
    Ok(others.map(|(name, values)| (name, values.values_as_f32().collect())).collect())
}
