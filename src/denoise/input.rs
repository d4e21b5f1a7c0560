//! What a denoiser knows of an image: colours, and features that tell surfaces apart.

use super::fireflies::{Color, limited};
use super::planes::{Plane, Size};
use crate::image::Image;
use crate::math::Real;
use crate::math::powers::ln;
use crate::simd::Float;

/// Brighter colours are limited, so that sums stay finite.
const BRIGHTEST: f32 = 1e30;
/// Features beyond this are taken for 0, so that their squares stay finite.
const FARTHEST: f32 = 1e15;
/// Brighter pixels count as this bright for the mean of the picture, so that the sun does not decide it.
const SUN: f32 = 65504.0;
/// Colours are compared on a logarithmic scale that is linear below this part of the mean.
const LINEAR: f32 = 0.02;
/// Differences of features are relative to at least the root of this: a tenth of albedos and normals.
const LEAST: f32 = 0.01;
/// The same for depths, as a part of the depth.
const LEAST_DEPTH: f32 = 0.01;

/// A value of surfaces, such as the normal.
pub(super) struct Feature {
    /// One plane for each channel.
    pub(super) channels: Vec<Plane>,
    /// One by the square of what counts as a difference: the slope of a surface and the noise of a pixel do not.
    pub(super) scale: Plane,
}

/// The input of a denoiser.
pub(super) struct Input {
    pub(super) size: Size,
    /// The colour, without fireflies.
    pub(super) color: Color,
    /// Two independent halves of the samples, if the image has them.
    pub(super) halves: Option<[Color; 2]>,
    pub(super) features: Vec<Feature>,
    /// Where the logarithmic scale begins.
    unit: f32,
}

/// `x`, or the nearest number whose magnitude is at most `BRIGHTEST`; 0 for NaN.
fn valid(x: f32) -> f32 {
    if x.is_nan() { 0.0 } else { x.clamp(-BRIGHTEST, BRIGHTEST) }
}

/// `values[pixel]` in three planes, without non-finite numbers. Pixel filters may make some of them negative.
fn color(size: Size, values: &[[f32; 3]]) -> Color {
    Plane::of_rows(size, |pixel| values[pixel].map(valid))
}

/// `whole`, scaled down as the halves were. Its samples may be more than theirs, or all in one of them.
fn without_excess(whole: &Color, raw: &[Color; 2], limited: &[Color; 2]) -> Color {
    let sum = |halves: &[Color; 2], c: usize, i: usize| halves[0][c].at(i) + halves[1][c].at(i);
    Plane::compute(whole[0].size(), |i| {
        [0, 1, 2].map(|c: usize| {
            let (before, after) = (sum(raw, c, i), sum(limited, c, i));
            let smaller = before.abs().gt(after.abs());
            let factor = smaller.select(after / before, Float::splat(1.0));
            whole[c].at(i) * factor
        })
    })
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

impl Feature {
    /// `halves` has the channels of one half of the samples, if they are known.
    fn new(channels: Vec<Plane>, halves: Option<Vec<Plane>>, is_depth: bool) -> Self {
        let size = channels[0].size();
        let sum = |value: &dyn Fn(usize) -> Float| {
            (1..channels.len()).fold(value(0), |sum, channel| sum + value(channel))
        };
        let noise = halves.map(|halves| {
            let [squares] = Plane::compute(size, |i| {
                [sum(&|c| {
                    let difference = channels[c].at(i) - halves[c].at(i);
                    difference * difference
                })]
            });
            squares.blurred::<1>()
        });
        let [scale] = Plane::compute(size, |i| {
            let least = if is_depth {
                let depth = channels[0].at(i) * LEAST_DEPTH;
                depth * depth + 1e-12
            } else {
                Float::splat(LEAST)
            };
            let steep = sum(&|c| slope(&channels[c], i));
            let spread = noise.as_ref().map_or(steep, |noise| steep.max(noise.at(i)));
            [Float::splat(1.0) / (least + spread)]
        });
        Self { channels, scale }
    }

    /// How much the feature differs at `index` and its neighbour at (`dx`, `dy`).
    #[inline(always)]
    pub(super) fn difference(&self, index: usize, dx: isize, dy: isize) -> Float {
        let mut sum = Float::splat(0.0);
        for channel in &self.channels {
            let difference = channel.at(index) - channel.near(index, dx, dy);
            sum = sum + difference * difference;
        }
        sum * self.scale.at(index).min(self.scale.near(index, dx, dy))
    }
}

impl Input {
    /// The input that the layers of `image` give.
    pub(super) fn new(image: &Image) -> Self {
        let size = Size { width: image.width() as usize, height: image.height() as usize };
        let layer = |name: &str| image.layer(name).map(|layer| layer.values());
        let whole = color(size, image.pixels());
        let pair = layer("color_even").zip(layer("color_odd"));
        // With one sample, a half has none and is black.
        let known = |half: &[[f32; 3]]| half.iter().flatten().any(|&x| x != 0.0);
        let pair = pair.filter(|(even, odd)| known(even) == known(odd));
        let raw = pair.map(|(even, odd)| [color(size, even), color(size, odd)]);
        let halves = raw
            .as_ref()
            .map(|[even, odd]| [limited(even, Some(odd), size), limited(odd, Some(even), size)]);
        let color = match raw.zip(halves.as_ref()) {
            None => limited(&whole, None, size),
            Some((raw, halves)) => without_excess(&whole, &raw, halves),
        };
        let mut features = Vec::new();
        for (name, even, channels) in
            [("albedo", "albedo_even", 3), ("normal", "normal_even", 3), ("depth", "depth_even", 1)]
        {
            let finite = |x: f32| if x.abs() < FARTHEST { x } else { 0.0 };
            let planes = |values: &[[f32; 3]]| -> [Plane; 3] {
                Plane::of_rows(size, |pixel| values[pixel].map(finite))
            };
            let channels = |values| planes(values).into_iter().take(channels).collect();
            if let Some(values) = layer(name) {
                let even = layer(even).map(channels);
                features.push(Feature::new(channels(values), even, name == "depth"));
            }
        }
        let values = image.pixels().iter().flatten();
        let sum: f64 = values.map(|&x| f64::from(valid(x).clamp(0.0, SUN))).sum();
        let mean = sum / (3 * image.pixels().len()) as f64;
        let unit = (f64::from(LINEAR) * mean).max(1e-30) as f32;
        Self { size, color, halves, features, unit }
    }

    /// The colour on the scale on which colours are compared.
    pub(super) fn scaled(&self, color: &Color) -> Color {
        let factor = Float::splat(1.0 / self.unit);
        let scaled = |x: Float| ln(x.max(Float::splat(0.0)) * factor + Float::splat(1.0));
        Plane::compute(self.size, |i| [0, 1, 2].map(|c: usize| scaled(color[c].at(i))))
    }
}
