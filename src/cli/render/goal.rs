//! Renders that end by time or noise instead of a number of samples.

use std::time::{Duration, Instant};

use crate::cli::arguments::denoise::DenoiseArgs;
use crate::engine::Session;
use crate::error::Result;
use crate::film::CHUNK;

/// Time to write a pixel of a picture and of each of its layers.
const WRITE: Duration = Duration::from_nanos(120);
/// Part of the remaining time that the next pass may take: the speed changes, above all at the start.
const SHARE: f64 = 0.7;

/// A usual number of samples per pixel of renders that end by their noise.
const USUAL: u32 = 256;

/// When a render without a fixed number of samples has enough of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    /// The time that the program may take.
    pub(crate) time: Option<Duration>,
    /// The relative error to reach.
    pub(crate) noise: Option<f64>,
    /// Largest number of samples per pixel.
    pub(crate) most: u32,
    /// About the seconds that denoising will take.
    pub(crate) denoising: f64,
    /// When the program started.
    pub(crate) start: Instant,
}

impl Goal {
    /// About the number of samples that each of `pixels` pixels will have, for the effort of preparing the render. In
    /// scenes whose trees take long, a path takes some three microseconds.
    pub(crate) fn samples(&self, pixels: u64) -> u32 {
        let of_time = |time: Duration| time.as_micros() as u64 / 3;
        let paths = self.time.map_or(u64::from(USUAL) * pixels, of_time);
        (paths / pixels.max(1)).clamp(1, self.most.into()) as u32
    }
}

/// `share` in percent, with three digits.
pub(crate) fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    let digits = (2.0 - percent.max(1e-9).log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{percent:.digits$}%")
}

/// The next pass over all pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pass {
    /// The number of samples per pixel at its end.
    pub(crate) end: u32,
    /// The number that the complete render is expected to have.
    pub(crate) total: u32,
}

/// The passes of a render towards its goal.
pub(crate) struct Course<'a> {
    session: &'a Session,
    goal: Option<Goal>,
    denoise: &'a DenoiseArgs,
    /// When the passes began, and the number of samples per pixel then.
    begun: (Instant, f64),
    /// The last two estimates of the noise, with the number of samples: the later one first.
    noise: [Option<(u32, f64)>; 2],
}

impl<'a> Course<'a> {
    /// The passes of a render that ends with all samples of the settings, unless it has a goal.
    pub(crate) fn new(session: &'a Session, goal: Option<Goal>, denoise: &'a DenoiseArgs) -> Self {
        let begun = (Instant::now(), session.state().samples_per_pixel());
        Self { session, goal, denoise, begun, noise: [None; 2] }
    }

    /// The next pass; `None` if the goal is reached.
    ///
    /// # Errors
    /// If memory runs out, or a denoiser fails whose error is to be estimated.
    pub(crate) fn next(&mut self) -> Result<Option<Pass>> {
        let (done, most, end) = {
            let film = &self.session.state().film;
            (film.least_done(), film.most_done(), film.samples().end)
        };
        let Some(goal) = self.goal else {
            return Ok((done < end).then_some(Pass { end, total: end }));
        };
        let left = goal.time.map(|time| {
            let end = time.as_secs_f64() - goal.denoising - self.writing();
            end - goal.start.elapsed().as_secs_f64()
        });
        let mut pass = Pass { end: goal.most, total: goal.most };
        if let Some(noise) = goal.noise {
            // Wherever a render was interrupted, it is estimated at the same numbers.
            if done > 0
                && next_estimate(done - 1) == done
                && let Some(estimate) = self.estimate(&goal, noise, left)?
            {
                self.noise = [Some((done, estimate)), self.noise[0]];
                if estimate <= noise {
                    return Ok(None);
                }
            }
            pass.end = next_estimate(done).min(goal.most);
            pass.total = expected(self.noise, noise).clamp(pass.end, goal.most);
        }
        if let Some(left) = left {
            let (begin, before) = self.begun;
            let samples = self.session.state().samples_per_pixel() - before;
            let fits = fitting(left, samples, begin.elapsed().as_secs_f64());
            if fits < 0.5 && done > 0 && done == most {
                // The render ends nearer to its time without another sample.
                return Ok(None);
            }
            pass.end = pass.end.min(aligned(done, samples_of_pass(fits, samples)));
            pass.total = pass.total.min(done.saturating_add(fits.round() as u32)).max(pass.end);
        }
        // If the render continues from a checkpoint, some pixels may have more samples than others.
        pass.end = pass.end.max(most);
        pass.total = pass.total.max(pass.end);
        Ok((done < pass.end).then_some(pass))
    }

    /// An estimate of the relative error of the picture: the last one, if its number of samples gives none.
    pub(crate) fn noise(&self) -> Option<f64> {
        let [Some((samples, error)), _] = self.noise else { return None };
        if self.denoise.denoise.is_some() {
            // How soon it falls is not known.
            return Some(error);
        }
        let more = f64::from(self.session.samples()) / f64::from(samples);
        Some(error / more.sqrt())
    }

    /// An estimate of the relative error of the picture, denoised if it will be. What is below `enough` anyway is not
    /// denoised, nor if that takes too much of the time that is `left`.
    fn estimate(&self, goal: &Goal, enough: f64, left: Option<f64>) -> Result<Option<f64>> {
        let Some(noisy) = self.session.noise()? else { return Ok(None) };
        if noisy <= enough || self.denoise.denoise.is_none() {
            return Ok(Some(noisy));
        }
        if left.is_some_and(|left| left < 3.0 * goal.denoising) {
            return Ok(None);
        }
        // The halves exaggerate where pixels see several surfaces, which all samples together divide evenly.
        let denoised = self.denoise.noise(self.session)?;
        Ok(Some(denoised.map_or(noisy, |denoised| denoised.min(noisy))))
    }

    /// About the seconds to write the picture.
    fn writing(&self) -> f64 {
        let settings = self.session.renderer().image_settings();
        let pictures = 1 + settings.layers.iter().count();
        WRITE.as_secs_f64() * settings.image().pixels() as f64 * pictures as f64
    }
}

/// The number of samples per pixel that fit in the remaining time, if so many took `seconds`.
fn fitting(left: f64, samples: f64, seconds: f64) -> f64 {
    match left > 0.0 {
        // How long a sample takes is not known yet.
        true if samples == 0.0 => 1.0,
        true => left * samples / seconds,
        false => 0.0,
    }
}

/// The number of samples of the next pass, if `fits` more fit in the remaining time and `samples` were rendered so far.
fn samples_of_pass(fits: f64, samples: f64) -> u32 {
    (SHARE * fits).min(samples).max(1.0) as u32
}

/// The end of a pass of about `more` samples: passes are fastest if they end with a chunk.
fn aligned(done: u32, more: u32) -> u32 {
    let end = done.saturating_add(more);
    if more < CHUNK { end } else { end / CHUNK * CHUNK }
}

/// The first number of samples above `done` that gives an estimate of the noise: 48, or 80, 96 or 112 times a power of
/// two. A film keeps the sums of these numbers in two or three parts of similar size.
fn next_estimate(done: u32) -> u32 {
    let powers = (0..u32::BITS - 7).map(|power| CHUNK << power);
    let ends = powers.flat_map(|unit| [5, 6, 7].map(|parts| parts * unit));
    [3 * CHUNK].into_iter().chain(ends).find(|end| *end > done).unwrap_or(u32::MAX)
}

/// The number of samples at which the error reaches `goal`, by the slope of the last two estimates.
#[expect(clippy::disallowed_methods, reason = "it is only shown")]
fn expected(estimates: [Option<(u32, f64)>; 2], goal: f64) -> u32 {
    let [Some((done, now)), before] = estimates else { return 0 };
    let slope = before.map_or(0.5, |(earlier, then)| {
        (then / now).ln() / (f64::from(done) / f64::from(earlier)).ln()
    });
    (f64::from(done) * (now / goal).powf(1.0 / slope.clamp(0.4, 1.0))).ceil() as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_shrink_towards_the_end() {
        assert_eq!([fitting(9.0, 0.0, 0.0), fitting(9.0, 4.0, 2.0)], [1.0, 18.0]);
        assert_eq!([fitting(-1.0, 0.0, 0.0), fitting(-1.0, 4.0, 2.0)], [0.0; 2]);
        // The number of samples at most doubles.
        assert_eq!([samples_of_pass(1.0, 0.0), samples_of_pass(1000.0, 1.0)], [1; 2]);
        assert_eq!(samples_of_pass(1000.0, 500.0), 500);
        assert_eq!(samples_of_pass(1000.0, 2000.0), 700);
        assert_eq!(samples_of_pass(0.6, 2000.0), 1);
        assert_eq!([aligned(5, 7), aligned(5, 16), aligned(32, 40)], [12, 16, 64]);
    }

    #[test]
    fn numbers_of_samples_that_give_estimates() {
        let mut ends = vec![0];
        while ends.len() < 9 {
            ends.push(next_estimate(ends[ends.len() - 1]));
        }
        assert_eq!(ends, [0, 48, 80, 96, 112, 160, 192, 224, 320]);
        assert!(next_estimate(crate::limits::MAX_SPP) > crate::limits::MAX_SPP);
    }

    #[test]
    fn the_slope_of_the_error_gives_the_number_of_samples() {
        assert_eq!(expected([None; 2], 0.1), 0);
        assert_eq!(expected([Some((100, 0.2)), None], 0.1), 400);
        // Four times the samples halve the error, or quarter it.
        assert_eq!(expected([Some((100, 0.2)), Some((25, 0.4))], 0.1), 400);
        assert_eq!(expected([Some((100, 0.1)), Some((25, 0.4))], 0.05), 200);
    }
}
