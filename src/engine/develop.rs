//! Develop: computes an image with its layers from the sums of samples that a film holds.

use std::ops::Range;

use super::ImageSettings;
use super::layers::{Combine, Layer, Layers};
use crate::error::Result;
use crate::film::{Film, Plane, Tile, mean};
use crate::image::{Image, ImageLayer};

/// The sums of all samples of each pixel, and the numbers of samples.
pub(crate) trait Totals {
    /// The sums of three channels from number `first` on. Channels beyond the last count as 0.
    ///
    /// # Errors
    /// If memory runs out.
    fn sums(&self, first: usize) -> Result<Plane>;

    /// The number of samples of each pixel with even numbers, and of those with odd numbers.
    fn counts(&self) -> impl Iterator<Item = [u32; 2]>;
}

/// Some rows of a film.
pub(crate) struct Rows<'a> {
    pub(crate) film: &'a Film,
    pub(crate) rows: Range<u32>,
}

impl<'a> Rows<'a> {
    /// All rows of `film`.
    pub(crate) fn all(film: &'a Film) -> Self {
        Self { film, rows: 0..film.area().height }
    }
}

impl Totals for Rows<'_> {
    fn sums(&self, first: usize) -> Result<Plane> {
        self.film.totals(first, self.rows.clone())
    }

    fn counts(&self) -> impl Iterator<Item = [u32; 2]> {
        // Each pixel begins with an even sample.
        let counts = self.film.counts(self.rows.clone());
        counts.map(|count| [count - count / 2, count / 2])
    }
}

/// The image of a film with these settings, whose pixels lie in `area`, with those of its layers that are `wanted`.
/// Pixels without samples are black.
///
/// # Errors
/// [`Error::Resource`](crate::Error::Resource) if memory runs out.
pub(crate) fn develop(
    settings: &ImageSettings,
    wanted: &Layers,
    area: Tile,
    film: &impl Totals,
) -> Result<Image> {
    let stored = settings.stored_layers();
    let color = film.sums(0)?.into_iter().zip(film.counts());
    let color = color.map(|(sum, [even, odd])| mean(sum, (even + odd) as f32)).collect();
    let layers = wanted.iter().filter_map(|layer| stored.develop(film, layer).transpose());
    let image = Image::from_pixels(area.width, area.height, color)
        .with_layers(layers.collect::<Result<_>>()?);
    match stored.develop(film, Layer::Alpha)?.filter(|_| settings.transparent) {
        None => Ok(image),
        Some(alpha) => Ok(image.with_alpha(alpha.values().iter().map(|a| a[0]).collect())),
    }
}

impl Layers {
    /// The layer `layer` of the image of `film`, which holds these layers; `None` if it is none of them.
    ///
    /// # Errors
    /// [`Error::Resource`](crate::Error::Resource) if memory runs out.
    pub(crate) fn develop(&self, film: &impl Totals, layer: Layer) -> Result<Option<ImageLayer>> {
        let sums = |wanted: Layer| {
            let place = self.places().find(|(layer, _)| *layer == wanted);
            place.map(|(_, place)| film.sums(place)).transpose()
        };
        let Some(mut values) = sums(layer)? else { return Ok(None) };
        let hits = |layer: Layer| -> Result<Vec<f32>> {
            Ok(sums(layer)?.unwrap_or_default().into_iter().map(|[first, ..]| first).collect())
        };
        let counts = film.counts().map(|counts| match layer.parity() {
            None => counts[0] + counts[1],
            Some(parity) => counts[parity as usize],
        });
        let (channels, combine) = layer.facts();
        let divisors: Vec<f32> = match (combine, layer.parity()) {
            (Combine::First | Combine::Count, _) => vec![1.0; values.len()],
            (Combine::Light | Combine::Mean, _) => counts.map(|count| count as f32).collect(),
            (Combine::MeanOfHits, None) => hits(Layer::Hits)?,
            (Combine::MeanOfHits, Some(0)) => hits(Layer::HitsEven)?,
            (Combine::MeanOfHits, Some(_)) => {
                let (all, even) = (hits(Layer::Hits)?, hits(Layer::HitsEven)?);
                all.iter().zip(even).map(|(all, even)| all - even).collect()
            }
        };
        for ((value, divisor), [even, odd]) in values.iter_mut().zip(divisors).zip(film.counts()) {
            value[layer.channels()..].fill(0.0);
            *value = mean(*value, divisor);
            if combine == Combine::Count {
                value[0] = (even + odd) as f32;
            }
        }
        let numbers = matches!(combine, Combine::First | Combine::Count);
        Ok(Some(ImageLayer { name: layer.name(), channels, numbers, values }))
    }
}
