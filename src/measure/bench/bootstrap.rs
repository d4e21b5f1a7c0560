//! Estimates the four statistics that criterion reports, by bootstrap resampling as in criterion.

use crate::math::Stream;
use crate::measure::statistics::{middle, sorted};

/// An estimate with its standard error and 95% confidence interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spread {
    pub(super) point: f64,
    pub(super) error: f64,
    pub(super) lo: f64,
    pub(super) hi: f64,
}

/// The statistics of times that criterion reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spreads {
    pub(super) mean: Spread,
    pub(super) median: Spread,
    pub(super) median_abs_dev: Spread,
    pub(super) std_dev: Spread,
}

const RESAMPLES: usize = 10_000;

/// Estimates the statistics of `values`, which must not be empty. The intervals are percentiles of
/// the resamples (Efron and Tibshirani 1993, "An Introduction to the Bootstrap", chapters 6 and
/// 13).
pub(super) fn bootstrap(values: &[f64]) -> Spreads {
    let spread = |statistic: fn(&[f64]) -> f64| {
        // The fixed seed gives every statistic the same resamples.
        let mut random = Stream::new(1);
        let mut pick = || values[(random.bits() % values.len() as u64) as usize];
        let mut resample = vec![0.0; values.len()];
        let of_resamples = sorted((0..RESAMPLES).map(|_| {
            resample.fill_with(&mut pick);
            statistic(&resample)
        }));
        let beyond = RESAMPLES / 40;
        Spread {
            point: statistic(values),
            error: std_dev(&of_resamples),
            lo: of_resamples[beyond],
            hi: of_resamples[RESAMPLES - 1 - beyond],
        }
    };
    Spreads {
        mean: spread(mean),
        median: spread(median),
        median_abs_dev: spread(median_abs_dev),
        std_dev: spread(std_dev),
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

fn median(values: &[f64]) -> f64 {
    middle(&sorted(values.iter().copied()))
}

/// Median absolute deviation, scaled as in criterion so that it equals the standard deviation of a
/// normal distribution.
fn median_abs_dev(values: &[f64]) -> f64 {
    let middle_of_all = median(values);
    1.4826 * middle(&sorted(values.iter().map(|value| (value - middle_of_all).abs())))
}

fn std_dev(values: &[f64]) -> f64 {
    let mean = mean(values);
    let squares = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>();
    (squares / (values.len() as f64 - 1.0).max(1.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_of_a_mean_is_known() {
        let values: Vec<f64> = (0..100).map(f64::from).collect();
        let Spreads { mean, median, std_dev, .. } = bootstrap(&values);
        assert_eq!((mean.point, median.point), (49.5, 49.5));
        assert!((std_dev.point - 29.011).abs() < 1e-3, "{std_dev:?}");
        // The expected error is 29.01 / sqrt(100); 0.11 is five standard errors of 10 000 resamples.
        assert!((mean.error - 2.9).abs() < 0.11, "{mean:?}");
        assert!((mean.lo - 43.8).abs() < 0.5 && (mean.hi - 55.2).abs() < 0.5, "{mean:?}");
    }
}
