//! How linear values become the codes of 8-bit files: exposure, tone map and transfer curve.

use std::fmt;

use rayon::prelude::*;

use super::{Format, Metadata, ToneMap, Transfer};
use crate::math::precise::exp2;
use crate::math::{clamp, max, min};

/// PNG text key of the transfer curve.
pub(super) const TRANSFER_KEY: &str = "ptfast:transfer";
/// PNG text keys of the exposure and the tone map, if they are not the default.
pub(super) const GRADE_KEYS: [&str; 2] = ["ptfast:exposure", "ptfast:tonemap"];

/// EXR text key of layers that are 16-bit floats.
const HALF_KEY: &str = "ptfast:half_layers";

/// Largest magnitude of an exposure in stops.
pub(crate) const MAX_STOPS: f32 = 32.0;

/// The factor of linear values in 8-bit files.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// 2 to this power, in [-32, 32].
    Stops(f32),
    /// 2 to the largest multiple of a quarter at which at most a twentieth of the pixels that are not black have a
    /// channel above 1.
    Auto,
}

impl Default for Exposure {
    fn default() -> Self {
        Self::Stops(0.0)
    }
}

impl fmt::Display for Exposure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stops(stops) => stops.fmt(f),
            Self::Auto => f.write_str("auto"),
        }
    }
}

impl Exposure {
    /// The factor for `pixels`.
    fn factor(self, pixels: &[[f32; 3]]) -> f32 {
        exp2(f64::from(self.stops(pixels))) as f32
    }

    /// The stops for `pixels`.
    pub(crate) fn stops(self, pixels: &[[f32; 3]]) -> f32 {
        match self {
            Self::Stops(stops) => clamp(stops, -MAX_STOPS, MAX_STOPS),
            Self::Auto => automatic_stops(pixels),
        }
    }
}

fn automatic_stops(pixels: &[[f32; 3]]) -> f32 {
    // NaN counts as black.
    let peak = |pixel: &[f32; 3]| pixel.iter().fold(0.0, |a, &b| if b > a { b } else { a });
    let mut peaks: Vec<f32> = pixels.iter().map(peak).filter(|&peak| peak > 0.0).collect();
    let Some(last) = peaks.len().checked_sub(1) else { return 0.0 };
    let kept = last - peaks.len() / 20;
    let (_, &mut most, _) = peaks.select_nth_unstable_by(kept, f32::total_cmp);
    let limit = (4.0 * MAX_STOPS) as i32;
    let stops = (-limit..=limit).rev().map(|quarters| quarters as f32 / 4.0);
    let fits = |stops: &f32| f64::from(most) * exp2(f64::from(*stops)) <= 1.0;
    stops.into_iter().find(fits).unwrap_or(-MAX_STOPS)
}

/// The appearance of 8-bit files, and the size of the floats of layers. Formats with floats store linear
/// values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Display {
    /// The factor of linear values.
    pub exposure: Exposure,
    /// The tone map, which follows the exposure.
    pub tone_map: ToneMap,
    /// The transfer curve, which follows the tone map.
    pub transfer: Transfer,
    /// Whether EXR files hold layers as 16-bit floats, apart from colour and from numbers of instances and
    /// materials.
    pub half_layers: bool,
}

impl From<Transfer> for Display {
    fn from(transfer: Transfer) -> Self {
        Self { transfer, ..Self::default() }
    }
}

impl Display {
    /// The codes of `pixels`, four for each, of which the last is 255. Threads of the current pool share the work.
    pub(crate) fn rgba(&self, pixels: &[[f32; 3]]) -> Vec<u8> {
        // The same for all parts.
        let display = Self { exposure: Exposure::Stops(self.exposure.stops(pixels)), ..*self };
        let mut codes = vec![255; 4 * pixels.len()];
        let parts = pixels.par_chunks(1 << 12).zip(codes.par_chunks_mut(4 << 12));
        parts.for_each(|(pixels, codes)| {
            for (pixel, code) in display.mapped(pixels).zip(codes.as_chunks_mut::<4>().0) {
                let [red, green, blue] = pixel.map(|value| self.transfer.encode(value));
                *code = [red, green, blue, 255];
            }
        });
        codes
    }

    /// The codes of `pixels`, three for each.
    pub(super) fn encode(&self, pixels: &[[f32; 3]]) -> Vec<u8> {
        self.mapped(pixels).flatten().map(|value| self.transfer.encode(value)).collect()
    }

    /// The `pixels` after exposure and tone map.
    fn mapped<'a>(&self, pixels: &'a [[f32; 3]]) -> impl Iterator<Item = [f32; 3]> + use<'a> {
        let (factor, tone_map) = (self.exposure.factor(pixels), self.tone_map);
        let exposed = pixels.iter().map(move |pixel| pixel.map(|value| value * factor));
        exposed.map(move |pixel| match tone_map {
            ToneMap::None => pixel,
            // NaN becomes 0, as without a tone map.
            map => map.apply(pixel.map(|c| min(max(c, 0.0), f32::MAX).into())).map(|c| c as f32),
        })
    }

    /// The share of those of the `pixels` that are not black that have a channel above 1, which 8-bit files clip.
    pub(super) fn clipped(&self, pixels: &[[f32; 3]]) -> f64 {
        let clipped = self.mapped(pixels).filter(|pixel| pixel.iter().any(|&value| value > 1.0));
        let lit = pixels.iter().filter(|pixel| pixel.iter().any(|&value| value > 0.0)).count();
        clipped.count() as f64 / lit.max(1) as f64
    }

    /// The codes of `pixels` and their `alpha`, four for each pixel. The colours in PNG files are not
    /// multiplied by alpha, unlike `pixels` (PNG specification, section 13.16).
    pub(super) fn encode_with_alpha(&self, pixels: &[[f32; 3]], alpha: &[f32]) -> Vec<u8> {
        let colors: Vec<_> = (pixels.iter().zip(alpha))
            .map(|(pixel, &alpha)| pixel.map(|c| if alpha > 0.0 { c / alpha } else { 0.0 }))
            .collect();
        let code = |alpha: f32| (clamp(alpha, 0.0, 1.0) * 255.0).round() as u8;
        let (colors, alpha) = (self.encode(&colors), alpha.iter().map(|&alpha| code(alpha)));
        let codes = colors.chunks_exact(3).zip(alpha);
        codes.flat_map(|(color, alpha)| [color[0], color[1], color[2], alpha]).collect()
    }

    /// Adds entries about this appearance to the metadata of a file of this format.
    pub(crate) fn noted(&self, format: Format, mut metadata: Metadata) -> Metadata {
        if format != Format::Png {
            let is_noted = format == Format::Exr && self.half_layers;
            return if is_noted { metadata.with(HALF_KEY, true) } else { metadata };
        }
        let [exposure, tone_map] = GRADE_KEYS;
        if self.exposure != Exposure::default() {
            metadata = metadata.with(exposure, self.exposure);
        }
        if self.tone_map != ToneMap::None {
            metadata = metadata.with(tone_map, self.tone_map.name());
        }
        metadata.with(TRANSFER_KEY, self.transfer.name())
    }

    /// Whether `there`, the metadata of a file of this format, has the entries of this appearance.
    pub(crate) fn is_noted_in(&self, format: Format, there: &Metadata) -> bool {
        let wanted = self.noted(format, Metadata::default());
        let mut keys = GRADE_KEYS.into_iter().chain([TRANSFER_KEY, HALF_KEY]);
        keys.all(|key| there.get(key) == wanted.get(key))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exposure_counts_stops_and_the_default_is_the_curve_alone() {
        let pixels: Vec<[f32; 3]> =
            (0..1000u16).map(|i| [f32::from(i) * 0.001, f32::NAN, -1.0]).collect();
        let curve = |factor: f32, transfer: Transfer| -> Vec<u8> {
            pixels.iter().flatten().map(|&value| transfer.encode(value * factor)).collect()
        };
        for transfer in Transfer::ALL {
            let of = |stops| {
                let exposure = Exposure::Stops(stops);
                Display { exposure, ..transfer.into() }.encode(&pixels)
            };
            assert_eq!(of(0.0), curve(1.0, transfer));
            assert_eq!(of(1.0), curve(2.0, transfer));
            assert_eq!(of(-3.0), curve(0.125, transfer));
        }
    }

    /// One pixel of twenty may be clipped. Black ones do not count.
    #[test]
    fn automatic_exposure_clips_a_twentieth() {
        let mut pixels = vec![[0.0, f32::NAN, -1.0]; 100];
        let display = Display { exposure: Exposure::Auto, ..Display::default() };
        assert_eq!(automatic_stops(&pixels), 0.0);
        pixels.extend([[3.9, 4.0, 0.0]; 38]);
        pixels.extend([[f32::INFINITY; 3]; 2]);
        assert_eq!(automatic_stops(&pixels), -2.0);
        assert_eq!(display.clipped(&pixels), 2.0 / 40.0);
        assert_eq!(Display::default().clipped(&pixels), 1.0);
        pixels.push([5.0, 0.0, 0.0]);
        assert_eq!(automatic_stops(&pixels), -2.5);
        assert_eq!(automatic_stops(&[[1e-3; 3]]), 9.75);
        assert_eq!(
            display.noted(Format::Png, Metadata::default()).get(GRADE_KEYS[0]).unwrap(),
            "auto"
        );
    }

    #[test]
    fn tone_maps_encode_what_is_not_finite() {
        for tone_map in ToneMap::ALL {
            let display = Display { tone_map, ..Display::default() };
            let codes = display.encode(&[[f32::NAN, -1.0, 0.0], [f32::INFINITY; 3]]);
            assert_eq!(codes[..3], [0; 3], "{tone_map:?}");
            assert!(codes[3..].iter().all(|&code| code >= 254), "{tone_map:?}: {codes:?}");
        }
    }
}
