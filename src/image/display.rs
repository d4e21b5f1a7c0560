//! How linear values become the codes of 8-bit files: exposure, tone map and transfer curve.

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

/// The appearance of 8-bit files, and the size of the floats of layers. Formats with floats store linear
/// values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Display {
    /// Linear values are multiplied by 2 to this power, in [-32, 32].
    pub exposure: f32,
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
    /// The codes of `pixels`, three for each.
    pub(super) fn encode(&self, pixels: &[[f32; 3]]) -> Vec<u8> {
        let factor = exp2(f64::from(clamp(self.exposure, -MAX_STOPS, MAX_STOPS))) as f32;
        let exposed = pixels.iter().map(|pixel| pixel.map(|value| value * factor));
        let mapped = exposed.map(|pixel| match self.tone_map {
            ToneMap::None => pixel,
            // NaN becomes 0, as without a tone map.
            map => map.apply(pixel.map(|c| min(max(c, 0.0), f32::MAX).into())).map(|c| c as f32),
        });
        mapped.flatten().map(|value| self.transfer.encode(value)).collect()
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
        if self.exposure != 0.0 {
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
            let of = |exposure| Display { exposure, ..transfer.into() }.encode(&pixels);
            assert_eq!(of(0.0), curve(1.0, transfer));
            assert_eq!(of(1.0), curve(2.0, transfer));
            assert_eq!(of(-3.0), curve(0.125, transfer));
        }
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
