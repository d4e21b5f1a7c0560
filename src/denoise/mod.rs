//! The denoiser: removes the noise of an image with the help of its layers.
//!
//! `good` compares colours in one half of the samples, and with these weights takes means of the other half.
//! So noise does not choose the pixels whose mean it would spoil. The result of both halves together then
//! gives the weights of a regression on albedo, normal and depth (after Rousselle et al. 2012 and Bitterli et
//! al. 2016). `fast` takes one mean, whose weights come from the noisy colour itself.
//!
//! All values are computed pixel by pixel in contract arithmetic, so all machines agree to the last bit.

mod fireflies;
mod guide;
mod input;
mod mean;
mod neighbors;
mod noise;
#[cfg(any(unix, windows))]
mod oidn;
mod planes;
mod regression;

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::image::Image;
use crate::math::Real;
use crate::simd::{Float, LANES};
use fireflies::Color;
use guide::{Guide, numbers};
use input::{Input, Layers};
use neighbors::Neighbors;
use planes::{Plane, Size, Window, difference, squares};

/// Elsewhere, no library can be loaded.
#[cfg(not(any(unix, windows)))]
mod oidn {
    use super::*;

    pub(super) fn version() -> Result<String> {
        Err(Error::Resource("this system cannot load Open Image Denoise".to_owned()))
    }

    pub(super) fn denoised<const N: usize>(
        _: &Image,
        _: [&[[f32; 3]]; N],
    ) -> Result<[Vec<[f32; 3]>; N]> {
        version().map(|_| [(); N].map(|()| Vec::new()))
    }
}

/// How an image is denoised.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Denoise {
    /// About a tenth of a second of one core per million pixels. One sample per pixel is enough.
    Fast,
    /// About a second of one core per million pixels. Needs the layers `color_even` and `color_odd`.
    #[default]
    Good,
    /// With Open Image Denoise 2, if it is installed: about three seconds of one core per million pixels, and not the same
    /// bits on all machines. One sample per pixel is enough. Its library is looked for where the environment variable
    /// `PTFAST_OIDN` says, a file or a folder, and otherwise where the system looks for libraries.
    Oidn,
}

names! {
    pub Denoise:
    Fast = "fast",
    Good = "good",
    Oidn = "oidn",
}

impl Denoise {
    /// The version of the library that it needs, if it needs one.
    ///
    /// # Errors
    /// [`Error::Resource`] if the library cannot be used, with the reason.
    pub fn library(self) -> Result<Option<String>> {
        match self {
            Self::Fast | Self::Good => Ok(None),
            Self::Oidn => oidn::version().map(Some),
        }
    }
}

/// The mean by the noisy colour itself.
const FAST: Neighbors =
    Neighbors { steps: &[-2, -1, 0, 1, 2], within: 5, feature: 1.0, deviations: 1.5 };
/// The means of each half by the other one.
const HALVES: Neighbors = Neighbors {
    steps: &[-5, -3, -2, -1, 0, 1, 2, 3, 5],
    within: 34,
    feature: 1.0,
    deviations: 1.0,
};
/// The regression by the means of both halves.
const FITTED: Neighbors = Neighbors {
    steps: &[-6, -4, -3, -2, -1, 0, 1, 2, 3, 4, 6],
    within: 40,
    feature: 4.0,
    deviations: 2.0,
};
/// How many pixels around it the guide of a pixel sees: its own, or what the variance is the mean of.
const GUIDE: usize = 3;
/// Pixels around it on which the result of a pixel depends. Fireflies need one more.
const FAST_HALO: usize = 1 + 2 + FAST.reach();
const GOOD_HALO: usize = 1 + GUIDE + HALVES.reach() + GUIDE + FITTED.reach();
/// Standard deviation of means that are equal as far as anyone can see, on the scale of [`Input::scaled`].
const VISIBLE: f32 = 0.005;

impl Image {
    /// The image without noise, and with what it was as the layer `noisy`.
    ///
    /// The layers `albedo`, `normal` and `depth` tell surfaces apart. They, the colour and their halves, such as
    /// `albedo_even`, are those of [`Layer`](crate::Layer); missing layers do not count. If one half of the colour is black,
    /// because there is only one sample, `good` is the same as `fast`. Negative colours become 0, and alpha and all
    /// other layers do not change.
    ///
    /// # Errors
    /// [`Error::Usage`] if [`Denoise::Good`] lacks the halves of the colour, [`Error::Resource`] if [`Denoise::Oidn`]
    /// lacks its library or fails.
    pub fn denoised(self, quality: Denoise) -> Result<Self> {
        if self.pixels().is_empty() {
            return Ok(self);
        }
        let has = |name| self.layer(name).is_some();
        if quality == Denoise::Good && !(has("color_even") && has("color_odd")) {
            let message = "the image lacks the layers color_even and color_odd, \
                           which denoising `good` needs: use `fast`";
            return Err(Error::Usage(message.to_owned()));
        }
        let pixels = match quality {
            Denoise::Oidn => oidn::denoised(&self, [self.pixels()]).map(|[pixels]| pixels)?,
            Denoise::Fast | Denoise::Good => {
                let denoise = |input: &Input| filtered(input, [&input.color]);
                tiled(&Layers::new(&self, quality), denoise).into_flattened()
            }
        };
        Ok(self.replaced(pixels, "noisy"))
    }
}

/// Denoises tile by tile. Each tile has its part of the image, and pixels around it on which the result depends.
fn tiled<const N: usize>(
    layers: &Layers,
    denoise: impl Fn(&Input) -> [Color; N] + Sync,
) -> Vec<[[f32; 3]; N]> {
    let size = match layers.quality {
        Denoise::Good => [256, 128],
        _ => [256, 64],
    };
    tiled_by(layers, size, denoise)
}

fn tiled_by<const N: usize>(
    layers: &Layers,
    [wide, high]: [usize; 2],
    denoise: impl Fn(&Input) -> [Color; N] + Sync,
) -> Vec<[[f32; 3]; N]> {
    let [width, height] = layers.size;
    let halo = match layers.quality {
        Denoise::Good => GOOD_HALO,
        _ => FAST_HALO,
    };
    let mut pixels = vec![[[0.0; 3]; N]; width * height];
    pixels.par_chunks_mut(high * width).enumerate().for_each(|(band, pixels)| {
        let y = band * high;
        let high = pixels.len() / width;
        let tiles: Vec<(usize, [Color; N])> = (0..width.div_ceil(wide))
            .into_par_iter()
            .map(|tile| {
                let x = tile * wide;
                let columns = (wide.min(width - x) + 2 * halo).next_multiple_of(LANES);
                let size = Size { width: columns, height: high + 2 * halo };
                let [left, top] = [x, y].map(|first| first as isize - halo as isize);
                let window = Window { image: layers.size, left, top, size };
                (x, denoise(&Input::new(layers, window)))
            })
            .collect();
        for (x, colors) in tiles {
            for (n, color) in colors.iter().enumerate() {
                for (row, pixels) in pixels.chunks_exact_mut(width).enumerate() {
                    let [red, green, blue] = color.each_ref().map(|c| &c.row(row + halo)[halo..]);
                    let colors = red.iter().zip(green).zip(blue).take(wide);
                    for (pixel, ((&red, &green), &blue)) in pixels[x..].iter_mut().zip(colors) {
                        pixel[n] = [red, green, blue].map(|x| x.most(0.0));
                    }
                }
            }
        }
    });
    // Waiting for threads that do other work could last long.
    rayon::spawn_broadcast(|_| planes::forget_spare());
    pixels
}

/// Denoises each of `colors` with the same weights.
fn filtered<const N: usize>(input: &Input, colors: [&Color; N]) -> [Color; N] {
    match input.layers.quality {
        Denoise::Good => good(input, colors),
        _ => fast(input, colors),
    }
}

fn average([a, b]: &[Color; 2]) -> Color {
    Plane::compute(a[0].size(), |i| {
        [0, 1, 2].map(|c: usize| (a[c].at(i) + b[c].at(i)) * Float::splat(0.5))
    })
}

fn good<const N: usize>(input: &Input, colors: [&Color; N]) -> [Color; N] {
    let halves = input.limited_halves();
    let [even, odd] = halves.each_ref().map(|half| numbers(&input.scaled(half)));
    let noise = squares(&difference(&even, &odd), 0.5).blurred::<3>();
    let guides = [&odd, &even].map(|planes| Guide { planes, noise: &noise });
    let inset = FITTED.reach() + GUIDE;
    let halves = mean::means(&input.features, guides, halves.each_ref(), &HALVES, inset);
    let [even, odd] = halves.each_ref().map(|half| numbers(&input.scaled(half)));
    let noise = squares(&difference(&even, &odd), 0.25).blurred::<2>();
    let visible = Float::splat(3.0 * VISIBLE * VISIBLE);
    let [noise] = Plane::compute(noise.size(), |i| [noise.at(i) + visible]);
    let planes = numbers(&input.scaled(&average(&halves)));
    let guide = Guide { planes: &planes, noise: &noise };
    colors.map(|color| regression::fitted(&input.features, guide, color, &FITTED, GOOD_HALO))
}

fn fast<const N: usize>(input: &Input, colors: [&Color; N]) -> [Color; N] {
    let color = input.scaled(&input.color);
    let noise = match &input.halves {
        Some(halves) => squares(&numbers(&input.difference(halves)), 0.25),
        // Without halves, what differs from the neighbours is taken for noise.
        None => squares(&difference(&color, &color.each_ref().map(Plane::blurred::<1>)), 0.25),
    };
    let guide = Guide { planes: &numbers(&color), noise: &noise.blurred::<2>() };
    mean::means(&input.features, [guide; N], colors, &FAST, FAST_HALO)
}

#[cfg(test)]
mod tests;
