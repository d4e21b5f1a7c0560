//! The error of a film's means, estimated from the sums that it keeps.

use super::{CHUNK, Film, Sums, sum};
use crate::error::Result;

impl Film {
    /// The number of samples of each pixel, unless pixels have different numbers.
    fn even_samples(&self) -> Option<u32> {
        let first = *self.done.first()?;
        self.done.iter().all(|&done| done == first).then(|| first - self.samples.start)
    }

    /// An estimate of the image's relative error: the root of the mean of (x − r)² / (r² + 0.01 m²) over all pixels and
    /// channels, for the colours x, their expected values r, and the mean m of r. `None` unless all pixels have the same
    /// number of samples, whose sum the film keeps in several parts.
    ///
    /// Each part has neighbouring samples, which fill their domain as evenly as all samples do. So the differences
    /// of the parts show the variance of the whole, which those of samples with even and with odd numbers exaggerate.
    /// r is estimated by the colour of the pixel or of the pixels around it, whichever is less: otherwise the
    /// noise that makes a pixel bright would also make its error look small.
    ///
    /// # Errors
    /// [`Error::Resource`](crate::Error::Resource) if memory runs out.
    pub(crate) fn relative_error(&self) -> Result<Option<f64>> {
        let Some(samples) = self.even_samples() else { return Ok(None) };
        let nodes = sum::nodes(0..samples / CHUNK).map(|(level, _)| f64::from(CHUNK << level));
        let nodes: Vec<f64> = nodes.collect();
        if nodes.len() < 2 || !samples.is_multiple_of(CHUNK) || self.samples.start != 0 {
            return Ok(None);
        }
        let means = self.means()?;
        let all: f64 = means.iter().flatten().map(|&x| f64::from(x)).sum();
        let values = 3.0 * means.len() as f64;
        let mean = all / values;
        if mean <= 0.0 {
            // In a black image, no path may have found the light yet.
            return Ok(None);
        }
        let least = 0.01 * mean * mean;
        let around = Around { means: &means, width: self.area.width as usize };
        let mut errors = 0.0;
        for (pixel, mean) in means.iter().enumerate() {
            let place = self.of_pixels(pixel..pixel + 1).start;
            for (channel, &x) in mean.iter().enumerate() {
                let x = f64::from(x);
                let square = |(&n, sums): (&f64, &Sums)| {
                    let difference = f64::from(sums[place + channel]) / n - x;
                    n * difference * difference
                };
                let squares: f64 = nodes.iter().zip(&self.sums).map(square).sum();
                let variance = squares / (nodes.len() - 1) as f64 / f64::from(samples);
                let r = around.mean(pixel, channel).min(x);
                errors += variance / (r * r + least);
            }
        }
        Ok(Some((errors / values).sqrt()))
    }
}

/// The colours of an image, row by row.
struct Around<'a> {
    means: &'a [[f32; 3]],
    width: usize,
}

impl Around<'_> {
    /// The mean of a channel over the pixel and its neighbours.
    fn mean(&self, pixel: usize, channel: usize) -> f64 {
        let (x, y) = (pixel % self.width, pixel / self.width);
        let columns = x.saturating_sub(1)..(x + 2).min(self.width);
        let rows = y.saturating_sub(1)..(y + 2).min(self.means.len() / self.width);
        let count = (columns.len() * rows.len()) as f64;
        let row = |y: usize| &self.means[y * self.width..][columns.clone()];
        rows.flat_map(row).map(|mean| f64::from(mean[channel])).sum::<f64>() / count
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Tile, Unit, UnitSums};
    use super::*;
    use crate::math::Stream;

    /// A film of `samples` independent samples per pixel, whose colours have this mean and standard deviation.
    fn film(samples: u32, mean: f32, deviation: f32) -> Film {
        let tile = Tile { x: 0, y: 0, width: 40, height: 30 };
        let mut film = Film::new(tile, 0..samples, 3).unwrap();
        let mut random = Stream::new(5);
        // Uniform numbers in [−1, 1] have a variance of 1/3.
        let mut sample = || mean + deviation * 3f32.sqrt() * (2.0 * random.uniform() - 1.0);
        for first in (0..samples).step_by(CHUNK as usize) {
            let unit = Unit { tile, first, end: samples.min(first + CHUNK) };
            let values = 3 * tile.pixels() as usize;
            let sums = (0..values).map(|_| (first..unit.end).map(|_| sample()).sum()).collect();
            film.add(&UnitSums { unit, sums }).unwrap();
        }
        film
    }

    #[test]
    fn the_estimate_is_the_error_of_independent_samples() {
        for (samples, mean, deviation) in [(48, 2.0, 0.5), (80, 1.0, 1.0), (112, 0.3, 0.1)] {
            let estimate = film(samples, mean, deviation).relative_error().unwrap().unwrap();
            let truth = f64::from(deviation) / f64::from(samples).sqrt();
            let relative = truth / (f64::from(mean) * f64::from(mean) * 1.01).sqrt();
            let ratio = estimate / relative;
            assert!((0.97..1.2).contains(&ratio), "{samples} samples: {ratio} times the truth");
        }
    }

    #[test]
    fn some_numbers_of_samples_give_no_estimate() {
        for samples in [1, 16, 31, 32, 49, 64] {
            assert_eq!(film(samples, 1.0, 1.0).relative_error().unwrap(), None, "{samples}");
        }
        assert_eq!(film(48, 0.0, 0.0).relative_error().unwrap(), None, "black");
    }
}
