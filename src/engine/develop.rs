//! Develop: computes an image with its layers from the sums of samples that a film holds.

use std::ops::Range;

use rayon::prelude::*;

use super::ImageSettings;
use super::layers::{Combine, Layer, Layers};
use crate::error::Result;
use crate::film::{Film, Plane, Tile, mean, plane};
use crate::image::{Image, ImageLayer};

/// The sums of all samples of each pixel, and the numbers of samples.
pub(crate) trait Totals: Sync {
    /// Calls `take` for each pixel of row number `row` with the sum of each channel, and the number of samples with
    /// even and with odd numbers.
    fn row(&self, row: u32, take: impl FnMut(&[f32], [u32; 2]));
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
    fn row(&self, row: u32, mut take: impl FnMut(&[f32], [u32; 2])) {
        // Each pixel begins with an even sample.
        let halves = |count: u32| [count - count / 2, count / 2];
        self.film.totals(self.rows.start + row, |sums, count| take(sums, halves(count)));
    }
}

/// How the value of a layer follows from the sums of a pixel.
struct Recipe {
    layer: Layer,
    /// The first channel of its sum.
    place: usize,
    /// The channels that count first hits: of all samples, and of even ones.
    hits: [usize; 2],
}

impl Recipe {
    /// That of `layer`; `None` if a film with the layers `stored` lacks it.
    fn new(stored: &Layers, layer: Layer) -> Option<Self> {
        let place =
            |wanted| stored.places().find(|(layer, _)| *layer == wanted).map(|found| found.1);
        let hits = [Layer::Hits, Layer::HitsEven].map(|layer| place(layer).unwrap_or_default());
        Some(Self { layer, place: place(layer)?, hits })
    }

    #[inline]
    fn value(&self, sums: &[f32], [even, odd]: [u32; 2]) -> [f32; 3] {
        let channels = self.layer.channels();
        let mut sum = [0.0; 3];
        sum[..channels].copy_from_slice(&sums[self.place..][..channels]);
        let [all, evens] = self.hits;
        match (self.layer.facts().1, self.layer.parity()) {
            (Combine::First, _) => sum,
            (Combine::Count, _) => [(even + odd) as f32, 0.0, 0.0],
            (Combine::Light | Combine::Mean, None) => mean(sum, (even + odd) as f32),
            (Combine::Light | Combine::Mean, Some(parity)) => {
                mean(sum, [even, odd][parity as usize] as f32)
            }
            (Combine::MeanOfHits, None) => mean(sum, sums[all]),
            (Combine::MeanOfHits, Some(0)) => mean(sum, sums[evens]),
            (Combine::MeanOfHits, Some(_)) => mean(sum, sums[all] - sums[evens]),
        }
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
    developed(settings, wanted, area, |recipes, rows| {
        rows.into_iter().for_each(|row| row.fill(recipes, film));
    })
}

/// [`develop`] by all threads of the current pool.
///
/// # Errors
/// Those of [`develop`].
pub(crate) fn develop_in_parallel(
    settings: &ImageSettings,
    wanted: &Layers,
    area: Tile,
    film: &impl Totals,
) -> Result<Image> {
    developed(settings, wanted, area, |recipes, rows| {
        rows.into_par_iter().for_each(|row| row.fill(recipes, film));
    })
}

/// A row of the image and of its layers.
struct Row<'a> {
    number: u32,
    colors: &'a mut [[f32; 3]],
    layers: Vec<&'a mut [[f32; 3]]>,
}

impl Row<'_> {
    fn fill(mut self, recipes: &[Recipe], film: &impl Totals) {
        let mut pixel = 0;
        film.row(self.number, |sums, counts| {
            let [even, odd] = counts;
            self.colors[pixel] = mean([sums[0], sums[1], sums[2]], (even + odd) as f32);
            for (values, recipe) in self.layers.iter_mut().zip(recipes) {
                values[pixel] = recipe.value(sums, counts);
            }
            pixel += 1;
        });
    }
}

fn developed(
    settings: &ImageSettings,
    wanted: &Layers,
    area: Tile,
    fill: impl FnOnce(&[Recipe], Vec<Row<'_>>),
) -> Result<Image> {
    let stored = settings.stored_layers();
    let alpha = settings.transparent.then_some(Layer::Alpha);
    let recipes: Vec<Recipe> =
        wanted.iter().chain(alpha).filter_map(|layer| Recipe::new(&stored, layer)).collect();
    let mut colors = plane(area, [0.0; 3], 1)?;
    let mut layers: Vec<Plane> =
        recipes.iter().map(|_| plane(area, [0.0; 3], 1)).collect::<Result<_>>()?;
    let width = area.width as usize;
    let mut rows: Vec<Row<'_>> = (0..)
        .zip(colors.chunks_exact_mut(width))
        .map(|(number, colors)| Row { number, colors, layers: Vec::with_capacity(recipes.len()) })
        .collect();
    for values in &mut layers {
        for (row, values) in rows.iter_mut().zip(values.chunks_exact_mut(width)) {
            row.layers.push(values);
        }
    }
    fill(&recipes, rows);
    let alpha = alpha.and_then(|_| layers.pop());
    let layers = layers.into_iter().zip(&recipes).map(|(values, recipe)| {
        let (channels, combine) = recipe.layer.facts();
        let numbers = matches!(combine, Combine::First | Combine::Count);
        ImageLayer { name: recipe.layer.name(), channels, numbers, values }
    });
    let image = Image::from_pixels(area.width, area.height, colors).with_layers(layers.collect());
    Ok(match alpha {
        None => image,
        Some(alpha) => image.with_alpha(alpha.into_iter().map(|[alpha, ..]| alpha).collect()),
    })
}
