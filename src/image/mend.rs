//! Makes values of float images usable as light and reflectance.

use std::ops::AddAssign;

use crate::math::clamp;

/// The value of infinite texels: the largest one of half floats, in which most maps with a sun are stored.
const INFINITE: f32 = 65504.0;

/// Numbers of texels that had values without a meaning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Mended {
    negative: u64,
    infinite: u64,
    nan: u64,
}

impl Mended {
    /// Makes a texel with NaN black, infinite values 65504, and negative ones 0, which filters and compression leave
    /// beside bright texels. Alpha is clamped to [0, 1].
    pub(super) fn mend(&mut self, [r, g, b, alpha]: [f32; 4]) -> [f32; 4] {
        let (color, alpha_is_nan) = ([r, g, b], alpha.is_nan());
        let alpha = clamp(alpha, 0.0, 1.0);
        if alpha_is_nan || color.iter().any(|value| value.is_nan()) {
            self.nan += 1;
            return [0.0, 0.0, 0.0, alpha];
        }
        self.infinite += u64::from(color.contains(&f32::INFINITY));
        self.negative += u64::from(color.iter().any(|&value| value < 0.0));
        let [r, g, b] = color.map(|value| match value {
            f32::INFINITY => INFINITE,
            _ if value < 0.0 => 0.0,
            _ => value,
        });
        [r, g, b, alpha]
    }

    /// A sentence about the texels, if there are any.
    pub(crate) fn sentence(&self) -> Option<String> {
        let kinds = [
            (self.negative, "negative", "0"),
            (self.infinite, "infinite", "65504"),
            (self.nan, "NaN", "black"),
        ];
        let part = |(count, kind, value)| format!("{count} {kind} texels count as {value}");
        let parts: Vec<_> = kinds.into_iter().filter(|(count, ..)| *count > 0).map(part).collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }
}

impl AddAssign for Mended {
    fn add_assign(&mut self, other: Self) {
        self.negative += other.negative;
        self.infinite += other.infinite;
        self.nan += other.nan;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_without_a_meaning_are_replaced_and_counted() {
        let mut mended = Mended::default();
        let mut mend = |texel| mended.mend(texel);
        assert_eq!(mend([0.5, -0.0, 1e30, 1.0]), [0.5, -0.0, 1e30, 1.0]);
        assert_eq!(mend([-0.01, 2.0, 3.0, 0.5]), [0.0, 2.0, 3.0, 0.5]);
        assert_eq!(mend([f32::INFINITY, 1.0, f32::NEG_INFINITY, 1.0]), [65504.0, 1.0, 0.0, 1.0]);
        assert_eq!(mend([f32::NAN, 1.0, 1.0, 1.0]), [0.0, 0.0, 0.0, 1.0]);
        assert_eq!(mend([1.0, 1.0, 1.0, f32::NAN]), [0.0; 4]);
        assert_eq!(mend([1.0, 1.0, 1.0, 1.001])[3], 1.0);
        assert_eq!(mend([1.0, 1.0, 1.0, -0.001])[3], 0.0);
        assert_eq!(mended, Mended { negative: 2, infinite: 1, nan: 2 });
        assert_eq!(
            mended.sentence().unwrap(),
            "2 negative texels count as 0, 1 infinite texels count as 65504, 2 NaN texels count as black"
        );
        assert_eq!(Mended::default().sentence(), None);
    }
}
