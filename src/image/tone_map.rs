//! Tone maps compress linear values of any size to `[0, 1]`, in arithmetic that is the same on
//! every platform.

use crate::math::precise::{exp2, log2};

/// A tone map for 8-bit files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneMap {
    /// Values above 1 are clamped.
    #[default]
    None,
    /// AgX of Troy Sobotka (<https://github.com/sobotka/AgX>) with the matrices and the polynomial
    /// of Wrensch 2023, "Minimal AgX implementation". It covers 16.5 stops, and bright colours fade
    /// to white.
    Agx,
    /// Khronos PBR Neutral
    /// (<https://github.com/KhronosGroup/ToneMapping/tree/main/PBR_Neutral>). It keeps most colours
    /// as they are, and compresses highlights only.
    Neutral,
}

names! { pub ToneMap: None = "none", Agx = "agx", Neutral = "neutral" }

impl ToneMap {
    /// Maps linear RGB to linear RGB in `[0, 1]`. Values of `color` are 0 or more, and finite.
    pub(super) fn apply(self, color: [f64; 3]) -> [f64; 3] {
        match self {
            Self::None => color,
            Self::Agx => agx(color),
            Self::Neutral => neutral(color),
        }
        .map(|c| c.clamp(0.0, 1.0))
    }
}

/// Moves colours towards grey before the curve.
const INSET: [[f64; 3]; 3] = [
    [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
    [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
    [0.0423756549057051, 0.0784336, 0.879142973793104],
];
/// The inverse of [`INSET`].
const OUTSET: [[f64; 3]; 3] = [
    [1.19687900512017, -0.0980208811401368, -0.0990297440797205],
    [-0.0528968517574562, 1.15190312990417, -0.0989611768448433],
    [-0.0529716355144438, -0.0980434501171241, 1.15107367264116],
];
/// Logarithms to base 2 of the values that become black and white.
const STOPS: [f64; 2] = [-12.47393, 4.026069];
/// Coefficients of the curve from logarithms to display values, highest power first.
const CURVE: [f64; 7] = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232];

fn agx(color: [f64; 3]) -> [f64; 3] {
    let curved = apply(&INSET, color).map(|c| {
        // Values below 1e-10 are black in any case.
        let stops = log2(if c > 1e-10 { c } else { 1e-10 });
        let x = ((stops - STOPS[0]) / (STOPS[1] - STOPS[0])).clamp(0.0, 1.0);
        CURVE.into_iter().fold(0.0, |sum, coefficient| sum * x + coefficient)
    });
    // Display values of AgX are for a display whose exponent is 2.2.
    apply(&OUTSET, curved).map(|c| if c > 1e-10 { exp2(2.2 * log2(c)) } else { 0.0 })
}

fn apply(matrix: &[[f64; 3]; 3], [r, g, b]: [f64; 3]) -> [f64; 3] {
    matrix.map(|[x, y, z]| x * r + y * g + z * b)
}

fn neutral([r, g, b]: [f64; 3]) -> [f64; 3] {
    /// Reflectance at normal incidence, which is subtracted from bright colours.
    const F90: f64 = 0.04;
    /// Value at which the compression starts.
    const START: f64 = 0.8 - F90;
    /// Speed of the desaturation.
    const FADE: f64 = 0.15;
    let least = [g, b].into_iter().fold(r, |a, b| if a < b { a } else { b });
    let offset = if least <= 2.0 * F90 { least - least * least / (4.0 * F90) } else { F90 };
    let color = [r, g, b].map(|c| c - offset);
    let peak = color.into_iter().fold(0.0, |a, b| if a > b { a } else { b });
    if peak <= START {
        return color;
    }
    let new_peak = 1.0 - (1.0 - START) * (1.0 - START) / (peak + 1.0 - 2.0 * START);
    let share = 1.0 / (FADE * (peak - new_peak) + 1.0);
    color.map(|c| c * (new_peak / peak) * share + new_peak * (1.0 - share))
}

#[cfg(test)]
#[allow(clippy::disallowed_methods)] // the reference is libm in f64
mod tests {
    use super::*;

    fn close(got: [f64; 3], want: [f64; 3]) {
        let off = (0..3).map(|i| (got[i] - want[i]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9, "{got:?}, not {want:?}");
    }

    #[test]
    fn agx_agrees_with_its_formula_in_libm() {
        for color in [[0.0; 3], [0.18; 3], [1.0; 3], [16.0; 3], [1e30; 3], [4.0, 0.1, 0.0]] {
            let curve = |c: f64| {
                let x = ((c.max(1e-10).log2() + 12.47393) / 16.499999).clamp(0.0, 1.0);
                15.5 * x.powi(6) - 40.14 * x.powi(5) + 31.96 * x.powi(4) - 6.868 * x.powi(3)
                    + 0.4298 * x.powi(2)
                    + 0.1191 * x
                    - 0.00232
            };
            let display = apply(&OUTSET, apply(&INSET, color).map(curve));
            close(ToneMap::Agx.apply(color), display.map(|c| c.max(0.0).powf(2.2).min(1.0)));
        }
        let [r, g, b] = ToneMap::Agx.apply([0.18; 3]);
        let grey = ((r + g + b) / 3.0).powf(1.0 / 2.2);
        assert!((0.45..0.5).contains(&grey), "middle grey is {grey}");
        assert_eq!(ToneMap::Agx.apply([0.0; 3]), [0.0; 3]);
        let red = ToneMap::Agx.apply([1e6, 0.0, 0.0]);
        assert!(red.iter().all(|&c| c > 0.5), "bright red fades to white: {red:?}");
    }

    #[test]
    fn neutral_has_the_values_of_its_specification() {
        let neutral = |color| ToneMap::Neutral.apply(color);
        close(neutral([0.0; 3]), [0.0; 3]);
        close(neutral([0.04; 3]), [0.01; 3]);
        close(neutral([0.18; 3]), [0.14; 3]);
        close(neutral([0.8; 3]), [0.76; 3]);
        // p = 0.96, p_n = 1 − 0.24²/(0.96 + 1 − 1.52)
        close(neutral([1.0; 3]), [1.0 - 0.0576 / 0.44; 3]);
        close(neutral([0.5, 0.25, 0.0]), [0.5, 0.25, 0.0]);
        assert!(neutral([1e30; 3])[0] > 0.999_999);
    }

    #[test]
    fn greys_stay_in_order_and_within_the_range() {
        for map in ToneMap::ALL {
            let mut last = [0.0; 3];
            for i in -2000..=2000 {
                let next = map.apply([exp2(f64::from(i) / 100.0); 3]);
                for (last, next) in last.into_iter().zip(next) {
                    assert!(last <= next + 1e-12 && (0.0..=1.0).contains(&next), "{map:?}, {i}");
                }
                last = next;
            }
            assert!(last.iter().all(|&c| c > 0.99), "{map:?}: white is {last:?}");
        }
    }
}
