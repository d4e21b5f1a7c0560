//! Tests of the denoiser as a whole.

use super::*;
use crate::image::ImageLayer;
use crate::math::Stream;

const WIDTH: u32 = 70;
const HEIGHT: u32 = 60;
/// What is our own, and therefore promises something.
const OWN: [Denoise; 2] = [Denoise::Fast, Denoise::Good];

/// An image whose two halves have the colour `color` with noise of this relative deviation.
fn noisy(color: impl Fn(u32, u32) -> [f32; 3], deviation: f32) -> Image {
    image_of(|x, y, random| {
        let mut factor = || 1.0 + 3f32.sqrt() * deviation * (2.0 * random.uniform() - 1.0);
        color(x, y).map(|value| value * factor())
    })
}

/// An image of two halves.
fn image_of(mut color: impl FnMut(u32, u32, &mut Stream) -> [f32; 3]) -> Image {
    let mut random = Stream::new(3);
    let mut half = || -> Vec<[f32; 3]> {
        let places = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
        places.map(|(x, y)| color(x, y, &mut random)).collect()
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
    for quality in OWN {
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
    let texture = |x: u32, y: u32| [if (x / 3 + y / 3).is_multiple_of(2) { 0.3 } else { 0.5 }; 3];
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
    for (k, wild) in
        [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -5.0, f32::MAX, 1e20].into_iter().enumerate()
    {
        layers[k % 2].values[900 + 10 * k] = [wild; 3];
    }
    layers.push(layer("albedo", vec![[f32::NAN; 3]; (WIDTH * HEIGHT) as usize]));
    layers.push(layer("depth", vec![[f32::MAX; 3]; (WIDTH * HEIGHT) as usize]));
    let mut pixels = image.pixels().to_vec();
    (pixels[500], layers[0].values[500]) = ([f32::INFINITY; 3], [f32::INFINITY; 3]);
    (pixels[2000], layers[1].values[2000]) = ([f32::NAN; 3], [f32::NAN; 3]);
    image = Image::from_pixels(WIDTH, HEIGHT, pixels).with_layers(layers);
    for quality in OWN {
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
    for quality in OWN {
        let layers = Layers::new(&image, quality);
        let denoise = |input: &Input| filtered(input, [&input.color]);
        let [whole, tiles] = [[80, 60], [24, 7]].map(|size| tiled_by(&layers, size, denoise));
        assert!(whole == tiles, "{quality:?}");
    }
}

/// Stripes whose brightness differs by a factor, without features: shadows, for example. For this factor and noise, at
/// least so much of the contrast must remain with `fast` and with `good`.
#[test]
fn edges_keep_their_contrast() {
    for (factor, noise, least) in [
        (1.2, 0.0, [0.99, 0.99]),
        (1.2, 0.1, [0.55, 0.9]),
        (1.5, 0.1, [0.97, 0.97]),
        (1.5, 0.3, [0.42, 0.78]),
        (4.0, 0.3, [0.97, 0.97]),
        (4.0, 1.0, [0.3, 0.5]),
    ] {
        let stripes = |x: u32, _| [if (x / 8).is_multiple_of(2) { 1.0 } else { factor }; 3];
        for (quality, least) in OWN.into_iter().zip(least) {
            let image = noisy(stripes, noise).denoised(quality).unwrap();
            let mean = |column: u32| {
                let column = (0..HEIGHT).map(|y| f64::from(pixel(&image, column, y)[0]));
                column.sum::<f64>() / f64::from(HEIGHT)
            };
            let edges = (8..WIDTH - 8).step_by(8).map(|x| (mean(x) - mean(x - 1)).abs());
            let step = edges.clone().sum::<f64>() / edges.count() as f64;
            let contrast = step / f64::from(factor - 1.0);
            assert!(
                (least..1.03).contains(&contrast),
                "{quality:?}: {contrast} of a factor of {factor} in noise of {noise}"
            );
        }
    }
}

#[test]
fn the_error_that_is_left_is_estimated() {
    let color = |x: u32, y: u32| [if x < 30 { 0.2 } else { 0.5 + 0.01 * (y % 20) as f32 }; 3];
    for deviation in [0.1, 0.5] {
        let image = noisy(color, deviation);
        for quality in OWN {
            let estimate = image.denoised_noise(quality).unwrap().unwrap();
            let truth = f64::from(error(&image.clone().denoised(quality).unwrap(), color));
            let ratio = estimate / truth;
            assert!((0.9..1.4).contains(&ratio), "{quality:?}: {estimate} for {truth}");
        }
    }
    let without = Image::from_pixels(2, 2, vec![[1.0; 3]; 4]);
    assert_eq!(without.denoised_noise(Denoise::Fast).unwrap(), None);
}

/// Exponential noise has no fireflies, although some pixels are several times as bright as others.
#[test]
fn strong_noise_keeps_its_light() {
    let image = image_of(|_, _, random| [-crate::math::powers::ln(1.0 - random.uniform()); 3]);
    for quality in OWN {
        let light = image.clone().denoised(quality).unwrap().mean()[0] / image.mean()[0];
        assert!((0.98..1.02).contains(&light), "{quality:?}: {light}");
    }
}

#[test]
fn black_images_and_halves_without_samples_are_denoised() {
    let black = vec![[0.0; 3]; 4];
    let layers =
        |odd: f32| vec![layer("color_even", black.clone()), layer("color_odd", vec![[odd; 3]; 4])];
    let image = Image::from_pixels(2, 2, black.clone()).with_layers(layers(0.0));
    assert_eq!(image.denoised(Denoise::Good).unwrap().pixels(), black);
    let half = Image::from_pixels(2, 2, vec![[3.0; 3]; 4]).with_layers(layers(3.0));
    let [good, fast] = OWN.map(|quality| half.clone().denoised(quality).unwrap());
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
