//! Straight lines through errors, both logarithmic.
#![expect(clippy::disallowed_methods, reason = "no bit of an image depends on these")]

use super::Point;

/// log y = slope log x + offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    pub(crate) slope: f64,
    pub(crate) offset: f64,
}

impl Line {
    /// By least squares, error over samples: −1 is what independent samples have. The first two
    /// numbers of samples are left out where there are others: they say little of how it goes on.
    pub(crate) fn of_samples(points: &[Point]) -> Self {
        let from = if points.len() > 4 { 2 } else { 0 };
        Self::of(points[from..].iter().map(|point| (f64::from(point.spp), point.mse)))
    }

    /// Through points of positive numbers, two or more; others are left out.
    fn of(points: impl Iterator<Item = (f64, f64)>) -> Self {
        let logs: Vec<(f64, f64)> =
            points.filter(|&(x, y)| x > 0.0 && y > 0.0).map(|(x, y)| (x.ln(), y.ln())).collect();
        let n = logs.len() as f64;
        let (mx, my) = logs.iter().fold((0.0, 0.0), |(x, y), p| (x + p.0 / n, y + p.1 / n));
        let (xx, xy) = logs.iter().fold((0.0, 0.0), |(xx, xy), p| {
            (xx + (p.0 - mx) * (p.0 - mx), xy + (p.0 - mx) * (p.1 - my))
        });
        let slope = xy / xx;
        Self { slope, offset: my - slope * mx }
    }

    fn at(self, x: f64) -> f64 {
        (self.slope * x.ln() + self.offset).exp()
    }
}

/// The error after so many seconds: between the points that are nearest, on a straight line.
pub(crate) fn at_seconds(points: &[Point], seconds: f64) -> f64 {
    let after =
        points.iter().position(|point| point.seconds >= seconds).unwrap_or(points.len() - 1);
    let two = &points[after.max(1) - 1..=after.max(1)];
    Line::of(two.iter().map(|point| (point.seconds, point.mse))).at(seconds)
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
            assert!((Line::of_samples(&points).slope - slope).abs() < 1e-12);
            for seconds in [0.003, 0.01, 0.05, 0.64, 2.0] {
                let want = 3.0 * (seconds / 0.01f64).powf(slope);
                assert!((at_seconds(&points, seconds) - want).abs() < 1e-9 * want);
            }
        }
    }
}
