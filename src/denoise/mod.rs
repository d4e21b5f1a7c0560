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
mod planes;
mod regression;

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::image::Image;
use crate::math::Real;
use crate::simd::{Float, LANES};
use fireflies::{Color, limited_half};
use guide::{Guide, numbers};
use input::{Input, Layers};
use neighbors::Neighbors;
use planes::{Plane, Size, Window, difference, squares};

/// How thoroughly an image is denoised.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Denoise {
    /// About a tenth of a second of one core per million pixels. One sample per pixel is enough.
    Fast,
    /// About a second of one core per million pixels. Needs the layers `color_even` and `color_odd`.
    #[default]
    Good,
}

names! {
    pub Denoise:
    Fast = "fast",
    Good = "good",
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
    /// [`Error::Usage`] if [`Denoise::Good`] lacks the halves of the colour.
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
        let layers = Layers::new(&self, quality == Denoise::Good);
        let pixels = match quality {
            Denoise::Good if layers.halves.is_some() => tiled(&layers, [256, 128], GOOD_HALO, good),
            _ => tiled(&layers, [256, 64], FAST_HALO, fast),
        };
        Ok(self.replaced(pixels, "noisy"))
    }
}

/// Denoises tile by tile. Each tile has its part of the image, and `halo` pixels more at each side.
fn tiled(
    layers: &Layers,
    [wide, high]: [usize; 2],
    halo: usize,
    denoise: impl Fn(&Input) -> Color + Sync,
) -> Vec<[f32; 3]> {
    let [width, height] = layers.size;
    let mut pixels = vec![[0.0; 3]; width * height];
    pixels.par_chunks_mut(high * width).enumerate().for_each(|(band, pixels)| {
        let y = band * high;
        let high = pixels.len() / width;
        let tiles: Vec<(usize, Color)> = (0..width.div_ceil(wide))
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
        for (x, color) in tiles {
            for (row, pixels) in pixels.chunks_exact_mut(width).enumerate() {
                let [red, green, blue] = color.each_ref().map(|c| &c.row(row + halo)[halo..]);
                let colors = red.iter().zip(green).zip(blue).take(wide);
                for (pixel, ((&red, &green), &blue)) in pixels[x..].iter_mut().zip(colors) {
                    *pixel = [red, green, blue].map(|x| x.most(0.0));
                }
            }
        }
    });
    // Waiting for threads that do other work could last long.
    rayon::spawn_broadcast(|_| planes::forget_spare());
    pixels
}

fn average([a, b]: &[Color; 2]) -> Color {
    Plane::compute(a[0].size(), |i| {
        [0, 1, 2].map(|c: usize| (a[c].at(i) + b[c].at(i)) * Float::splat(0.5))
    })
}

fn good(input: &Input) -> Color {
    let [even, odd] = input.halves.as_ref().expect("both halves");
    let halves = [limited_half(even, odd), limited_half(odd, even)];
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
    regression::fitted(&input.features, guide, &input.color, &FITTED, GOOD_HALO)
}

fn fast(input: &Input) -> Color {
    let color = input.scaled(&input.color);
    let noise = match &input.halves {
        Some(halves) => squares(&numbers(&input.difference(halves)), 0.25),
        // Without halves, what differs from the neighbours is taken for noise.
        None => squares(&difference(&color, &color.each_ref().map(Plane::blurred::<1>)), 0.25),
    };
    let guide = Guide { planes: &numbers(&color), noise: &noise.blurred::<2>() };
    let [color] = mean::means(&input.features, [guide], [&input.color], &FAST, FAST_HALO);
    color
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::ImageLayer;
    use crate::math::Stream;

    const WIDTH: u32 = 70;
    const HEIGHT: u32 = 60;

    /// An image whose two halves have the colour `color` with noise of this relative deviation.
    fn noisy(color: impl Fn(u32, u32) -> [f32; 3], deviation: f32) -> Image {
        let mut random = Stream::new(3);
        let mut half = || -> Vec<[f32; 3]> {
            let places = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
            let mut factor = || 1.0 + 3f32.sqrt() * deviation * (2.0 * random.uniform() - 1.0);
            places.map(|(x, y)| color(x, y).map(|value| value * factor())).collect()
        };
        let (even, odd) = (half(), half());
        let mean = |(a, b): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|c| (a[c] + b[c]) * 0.5);
        let pixels = even.iter().zip(&odd).map(mean).collect();
        let layers = vec![layer("color_even", even), layer("color_odd", odd)];
        Image::from_pixels(WIDTH, HEIGHT, pixels).with_layers(layers)
    }

    fn layer(name: &'static str, values: Vec<[f32; 3]>) -> ImageLayer {
        ImageLayer { name, channels: &["R", "G", "B"], numbers: false, values }
    }

    fn pixel(image: &Image, x: u32, y: u32) -> [f32; 3] {
        image.pixels()[(y * WIDTH + x) as usize]
    }

    /// Root of the mean squared relative difference to `color`.
    fn error(image: &Image, color: impl Fn(u32, u32) -> [f32; 3]) -> f32 {
        let mut sum = 0.0;
        for (x, y) in (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y))) {
            let (now, right) = (pixel(image, x, y), color(x, y));
            for c in 0..3 {
                let relative = (now[c] - right[c]) / right[c];
                sum += relative * relative;
            }
        }
        (sum / (3 * WIDTH * HEIGHT) as f32).sqrt()
    }

    #[test]
    fn images_without_noise_stay() {
        let constant = |_, _| [0.25, 1.0, 3.0];
        let slope = |x, y| [1.0 + 0.01 * x as f32, 2.0 - 0.01 * y as f32, 1.0];
        for quality in Denoise::ALL {
            let image = noisy(constant, 0.0).denoised(quality).unwrap();
            assert!(error(&image, constant) < 1e-5, "{quality:?}");
            let image = noisy(slope, 0.0).denoised(quality).unwrap();
            assert!(error(&image, slope) < 0.01, "{quality:?}: {}", error(&image, slope));
        }
    }

    #[test]
    fn noise_is_removed_and_light_is_kept() {
        let color = |x: u32, _| [if x < 30 { 0.2 } else { 1.0 }; 3];
        for (quality, gain) in [(Denoise::Fast, 4.0), (Denoise::Good, 6.0)] {
            let before = noisy(color, 0.4);
            let mean = before.mean()[0];
            let (noise, image) = (error(&before, color), before.denoised(quality).unwrap());
            let rest = error(&image, color);
            assert!(gain * rest < noise, "{quality:?}: {noise} to {rest}");
            let light = image.mean()[0] / mean;
            assert!((0.995..1.005).contains(&light), "{quality:?}: {light} times the light");
            // The edge between the two stays.
            let contrast = pixel(&image, 31, 18)[0] - pixel(&image, 28, 18)[0];
            assert!(contrast > 0.72, "{quality:?}: {contrast}");
        }
    }

    #[test]
    fn albedo_keeps_textures() {
        let texture =
            |x: u32, y: u32| [if (x / 3 + y / 3).is_multiple_of(2) { 0.3 } else { 0.5 }; 3];
        let albedo = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| texture(x, y))).collect();
        let image = noisy(texture, 0.5);
        let layers = image.layers().iter().cloned().chain([layer("albedo", albedo)]).collect();
        let with_albedo = image.clone().with_layers(layers);
        let [without, with] =
            [image, with_albedo].map(|i| error(&i.denoised(Denoise::Good).unwrap(), texture));
        assert!(with < 0.2 && 1.5 * with < without, "{with}, without albedo {without}");
    }

    #[test]
    fn wild_numbers_do_not_spread() {
        let mut image = noisy(|_, _| [1.0; 3], 0.1);
        let mut layers = image.layers().to_vec();
        for (k, wild) in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -5.0, f32::MAX, 1e20]
            .into_iter()
            .enumerate()
        {
            layers[k % 2].values[900 + 10 * k] = [wild; 3];
        }
        layers.push(layer("albedo", vec![[f32::NAN; 3]; (WIDTH * HEIGHT) as usize]));
        layers.push(layer("depth", vec![[f32::MAX; 3]; (WIDTH * HEIGHT) as usize]));
        let mut pixels = image.pixels().to_vec();
        (pixels[500], layers[0].values[500]) = ([f32::INFINITY; 3], [f32::INFINITY; 3]);
        (pixels[2000], layers[1].values[2000]) = ([f32::NAN; 3], [f32::NAN; 3]);
        image = Image::from_pixels(WIDTH, HEIGHT, pixels).with_layers(layers);
        for quality in Denoise::ALL {
            let image = image.clone().denoised(quality).unwrap();
            let values = || image.pixels().iter().flatten();
            assert!(values().all(|x| (0.0..4.0).contains(x)), "{quality:?}");
            let wild = values().filter(|x| !(0.8..1.25).contains(*x)).count();
            assert!(wild <= 3 * 20, "{quality:?}: {wild} values");
        }
    }

    #[test]
    fn tiles_leave_no_trace() {
        let color = |x: u32, y: u32| [0.5 + 0.3 * ((x * 7 + y * 3) % 11) as f32 / 11.0; 3];
        let image = noisy(color, 0.3);
        let layers = Layers::new(&image, true);
        let same = |halo: usize, denoise: fn(&Input) -> Color| {
            let [whole, tiles] =
                [[80, 60], [24, 7]].map(|size| tiled(&layers, size, halo, denoise));
            assert!(whole == tiles);
        };
        same(FAST_HALO, fast);
        same(GOOD_HALO, good);
    }

    /// Exponential noise has no fireflies, although some pixels are several times as bright as others.
    #[test]
    fn strong_noise_keeps_its_light() {
        let mut image = noisy(|_, _| [1.0; 3], 0.0);
        let mut random = Stream::new(8);
        let mut half = || -> Vec<[f32; 3]> {
            let mut light = || [-crate::math::powers::ln(1.0 - random.uniform()); 3];
            (0..WIDTH * HEIGHT).map(|_| light()).collect()
        };
        let (even, odd) = (half(), half());
        let mean = |(a, b): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|c| (a[c] + b[c]) * 0.5);
        let pixels: Vec<[f32; 3]> = even.iter().zip(&odd).map(mean).collect();
        let layers = vec![layer("color_even", even), layer("color_odd", odd)];
        image = Image::from_pixels(image.width(), image.height(), pixels).with_layers(layers);
        let before = image.mean()[0];
        for quality in Denoise::ALL {
            let light = image.clone().denoised(quality).unwrap().mean()[0] / before;
            assert!((0.98..1.02).contains(&light), "{quality:?}: {light}");
        }
    }

    #[test]
    fn black_images_and_halves_without_samples_are_denoised() {
        let black = vec![[0.0; 3]; 4];
        let layers = |odd: f32| {
            vec![layer("color_even", black.clone()), layer("color_odd", vec![[odd; 3]; 4])]
        };
        let image = Image::from_pixels(2, 2, black.clone()).with_layers(layers(0.0));
        assert_eq!(image.denoised(Denoise::Good).unwrap().pixels(), black);
        let half = Image::from_pixels(2, 2, vec![[3.0; 3]; 4]).with_layers(layers(3.0));
        let [good, fast] = Denoise::ALL.map(|quality| half.clone().denoised(quality).unwrap());
        assert_eq!(good.pixels(), fast.pixels());
        assert!((2.9..3.1).contains(&good.pixels()[0][0]));
        let again = good.denoised(Denoise::Fast).unwrap();
        assert_eq!(again.layers().iter().filter(|layer| layer.name() == "noisy").count(), 1);
        assert!(Image::new(0, 0).denoised(Denoise::Fast).unwrap().pixels().is_empty());
    }

    #[test]
    fn halves_are_needed_for_good() {
        let image = Image::from_pixels(3, 2, vec![[1.0; 3]; 6]);
        let error = image.clone().denoised(Denoise::Good).unwrap_err().to_string();
        assert!(error.contains("color_even") && error.contains("use `fast`"), "{error}");
        let fast = image.denoised(Denoise::Fast).unwrap();
        assert_eq!(fast.layer("noisy").unwrap().values(), [[1.0; 3]; 6]);
        assert_eq!(
            Image::from_pixels(1, 1, vec![[0.0; 3]]).denoised(Denoise::Fast).unwrap().pixels(),
            [[0.0; 3]]
        );
    }
}
