//! Transfer curves between linear values and 8-bit codes, exact on every platform.

use std::array;
use std::sync::LazyLock;

use crate::math::precise::pow_12_5;
use crate::math::{max, min};

/// Curve that maps linear values to display values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Transfer {
    /// The sRGB curve of IEC 61966-2-1.
    #[default]
    Srgb,
    /// Square root, the curve of the pictures in the report.
    Gamma2,
}

names! { pub Transfer: Srgb = "srgb", Gamma2 = "2" }

/// Linear values of the codes, and the thresholds between them.
struct Table {
    /// Linear value of each code.
    linear: [f32; 256],
    /// Entry k is the linear value half-way, on the curve, between codes k and k + 1. The last
    /// entry is infinite.
    thresholds: [f32; 256],
    /// The code of the smallest value of each range of values. Each octave has 2⁸ ranges, which are
    /// so narrow that each contains at most one threshold.
    codes: [u8; RANGES],
}

/// Linear values below this one have code 0 on every curve.
const DARK: f32 = 1.0 / (1 << 18) as f32;
/// Number of low bits that vary within a range: an octave of `f32` spans 23 bits.
const RANGE_BITS: u32 = 23 - 8;
const RANGES: usize = range(1.0) + 1;

/// The index of the range of a value in `[DARK, 1]`.
const fn range(linear: f32) -> usize {
    (linear.to_bits() - DARK.to_bits()) as usize >> RANGE_BITS
}

impl Table {
    fn new(to_linear: fn(f64) -> f64) -> Self {
        let threshold = |k| to_linear((k as f64 + 0.5) / 255.0) as f32;
        let thresholds = array::from_fn(|k| if k < 255 { threshold(k) } else { f32::INFINITY });
        let least = |range: usize| f32::from_bits(DARK.to_bits() + ((range as u32) << RANGE_BITS));
        Self {
            linear: array::from_fn(|k| to_linear(k as f64 / 255.0) as f32),
            thresholds,
            codes: array::from_fn(|range| thresholds.partition_point(|&t| t <= least(range)) as u8),
        }
    }
}

static SRGB: LazyLock<Table> = LazyLock::new(|| Table::new(srgb_to_linear));
static GAMMA2: LazyLock<Table> = LazyLock::new(|| Table::new(gamma2_to_linear));

fn srgb_to_linear(v: f64) -> f64 {
    if v <= 0.04045 { v / 12.92 } else { pow_12_5((v + 0.055) / 1.055) }
}

fn gamma2_to_linear(v: f64) -> f64 {
    v * v
}

impl Transfer {
    fn table(self) -> &'static Table {
        match self {
            Self::Srgb => &SRGB,
            Self::Gamma2 => &GAMMA2,
        }
    }

    /// The nearest of the 256 codes. Values outside `[0, 1]` are clamped, and NaN gives 0.
    #[inline]
    pub fn encode(self, linear: f32) -> u8 {
        let Table { thresholds, codes, .. } = self.table();
        let linear = min(max(linear, DARK), 1.0);
        let code = codes[range(linear)];
        code + u8::from(thresholds[usize::from(code)] <= linear)
    }

    /// The linear value of a code.
    pub fn decode(self, code: u8) -> f32 {
        self.table().linear[usize::from(code)]
    }

    /// The display value in `[0, 1]` of a linear value, not rounded to a code. NaN stays NaN.
    #[allow(clippy::disallowed_methods)] // a measure of differences, not a rendered value
    pub(super) fn display(self, linear: f32) -> f64 {
        let x = f64::from(linear).clamp(0.0, 1.0);
        match self {
            Self::Gamma2 => x.sqrt(),
            Self::Srgb if x <= 0.003_130_8 => x * 12.92,
            Self::Srgb => 1.055 * x.powf(1.0 / 2.4) - 0.055,
        }
    }

    /// The linear value of a display value in `[0, 1]`.
    pub(crate) fn to_linear(self, display: f64) -> f32 {
        (match self {
            Self::Srgb => srgb_to_linear(display),
            Self::Gamma2 => gamma2_to_linear(display),
        }) as f32
    }

    /// The curve called `name`.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|t| t.name() == name)
    }
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // the reference is libm in f64
mod tests {
    use super::*;

    #[test]
    fn codes_round_trip() {
        for transfer in Transfer::ALL {
            for code in 0..=255 {
                assert_eq!(transfer.encode(transfer.decode(code)), code);
            }
            assert_eq!(transfer.encode(f32::NAN), 0);
            assert_eq!(transfer.encode(-1.0), 0);
            assert_eq!(transfer.encode(f32::INFINITY), 255);
            assert_eq!(Transfer::from_name(transfer.name()), Some(transfer));
        }
    }

    #[test]
    fn codes_change_at_their_thresholds_and_nowhere_else() {
        for transfer in Transfer::ALL {
            let Table { thresholds, .. } = transfer.table();
            let beside = |x: f32| [x.next_down(), x, x.next_up()];
            let ranges =
                (0..RANGES as u32).map(|k| f32::from_bits(DARK.to_bits() + (k << RANGE_BITS)));
            for linear in thresholds[..255].iter().copied().chain(ranges).flat_map(beside) {
                let code = thresholds.iter().filter(|&&threshold| threshold <= linear).count();
                assert_eq!(usize::from(transfer.encode(linear)), code, "{linear}");
            }
        }
    }

    #[test]
    fn srgb_follows_the_standard() {
        for i in 0..=10_000 {
            let linear = f64::from(i) / 10_000.0;
            let v = if linear <= 0.003_130_8 {
                linear * 12.92
            } else {
                1.055 * linear.powf(1.0 / 2.4) - 0.055
            };
            let code = f64::from(Transfer::Srgb.encode(linear as f32));
            assert!((code - v * 255.0).abs() < 0.5 + 1e-4, "{linear}: {code} {v}");
        }
    }
}
