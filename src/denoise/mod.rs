//! The denoiser: removes the noise of an image with the help of its layers.
//!
//! `good` compares patches of colours in one half of the samples, and with these weights takes means of the other half.
//! So noise does not choose the pixels whose mean it would spoil. The result of both halves together then
//! gives the weights of a regression on albedo, normal and depth (after Rousselle et al. 2012 and Bitterli et
//! al. 2016). `fast` takes one mean, whose weights come from the noisy colour itself.
//!
//! All values are computed pixel by pixel in contract arithmetic, so all machines agree to the last bit.

mod fireflies;
mod input;
mod mean;
mod planes;
mod regression;
mod weights;

use crate::error::{Error, Result};
use crate::image::Image;
use crate::math::Real;
use crate::simd::Float;
use fireflies::Color;
use input::Input;
use planes::Plane;
use weights::{Guide, Strengths};

/// How thoroughly an image is denoised.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Denoise {
    /// About half a second of one core per million pixels. One sample per pixel is enough.
    Fast,
    /// About two seconds of one core per million pixels. Needs the layers `color_even` and `color_odd`.
    #[default]
    Good,
}

names! {
    pub Denoise:
    Fast = "fast",
    Good = "good",
}

/// The mean by the noisy colour itself.
const FAST: Strengths = Strengths { steps: &[-3, -2, -1, 0, 1, 2, 3], feature: 1.5 };
/// The means of each half by the other one.
const HALVES: Strengths = Strengths { steps: &[-5, -3, -2, -1, 0, 1, 2, 3, 5], feature: 1.5 };
/// The regression by the means of both halves.
const FITTED: Strengths =
    Strengths { steps: &[-7, -5, -3, -2, -1, 0, 1, 2, 3, 5, 7], feature: 3.0 };
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
        let input = Input::new(&self);
        let color = match (quality, &input.halves) {
            (Denoise::Good, Some(halves)) => good(&input, halves),
            _ => fast(&input),
        };
        let place = |pixel: usize| (pixel % input.size.width, pixel / input.size.width);
        let pixels = (0..input.size.width * input.size.height).map(place);
        let pixels = pixels.map(|(x, y)| color.each_ref().map(|plane| plane.pixel(x, y).most(0.0)));
        Ok(self.replaced(pixels.collect(), "noisy"))
    }
}

/// Half the sum of the squared differences of two colours, averaged over their neighbours.
fn variance<const REACH: isize>(a: &Color, b: &Color, factor: f32) -> Plane {
    let [squares] = Plane::compute(a[0].size(), |i| {
        let square = |c: usize| {
            let difference = a[c].at(i) - b[c].at(i);
            difference * difference
        };
        [(square(0) + square(1) + square(2)) * Float::splat(factor)]
    });
    squares.blurred::<REACH>()
}

fn average(a: &Color, b: &Color) -> Color {
    Plane::compute(a[0].size(), |i| {
        [0, 1, 2].map(|c: usize| (a[c].at(i) + b[c].at(i)) * Float::splat(0.5))
    })
}

fn good(input: &Input, [even, odd]: &[Color; 2]) -> Color {
    let scaled = [even, odd].map(|half| input.scaled(half));
    let noise = variance::<3>(&scaled[0], &scaled[1], 0.5);
    let guides = scaled.map(|color| Guide::new(color, noise.clone(), 0.6));
    let pairs = [(&guides[1], even), (&guides[0], odd)];
    let [a, b, c, d, e, f] = mean::means(input, &pairs, &HALVES);
    let [even, odd] = [[a, b, c], [d, e, f]];
    let scaled = [&even, &odd].map(|half| input.scaled(half));
    let noise = variance::<2>(&scaled[0], &scaled[1], 0.25);
    let [variance] =
        Plane::compute(input.size, |i| [noise.at(i) + Float::splat(3.0 * VISIBLE * VISIBLE)]);
    let guide = Guide::new(input.scaled(&average(&even, &odd)), variance, 1.4);
    regression::fitted(input, &guide, &FITTED)
}

fn fast(input: &Input) -> Color {
    let color = input.scaled(&input.color);
    let variance = match &input.halves {
        Some(halves) => {
            let [even, odd] = halves.each_ref().map(|half| input.scaled(half));
            variance::<3>(&even, &odd, 0.25)
        }
        // Without halves, what differs from the neighbours is taken for noise.
        None => variance::<3>(&color, &color.each_ref().map(Plane::blurred::<1>), 1.0),
    };
    let guide = Guide::new(color, variance, 0.8);
    mean::means(input, &[(&guide, &input.color)], &FAST)
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
        // The same image, moved by three columns and five rows: tiles begin elsewhere.
        let color = |x: u32, y: u32| [0.5 + 0.3 * ((x * 7 + y * 3) % 11) as f32 / 11.0; 3];
        let here = noisy(color, 0.3);
        let moved = |values: &[[f32; 3]]| -> Vec<[f32; 3]> {
            let places = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
            let from = |(x, y)| ((y + 5) % HEIGHT * WIDTH + (x + 3) % WIDTH) as usize;
            places.map(|place| values[from(place)]).collect()
        };
        let layers = here.layers().iter().map(|l| layer(l.name, moved(&l.values))).collect();
        let there = Image::from_pixels(WIDTH, HEIGHT, moved(here.pixels())).with_layers(layers);
        let [here, there] = [here, there].map(|image| image.denoised(Denoise::Good).unwrap());
        for (x, y) in (28..32).flat_map(|y| (26..40).map(move |x| (x, y))) {
            assert_eq!(pixel(&here, x, y), pixel(&there, x - 3, y - 5), "({x}, {y})");
        }
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
