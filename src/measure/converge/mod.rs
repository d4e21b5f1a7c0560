//! Measures how fast the error of images falls with samples and with seconds.
//!
//! The error of an image x is its mean squared difference from the true image, over pixels and channels.
//! Two long, independent renders a and b stand in for the true image. The mean of (x − a)(x − b) is
//! right on average, however noisy a and b are. The mean of (x − a)² would be too large by the
//! noise of a.

mod plot;
mod slope;

pub(crate) use plot::plot;
use serde::Serialize;
pub(crate) use slope::{Slope, at_seconds};

use super::statistics::{middle, sorted};
use crate::engine::{ComputeSettings, ImageSettings, Render, Renderer};
use crate::error::Result;
use crate::image::Image;
use crate::sampler::Sampler;
use crate::scene::{Sampling, Scene};

/// Options of a measurement.
pub(crate) struct Options {
    /// Settings of all renders, except for the sampling, the sampler and the number of samples. The
    /// seeds of the renders derive from the seed in these settings.
    pub(crate) settings: ImageSettings,
    /// How all renders are computed.
    pub(crate) compute: ComputeSettings,
    /// The combinations of a sampling strategy and a sampler to compare.
    pub(crate) ways: Vec<Way>,
    /// Samples per pixel of the longest renders. The others have half as many, a quarter as many,
    /// and so on, down to 1.
    pub(crate) most: u32,
    /// Number of renders of each way with each number of samples per pixel.
    pub(crate) rounds: u32,
    /// Samples per pixel of each of the two reference renders.
    pub(crate) reference: u32,
}

/// A sampling strategy for light, and a sampler that provides its random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Way {
    pub(crate) sampling: Sampling,
    pub(crate) sampler: Sampler,
}

impl Way {
    /// Name in tables and plots.
    pub(crate) fn name(self) -> String {
        format!("{} {}", self.sampling.name(), self.sampler.name())
    }
}

/// Error of the renders that have the same number of samples per pixel.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Point {
    pub(crate) spp: u32,
    /// Mean squared error, averaged over the renders.
    pub(crate) mse: f64,
    /// Standard error of `mse` due to the noise of the renders. It is unknown for a single render,
    /// and is then set to 0.
    pub(crate) mse_error: f64,
    /// Median time of the renders, without building trees.
    pub(crate) seconds: f64,
}

/// The measured errors of one way.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    pub(crate) way: Way,
    pub(crate) points: Vec<Point>,
}

/// Renders everything and returns a curve for each way. Reports two sums over the renders to
/// `progress`: the samples per pixel of the finished renders, and those of all renders.
///
/// # Errors
/// If a setting is out of range, or a render fails.
pub(crate) fn measure(
    scene: &Scene,
    options: &Options,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<Curve>> {
    let halved = |spp: &u32| (*spp > 1).then(|| spp / 2);
    let mut counts: Vec<u32> = std::iter::successors(Some(options.most), halved).collect();
    counts.reverse();
    let in_round: u64 = counts.iter().map(|&spp| u64::from(spp)).sum();
    let all = 2 * u64::from(options.reference)
        + in_round * u64::from(options.rounds) * options.ways.len() as u64;
    let mut renderer = Renderer::new(scene, options.settings.clone(), options.compute.clone())?;
    let mut done = 0;
    let mut render = |way: Way, spp: u32, seed: u64| {
        let Way { sampling, sampler } = way;
        let settings = ImageSettings { sampling, sampler, spp, seed, ..options.settings.clone() };
        renderer.set(settings, options.compute.clone())?;
        let render = renderer.render()?;
        done += u64::from(spp);
        progress(done, all);
        Ok(render)
    };
    // Seeds are far apart, and no other render uses those of the reference.
    let seed = |which: u64| options.settings.seed.wrapping_add(which << 32);
    let best = Way { sampling: scene.default_sampling(), sampler: Sampler::Sobol };
    let truth = [1, 2].map(|half| render(best, options.reference, seed(half)));
    let [a, b] = truth;
    let (a, b): (Image, Image) = (a?.image, b?.image);
    let mut found = vec![vec![Vec::new(); counts.len()]; options.ways.len()];
    for round in 0..options.rounds {
        for (index, &spp) in counts.iter().enumerate() {
            // The order alternates, so that no way is always first.
            let mut order: Vec<usize> = (0..options.ways.len()).collect();
            if round % 2 == 1 {
                order.reverse();
            }
            for way in order {
                let Render { image, seconds, .. } =
                    render(options.ways[way], spp, seed(3 + u64::from(round)))?;
                found[way][index].push((squared_error(&image, &a, &b), seconds.render));
            }
        }
    }
    let curves = options.ways.iter().zip(found).map(|(&way, found)| {
        let points = counts.iter().zip(found).map(|(&spp, renders)| point(spp, &renders));
        Curve { way, points: points.collect() }
    });
    Ok(curves.collect())
}

/// The mean of (x − a)(x − b) over pixels and channels.
fn squared_error(x: &Image, a: &Image, b: &Image) -> f64 {
    let pixels = x.pixels().iter().zip(a.pixels()).zip(b.pixels());
    let sum: f64 = pixels
        .flat_map(|((x, a), b)| [0, 1, 2].map(|channel| (x[channel], a[channel], b[channel])))
        .map(|(x, a, b)| (f64::from(x) - f64::from(a)) * (f64::from(x) - f64::from(b)))
        .sum();
    sum / (3 * x.pixels().len()) as f64
}

fn point(spp: u32, renders: &[(f64, f64)]) -> Point {
    let n = renders.len() as f64;
    let mse = renders.iter().map(|(mse, _)| mse).sum::<f64>() / n;
    let squares = renders.iter().map(|(one, _)| (one - mse) * (one - mse)).sum::<f64>();
    Point {
        spp,
        mse,
        mse_error: if n > 1.0 { (squares / (n - 1.0) / n).sqrt() } else { 0.0 },
        seconds: middle(&sorted(renders.iter().map(|(_, seconds)| *seconds))),
    }
}
