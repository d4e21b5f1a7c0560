//! Pixel filters: how the samples around a pixel contribute to it, by importance sampling.

use serde::{Deserialize, Serialize};

use crate::checks::Location;
use crate::error::Result;
use crate::math::precise::{exp, sin_cos_degrees};
use crate::math::{Real, Row, Word, whole};

/// A reconstruction filter. The filter of a pixel is the product of two functions, one of the
/// horizontal and one of the vertical distance from the middle of the pixel. Distances are in
/// pixels.
///
/// Each sample belongs to one pixel only, and its position is distributed like the filter, so that
/// neighbouring pixels stay independent (Ernst et al. 2006, "Filter importance sampling").
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
#[non_exhaustive]
pub enum PixelFilter {
    /// The mean over the area of the pixel.
    #[default]
    Box,
    /// Falls linearly to 0.
    Triangle {
        /// Distance at which the filter becomes 0, in [0.1, 16].
        #[serde(default = "PixelFilter::default_triangle_radius")]
        radius: f32,
    },
    /// A Gaussian minus its value at the radius, so that it falls to 0.
    Gaussian {
        /// Distance at which the filter becomes 0, in [0.1, 16].
        #[serde(default = "PixelFilter::default_smooth_radius")]
        radius: f32,
        /// Standard deviation, at least a quarter of the radius and at most 16.
        #[serde(default = "PixelFilter::default_sigma")]
        sigma: f32,
    },
    /// Piecewise cubic, with negative lobes that sharpen edges (Mitchell and Netravali 1988,
    /// "Reconstruction filters in computer graphics").
    Mitchell {
        /// Distance at which the filter becomes 0, in [0.1, 16].
        #[serde(default = "PixelFilter::default_mitchell_radius")]
        radius: f32,
        /// Blur, in [0, 1].
        #[serde(default = "PixelFilter::default_third")]
        b: f32,
        /// Height of the negative lobes, in [0, 1].
        #[serde(default = "PixelFilter::default_third")]
        c: f32,
    },
    /// The window of four cosines (Harris 1978, "On the use of windows for harmonic analysis").
    BlackmanHarris {
        /// Distance at which the filter ends, in [0.1, 16].
        #[serde(default = "PixelFilter::default_smooth_radius")]
        radius: f32,
    },
}

impl PixelFilter {
    fn default_triangle_radius() -> f32 {
        1.0
    }

    fn default_smooth_radius() -> f32 {
        1.5
    }

    fn default_sigma() -> f32 {
        0.5
    }

    fn default_mitchell_radius() -> f32 {
        2.0
    }

    fn default_third() -> f32 {
        1.0 / 3.0
    }

    pub(crate) fn is_box(&self) -> bool {
        *self == Self::Box
    }

    pub(crate) fn check(&self, e: &Location<'_>) -> Result<()> {
        let length = |name: &str, value: f32| {
            e.check((0.1..=16.0).contains(&value), name, "in [0.1, 16]", value)
        };
        let share = |name: &str, value: f32| {
            e.check((0.0..=1.0).contains(&value), name, "in [0, 1]", value)
        };
        match *self {
            Self::Box => Ok(()),
            Self::Triangle { radius } | Self::BlackmanHarris { radius } => {
                length("filter: radius", radius)
            }
            Self::Gaussian { radius, sigma } => length("filter: radius", radius).and_then(|()| {
                // The outermost bin of a table would be too wide for longer tails.
                let ok = (radius / 4.0..=16.0).contains(&sigma);
                e.check(ok, "filter: sigma", "in [radius/4, 16]", sigma)
            }),
            Self::Mitchell { radius, b, c } => length("filter: radius", radius)
                .and_then(|()| share("filter: b", b))
                .and_then(|()| share("filter: c", c)),
        }
    }

    /// The distance at which the filter ends.
    fn radius(&self) -> f64 {
        f64::from(match *self {
            Self::Box => 0.5,
            Self::Triangle { radius }
            | Self::Gaussian { radius, .. }
            | Self::Mitchell { radius, .. }
            | Self::BlackmanHarris { radius } => radius,
        })
    }

    /// The value at the share `x` of the radius, in `[0, 1]`, up to a constant factor.
    fn value(&self, x: f64) -> f64 {
        match *self {
            Self::Box => 1.0,
            Self::Triangle { .. } => 1.0 - x,
            Self::Gaussian { radius, sigma } => {
                let end = f64::from(radius) / f64::from(sigma);
                let gauss = |x: f64| exp(-0.5 * (end * x) * (end * x));
                gauss(x) - gauss(1.0)
            }
            Self::Mitchell { b, c, .. } => {
                let (b, c, x) = (f64::from(b), f64::from(c), 2.0 * x);
                if x < 1.0 {
                    let [square, cube] = [12.0 * b + 6.0 * c - 18.0, 12.0 - 9.0 * b - 6.0 * c];
                    (cube * x + square) * x * x + (6.0 - 2.0 * b)
                } else {
                    let [one, square] = [-12.0 * b - 48.0 * c, 6.0 * b + 30.0 * c];
                    (((-b - 6.0 * c) * x + square) * x + one) * x + (8.0 * b + 24.0 * c)
                }
            }
            Self::BlackmanHarris { .. } => {
                // Cosines of multiples of an angle are polynomials of its cosine.
                let (_, cos) = sin_cos_degrees(180.0 * x);
                let (cos_2, cos_3) = (2.0 * cos * cos - 1.0, (4.0 * cos * cos - 3.0) * cos);
                0.35875 + 0.48829 * cos + 0.14128 * cos_2 + 0.01168 * cos_3
            }
        }
    }
}

/// Number of bins of a table, a power of two.
const BINS: usize = 1 << 12;
/// Number of cells of the numerical integrals over half of a filter.
const CELLS: usize = 1 << 15;

/// A table from which the positions of samples are drawn along one axis. The bins have equal
/// shares of the integral of |f|. Positions are uniform within a bin, and each bin has a constant
/// weight, so that its integral is exactly that of f, signs included. The filter of the image is
/// therefore f, averaged within each bin (as in pbrt: Pharr et al. 2023, 8.8.3). A sample's weight
/// is 1 if f is nowhere negative.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FilterTable(
    /// The lower end of each bin, measured from the upper left corner of the pixel, its width, and
    /// the weight.
    Vec<Row>,
);

impl FilterTable {
    /// The table of `filter`; `None` for the box, which needs none.
    pub(crate) fn new(filter: &PixelFilter) -> Option<Self> {
        if filter.is_box() {
            return None;
        }
        // The integrals of |f| and f from the left end to each cell, by the midpoint rule.
        let mut integrals = vec![(0.0, 0.0)];
        let (mut mass, mut sum) = (0.0f64, 0.0);
        for cell in 0..CELLS {
            let f = filter.value(1.0 - (cell as f64 + 0.5) / CELLS as f64);
            (mass, sum) = (mass + f.abs(), sum + f);
            integrals.push((mass, sum));
        }
        // The ends of the bins of the left half, as shares of the radius, and the integrals of f
        // up to there.
        let half = BINS / 2;
        let mut cell = 0;
        let mut end = |bin: usize| {
            let share = mass * (bin as f64 / half as f64);
            while cell + 1 < CELLS && integrals[cell + 1].0 <= share {
                cell += 1;
            }
            let ((m0, s0), (m1, s1)) = (integrals[cell], integrals[cell + 1]);
            let t = (share - m0) / (m1 - m0);
            ((cell as f64 + t) / CELLS as f64 - 1.0, s0 + t * (s1 - s0))
        };
        let ends: Vec<(f64, f64)> = (0..=half).map(&mut end).collect();
        let radius = filter.radius();
        let row = |bin: usize| {
            // The right half mirrors the left one.
            let left = if bin < half { bin } else { BINS - 1 - bin };
            let ((x0, s0), (x1, s1)) = (ends[left], ends[left + 1]);
            let start = 0.5 + radius * if bin < half { x0 } else { -x1 };
            let weight = (s1 - s0) * half as f64 / sum;
            [start, radius * (x1 - x0), weight, 0.0].map(|value| (value as f32).to_bits())
        };
        Some(Self((0..BINS).map(row).collect()))
    }

    /// The position for the uniform random number `u`, measured from the upper left corner of the
    /// pixel, and the weight.
    #[inline(always)]
    pub(crate) fn sample<R: Real>(&self, u: R) -> (R, R) {
        let scaled = u * BINS as f32;
        let bin = scaled.floor();
        let index = R::index(whole(bin) & R::Word::splat(BINS as u32 - 1), self.0.len());
        let (bin_row, _) = R::gather(&self.0, index, |row| row);
        (bin_row[0] + bin_row[1] * (scaled - bin), bin_row[2])
    }
}
