//! The picture at rest: the denoiser fades as the noise becomes less than what it spoils.

use std::array;

use rayon::prelude::*;

use crate::denoise::Denoise;
use crate::error::Result;
use crate::image::{Display, Image};

/// The errors that decide how much of the denoiser's result is shown.
#[derive(Debug, Default)]
pub(super) struct Fade {
    /// For a number of samples, the errors of the noisy and of the denoised picture.
    errors: Option<(u32, (f64, f64))>,
}

impl Fade {
    /// The codes of a picture with this number of samples. Threads of the current pool share the work.
    ///
    /// # Errors
    /// Those of [`Image::denoised`].
    pub(super) fn shown(
        &mut self,
        image: Image,
        samples: u32,
        display: &Display,
    ) -> Result<Vec<u8>> {
        if self.errors.is_none_or(|(known, _)| samples >= 2 * known) {
            let errors = image.noise().zip(image.denoised_noise(Denoise::Fast)?);
            self.errors = errors.map(|errors| (samples, errors));
        }
        let share = self.share(samples);
        let image = image.denoised(Denoise::Fast)?;
        let Some(noisy) = image.layer("noisy") else { return Ok(display.rgba(image.pixels())) };
        let pairs = image.pixels().par_iter().zip(noisy.values());
        let mixed = pairs.map(|(denoised, noisy)| {
            array::from_fn(|c| noisy[c] + (denoised[c] - noisy[c]) * share)
        });
        Ok(display.rgba(&mixed.collect::<Vec<[f32; 3]>>()))
    }

    /// The share of the denoised picture.
    fn share(&self, samples: u32) -> f32 {
        let Some((known, (noise, denoised))) = self.errors else { return 1.0 };
        // The squared error of noise falls with the samples.
        let noise = noise * noise * f64::from(known) / f64::from(samples);
        (noise / (noise + denoised * denoised).max(f64::MIN_POSITIVE)) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_denoiser_fades_with_samples() {
        let fade = Fade { errors: Some((4, (0.2, 0.1))) };
        assert!((fade.share(4) - 0.8).abs() < 1e-6 && (fade.share(16) - 0.5).abs() < 1e-6);
        assert_eq!(Fade::default().share(1), 1.0);
    }
}
