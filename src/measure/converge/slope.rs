//! Fits straight lines to errors on logarithmic axes.
#![expect(clippy::disallowed_methods, reason = "no bit of an image depends on these")]

use super::Point;

/// Slope of errors on logarithmic axes: −1 for independent samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slope {
    pub(crate) slope: f64,
    /// Standard error of the slope due to the noise of the renders; 0 if that noise is unknown.
    pub(crate) error: f64,
}

impl Slope {
    /// Slope over samples.
    pub(crate) fn of_samples(points: &[Point]) -> Option<Self> {
        Self::of(points, |point| f64::from(point.spp))
    }

    /// Slope over seconds.
    pub(crate) fn of_seconds(points: &[Point]) -> Option<Self> {
        Self::of(points, |point| point.seconds)
    }

    /// Fits a line by least squares; `None` if fewer than two errors are known. With more than four
    /// points, the two with the fewest samples are left out, since they say little about the trend.
    fn of(points: &[Point], x: impl Fn(&Point) -> f64) -> Option<Self> {
        let from = if points.len() > 4 { 2 } else { 0 };
        let known = points[from..].iter().filter(|point| point.mse > 0.0 && x(point) > 0.0);
        let logs: Vec<_> = known.map(|p| (x(p).ln(), p.mse.ln(), p.mse_error / p.mse)).collect();
        let n = logs.len() as f64;
        let middle = logs.iter().map(|log| log.0).sum::<f64>() / n;
        let (mut xx, mut xy, mut variance) = (0.0, 0.0, 0.0);
        for (x, y, error) in logs {
            let x = x - middle;
            (xx, xy) = (xx + x * x, xy + x * y);
            variance += x * x * error * error;
        }
        (xx > 0.0).then(|| Self { slope: xy / xx, error: variance.sqrt() / xx })
    }
}

/// The error after `seconds`, interpolated between the points before and after on logarithmic axes.
/// `None` if all renders took longer or all took less time, or if an error is unknown.
pub(crate) fn at_seconds(points: &[Point], seconds: f64) -> Option<f64> {
    if let Some(point) = points.iter().find(|point| point.seconds == seconds && point.mse > 0.0) {
        return Some(point.mse);
    }
    let two = points.windows(2).find(|two| two[0].seconds < seconds && seconds < two[1].seconds)?;
    let [(t, e), (u, f)] = [0, 1].map(|i| (two[i].seconds.ln(), two[i].mse.ln()));
    let error = (e + (f - e) * (seconds.ln() - t) / (u - t)).exp();
    error.is_finite().then_some(error)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(slope: f64) -> Vec<Point> {
        (0..8)
            .map(|i| {
                let spp = 1 << i;
                let mse = 3.0 * f64::from(spp).powf(slope);
                Point { spp, mse, mse_error: 0.0, seconds: 0.01 * f64::from(spp) }
            })
            .collect()
    }

    #[test]
    fn slopes_are_found() {
        for slope in [-1.0, -1.5, -0.3] {
            let points = points(slope);
            let [samples, seconds] =
                [Slope::of_samples(&points), Slope::of_seconds(&points)].map(Option::unwrap);
            assert!((samples.slope - slope).abs() < 1e-12);
            assert!((seconds.slope - slope).abs() < 1e-12);
            for seconds in [0.01, 0.05, 0.64, 1.28] {
                let want = 3.0 * (seconds / 0.01f64).powf(slope);
                assert!((at_seconds(&points, seconds).unwrap() - want).abs() < 1e-9 * want);
            }
            for seconds in [0.009, 1.29] {
                assert_eq!(at_seconds(&points, seconds), None);
            }
        }
        assert_eq!(Slope::of_samples(&points(-1.0)[..1]), None);
        let black: Vec<_> = points(-1.0).into_iter().map(|p| Point { mse: 0.0, ..p }).collect();
        assert_eq!((Slope::of_samples(&black), at_seconds(&black, 0.05)), (None, None));
    }

    /// The slope through two noisy errors has the noise of their difference.
    #[test]
    fn noise_of_errors_is_noise_of_slopes() {
        let of = |mse_error| {
            let points = points(-1.0)
                .into_iter()
                .take(2)
                .map(|p| Point { mse_error: mse_error * p.mse, ..p });
            Slope::of_samples(&points.collect::<Vec<_>>()).unwrap().error
        };
        assert_eq!(of(0.0), 0.0);
        assert!((of(0.1) - 0.1 * 2f64.sqrt() / 2f64.ln()).abs() < 1e-12);
    }
}
