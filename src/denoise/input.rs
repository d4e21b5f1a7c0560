//! What a denoiser knows of an image: colours, and features that tell surfaces apart.

use super::Denoise;
use super::fireflies::{Color, limited, limited_half};
use super::planes::{Plane, Window, difference, squares};
use crate::image::Image;
use crate::math::{Real, Word};
use crate::simd::{Float, Int};

/// Brighter colours are limited, so that sums stay finite.
const BRIGHTEST: f32 = 1e30;
/// Features beyond this are taken for 0, so that their squares stay finite.
const FARTHEST: f32 = 1e15;
/// Brighter pixels count as this bright for the mean of the picture, so that the sun does not decide it.
const SUN: f32 = 65504.0;
/// Colours are compared on a logarithmic scale that is linear below this part of the mean.
const LINEAR: f32 = 0.02;
/// The bits of 1.
const ONE: u32 = 0x3F80_0000;
/// Channels of features: three for albedo and normal, and one for depth.
pub(super) const FEATURES: usize = 7;
/// Differences of features are relative to at least the root of this: a tenth of albedos and normals.
const LEAST: f32 = 0.01;
/// The same for depths, as a part of the depth.
const LEAST_DEPTH: f32 = 0.01;

/// The numbers of a layer, pixel by pixel.
type Values<'a> = &'a [[f32; 3]];
/// A layer, and one half of its samples.
type Feature<'a> = Option<(Values<'a>, Option<Values<'a>>)>;

/// The layers of an image that are used.
pub(super) struct Layers<'a> {
    pub(super) quality: Denoise,
    pub(super) size: [usize; 2],
    color: Values<'a>,
    pub(super) halves: Option<[Values<'a>; 2]>,
    albedo: Feature<'a>,
    normal: Feature<'a>,
    depth: Feature<'a>,
    /// Where the logarithmic scale begins.
    unit: f32,
}

impl<'a> Layers<'a> {
    /// The layers of `image` that this quality uses. Without two halves, `Good` becomes `Fast`.
    pub(super) fn new(image: &'a Image, quality: Denoise) -> Self {
        let layer = |name: &str| image.layer(name).map(|layer| layer.values());
        let halves = layer("color_even").zip(layer("color_odd"));
        // With one sample, a half has none and is black.
        let known = |half: Values| half.iter().flatten().any(|&x| x != 0.0);
        let halves = halves.filter(|(even, odd)| known(even) == known(odd));
        let quality = if halves.is_some() { quality } else { Denoise::Fast };
        let by_halves = quality == Denoise::Good;
        let feature =
            |name, half| layer(name).map(|values| (values, layer(half).filter(|_| by_halves)));
        let color = image.pixels();
        let bright = |&x: &f32| f64::from(valid(x).clamp(0.0, SUN));
        // Some rows tell enough.
        let rows = color.chunks(image.width() as usize).step_by(4);
        let values = || rows.clone().flatten().flatten();
        let mean = values().map(bright).sum::<f64>() / values().count() as f64;
        Self {
            quality,
            size: [image.width(), image.height()].map(|size| size as usize),
            color,
            halves: halves.map(|(even, odd)| [even, odd]),
            albedo: feature("albedo", "albedo_even"),
            normal: feature("normal", "normal_even"),
            depth: feature("depth", "depth_even"),
            unit: (f64::from(LINEAR) * mean).max(1e-30) as f32,
        }
    }
}

/// Values of surfaces. Channels that an image lacks are 0.
pub(super) struct Features {
    pub(super) channels: [Plane; FEATURES],
    /// For each of albedo, normal and depth, one by what counts as a difference: the slope of a surface does not.
    pub(super) roots: [Plane; 3],
}

/// The input of a denoiser in one window.
pub(super) struct Input<'a> {
    pub(super) layers: &'a Layers<'a>,
    window: Window,
    /// The colour, without fireflies.
    pub(super) color: Color,
    /// Two independent halves of the samples, if the image has them.
    pub(super) halves: Option<[Color; 2]>,
    pub(super) features: Features,
}

/// `x`, or `BRIGHTEST` if it is more, and 0 for what is no light.
fn valid(x: f32) -> f32 {
    if x > BRIGHTEST {
        BRIGHTEST
    } else if x > -BRIGHTEST {
        x
    } else {
        0.0
    }
}

/// The square of the smaller slope to each side.
#[inline(always)]
fn slope(plane: &Plane, index: usize) -> Float {
    let along = |dx: isize, dy: isize| {
        let (here, there) = (plane.near(index, -dx, -dy), plane.near(index, dx, dy));
        let step = (plane.at(index) - here).abs().min((there - plane.at(index)).abs());
        step * step
    };
    along(1, 0) + along(0, 1)
}

/// One by what counts as a difference of a feature: `least`, and its slope or its noise.
fn root<const N: usize>(
    channels: &[Plane; N],
    half: Option<[Plane; N]>,
    least: impl Fn(usize) -> Float,
) -> Plane {
    let noise = half.map(|half| squares(&difference(channels, &half), 1.0).blurred::<1>());
    let [root] = Plane::compute(channels[0].size(), |i| {
        let slopes = channels.iter().map(|channel| slope(channel, i));
        let steep = slopes.fold(Float::splat(0.0), |sum, slope| sum + slope);
        let spread = noise.as_ref().map_or(steep, |noise| steep.max(noise.at(i)));
        [Float::splat(1.0) / (least(i) + spread).sqrt()]
    });
    root
}

/// The channels of a feature, and the same for half of its samples.
fn load<const N: usize>(feature: Feature, window: &Window) -> ([Plane; N], Option<[Plane; N]>) {
    let finite = |x: f32| if x.abs() < FARTHEST { x } else { 0.0 };
    match feature {
        Some((values, half)) => {
            (window.load(values, finite), half.map(|half| window.load(half, finite)))
        }
        None => ([(); N].map(|()| Plane::zeros(window.size)), None),
    }
}

impl Features {
    fn new(layers: &Layers, window: &Window) -> Self {
        let (albedo, albedo_half) = load(layers.albedo, window);
        let (normal, normal_half) = load(layers.normal, window);
        let (depth, depth_half) = load::<1>(layers.depth, window);
        let tenth = |_| Float::splat(LEAST);
        let part = |i| {
            let depth = depth[0].at(i) * Float::splat(LEAST_DEPTH);
            depth * depth + Float::splat(1e-12)
        };
        let roots = [
            root(&albedo, albedo_half, tenth),
            root(&normal, normal_half, tenth),
            root(&depth, depth_half, part),
        ];
        let ([a, b, c], [d, e, f], [g]) = (albedo, normal, depth);
        Self { channels: [a, b, c, d, e, f, g], roots }
    }
}

impl<'a> Input<'a> {
    /// The part of `layers` that `window` shows.
    pub(super) fn new(layers: &'a Layers, window: Window) -> Self {
        let halves = layers.halves.map(|halves| halves.map(|half| window.load(half, valid)));
        let color = limited(&window.load(layers.color, valid), halves.as_ref());
        Self { color, halves, features: Features::new(layers, &window), layers, window }
    }

    /// Both halves without fireflies.
    pub(super) fn limited_halves(&self) -> [Color; 2] {
        let [even, odd] = self.halves.as_ref().expect("both halves");
        [limited_half(even, odd), limited_half(odd, even)]
    }

    /// The colour on the scale on which colours are compared.
    pub(super) fn scaled(&self, color: &Color) -> Color {
        let scale = Scale::new(self.layers.unit);
        Plane::compute(self.window.size, |i| [0, 1, 2].map(|c: usize| scale.of(color[c].at(i))))
    }

    /// The difference of two colours on that scale.
    pub(super) fn difference(&self, [a, b]: &[Color; 2]) -> Color {
        let scale = Scale::new(self.layers.unit);
        Plane::compute(self.window.size, |i| {
            [0, 1, 2].map(|c: usize| scale.of(a[c].at(i)) - scale.of(b[c].at(i)))
        })
    }
}

/// The scale on which colours are compared.
#[derive(Clone, Copy)]
struct Scale {
    factor: Float,
}

impl Scale {
    /// The scale is logarithmic, and linear below `unit`.
    fn new(unit: f32) -> Self {
        Self { factor: Float::splat(1.0 / unit) }
    }

    /// The bits of a number are close enough to its logarithm, with a straight line for each octave.
    #[inline(always)]
    fn of(self, x: Float) -> Float {
        let x = x.max(Float::splat(0.0)) * self.factor + Float::splat(1.0);
        let octaves = Float::from_word(x.to_bits().wrapping_sub(Int::splat(ONE)));
        octaves * Float::splat(std::f32::consts::LN_2 / 8_388_608.0)
    }
}
