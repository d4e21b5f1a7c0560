//! The error of a denoised image, estimated before there is a better one.

use super::input::{Input, Layers};
use super::{Denoise, filtered, oidn, tiled};
use crate::error::Result;
use crate::image::Image;

/// The square of the error in relation to the variance: filters that leave little variance blur, and what is best
/// makes both errors about equal.
const BLUR: f64 = 2.0;

impl Image {
    /// An estimate of the relative error of the image, from the layers `color_even` and `color_odd`. `None` if it lacks
    /// them, or is black.
    pub(crate) fn noise(&self) -> Option<f64> {
        let [even, odd] = ["color_even", "color_odd"].map(|name| self.layer(name));
        let halves = even?.values().iter().zip(odd?.values());
        let halves: Vec<_> = halves.map(|(even, odd)| [*even, *odd]).collect();
        Some(relative_error(&halves)? / BLUR.sqrt())
    }

    /// An estimate of the relative error that [`denoised`](Self::denoised) would leave, by the same definition as that
    /// of [`Session::noise`](crate::Session::noise). `None` if the image lacks the layers `color_even` and
    /// `color_odd`, or is black.
    ///
    /// Both halves are denoised, and their difference shows what noise is left. What blur spoils equally in both
    /// cannot be seen: it is taken to be as large.
    ///
    /// # Errors
    /// [`Error::Resource`](crate::Error::Resource) if [`Denoise::Oidn`] lacks its library or fails.
    pub fn denoised_noise(&self, quality: Denoise) -> Result<Option<f64>> {
        if self.pixels().is_empty() {
            return Ok(None);
        }
        let layers = Layers::new(self, quality);
        let Some([even, odd]) = layers.halves else { return Ok(None) };
        let halves = match quality {
            Denoise::Oidn => {
                let [even, odd] = oidn::denoised(self, [even, odd])?;
                even.into_iter().zip(odd).map(|(even, odd)| [even, odd]).collect()
            }
            Denoise::Fast | Denoise::Good => {
                tiled(&layers, |input: &Input| filtered(input, input.limited_halves().each_ref()))
            }
        };
        Ok(relative_error(&halves))
    }
}

/// The relative error of the mean of two independent images.
fn relative_error(halves: &[[[f32; 3]; 2]]) -> Option<f64> {
    let values = || {
        halves.iter().flat_map(|[even, odd]| even.iter().zip(odd)).map(|(&even, &odd)| {
            let [even, odd] = [even, odd].map(f64::from);
            (0.5 * (even + odd), 0.5 * (even - odd))
        })
    };
    let count = values().count() as f64;
    let mean = values().map(|(mean, _)| mean).sum::<f64>() / count;
    let least = 0.01 * mean * mean;
    let squares = values().map(|(mean, half)| half * half / (mean * mean + least));
    (mean > 0.0).then(|| (BLUR * squares.sum::<f64>() / count).sqrt())
}
