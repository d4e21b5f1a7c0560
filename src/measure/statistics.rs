//! Medians, with confidence intervals that hold for any distribution.
#![expect(clippy::disallowed_methods, reason = "no bit of an image depends on these")]

use serde::{Deserialize, Serialize};

/// A median, and the ends of an interval that contains the true median with a probability of 95%.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Estimate {
    pub(crate) median: f64,
    pub(crate) lo: f64,
    pub(crate) hi: f64,
}

impl Estimate {
    /// Smallest number of values for an interval of 95%. With fewer, the interval contains the true
    /// median less often.
    pub(crate) const LEAST: usize = 6;

    /// Median of one or more independent `values`. The ends of the interval are two of the values,
    /// whose ranks follow from the binomial distribution (Conover 1999, "Practical Nonparametric
    /// Statistics", section 3.2).
    pub(crate) fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let sorted = sorted(values);
        let cut = beyond_median(sorted.len());
        Self { median: middle(&sorted), lo: sorted[cut], hi: sorted[sorted.len() - 1 - cut] }
    }

    /// Median of positive `values`, computed with their logarithms, so that 2 and 1/2 are equally
    /// far from 1.
    pub(crate) fn of_positive(values: impl IntoIterator<Item = f64>) -> Self {
        let Self { median, lo, hi } = Self::of(values.into_iter().map(f64::ln));
        Self { median: median.exp(), lo: lo.exp(), hi: hi.exp() }
    }

    /// Ratio of positive `values` to `others`, assuming that both are scaled copies of one
    /// distribution. It is the median ratio of all pairs (Hodges and Lehmann), with the interval
    /// that belongs to the test of Mann and Whitney (Conover 1999, section 5.4).
    pub(crate) fn of_ratio(values: &[f64], others: &[f64]) -> Self {
        let ratios = values.iter().flat_map(|value| others.iter().map(move |other| value / other));
        let sorted = sorted(ratios);
        let cut = beyond_shift(values.len(), others.len());
        Self { median: middle(&sorted), lo: sorted[cut], hi: sorted[sorted.len() - 1 - cut] }
    }

    /// Half the length of the interval, relative to the median.
    pub(crate) fn relative_error(&self) -> f64 {
        0.5 * (self.hi - self.lo) / self.median
    }
}

pub(crate) fn sorted(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    assert!(!values.is_empty(), "a median needs at least one value");
    values.sort_by(f64::total_cmp);
    values
}

/// The middle value, or the mean of the two middle values.
pub(crate) fn middle(sorted: &[f64]) -> f64 {
    0.5 * (sorted[(sorted.len() - 1) / 2] + sorted[sorted.len() / 2])
}

/// Number of values left out on either side of the interval of a median: the largest number for
/// which each tail has a probability of at most 2.5%.
fn beyond_median(count: usize) -> usize {
    if count > 500 {
        // Uses the normal approximation. The exact count below fails from 1075 values on, because
        // 0.5^1075 is 0 in f64.
        return (0.5 * (count as f64 - 1.96 * (count as f64).sqrt()) - 0.5) as usize;
    }
    let (mut below, mut probability, mut tail) = (0, 0.5f64.powi(count as i32), 0.0);
    loop {
        tail += probability;
        if tail > 0.025 {
            return below.max(1) - 1;
        }
        probability *= (count - below) as f64 / (below + 1) as f64;
        below += 1;
    }
}

/// Number of pairs left out on either side of the interval of a ratio. The ratio is a shift of the
/// logarithms. Uses the normal approximation.
fn beyond_shift(a: usize, b: usize) -> usize {
    let (a, b) = (a as f64, b as f64);
    let (mean, variance) = (0.5 * a * b, a * b * (a + b + 1.0) / 12.0);
    (mean - 1.96 * variance.sqrt() - 0.5).max(0.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;

    fn skewed(random: &mut Stream, count: usize) -> Vec<f64> {
        (0..count).map(|_| -f64::from(1.0 - random.uniform()).ln()).collect()
    }

    /// Table A3 of Conover for p = 0.5: number of values, and how many to leave out on either side.
    #[test]
    fn ranks_of_medians() {
        let table = [(1, 0), (5, 0), (6, 0), (8, 0), (9, 1), (10, 1), (12, 2), (15, 3), (20, 5)];
        for (count, cut) in table {
            assert_eq!(beyond_median(count), cut, "{count} values");
        }
        // The exact count and the approximation agree at the boundary.
        assert_eq!((beyond_median(500), beyond_median(501)), (227, 228));
        assert_eq!(beyond_median(20_000), 9860);
    }

    /// The number of pairs left out is the critical value of Mann and Whitney's U (two-sided, 5%)
    /// or one less.
    #[test]
    fn ranks_of_shifts() {
        for (a, b, least, cut) in [(5, 5, 2, 2), (6, 6, 5, 5), (8, 8, 12, 13), (10, 10, 23, 23)] {
            assert!((least..=cut).contains(&beyond_shift(a, b)), "{a} {b}: {}", beyond_shift(a, b));
        }
        assert_eq!(beyond_shift(20, 20), 127);
        assert_eq!(beyond_shift(1, 2), 0);
    }

    #[test]
    fn medians_are_in_the_middle() {
        let median = |values: &[f64]| Estimate::of(values.iter().copied()).median;
        assert_eq!(median(&[3.0]), 3.0);
        assert_eq!(median(&[4.0, 1.0]), 2.5);
        assert_eq!(median(&[9.0, 1.0, 2.0]), 2.0);
        let Estimate { median, .. } = Estimate::of_positive([1.0, 4.0]);
        assert!((median - 2.0).abs() < 1e-15, "{median}");
        assert_eq!(Estimate::of_ratio(&[2.0, 4.0, 8.0], &[1.0, 2.0, 4.0]).median, 2.0);
    }

    /// For skewed values with known medians, 10000 trials are made. The share of intervals that
    /// contain the true median is above 95% minus four standard deviations.
    #[test]
    fn intervals_contain_the_true_median() {
        const LEAST_INSIDE: usize = 9413;
        let mut random = Stream::new(11);
        for count in [6, 9, 12, 40] {
            let inside = |truth: f64, e: Estimate| e.lo <= truth && truth <= e.hi;
            let medians = (0..10_000)
                .filter(|_| inside(2f64.ln(), Estimate::of(skewed(&mut random, count))))
                .count();
            assert!(medians > LEAST_INSIDE, "{medians} of 10 000 intervals of {count} values");
            let ratios = (0..10_000)
                .filter(|_| {
                    let (a, b) = (skewed(&mut random, count), skewed(&mut random, count + 2));
                    let twice: Vec<f64> = a.iter().map(|value| 2.0 * value).collect();
                    inside(2.0, Estimate::of_ratio(&twice, &b))
                })
                .count();
            assert!(
                ratios > LEAST_INSIDE,
                "{ratios} of 10 000 intervals of ratios, {count} values"
            );
        }
    }
}
