//! Measures the differences between two images.

use super::{Image, Transfer};
use crate::error::{Error, Result};

/// Differences between two images of the same size. Sums are in f64.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Comparison {
    /// Whether all bits agree.
    pub identical: bool,
    /// Mean squared error over pixels and channels.
    pub mse: f64,
    /// Mean of (a − b)² / (b² + 0.01): the error relative to the second image, where 0.01 avoids a
    /// division by zero at black pixels (Rousselle et al. 2011).
    pub relative_mse: f64,
    /// Peak signal-to-noise ratio in dB for a peak of 1; infinite if the MSE is 0.
    pub psnr: f64,
    /// Largest absolute difference of a channel.
    pub largest: f64,
    /// Pixel with the largest difference, counted from the top left.
    pub largest_at: (u32, u32),
    /// Mean of the first image divided by the mean of the second.
    pub ratio_of_means: f64,
}

/// Compares `a` with the reference `b`. Returns the measures, and an image of the differences in
/// false colours. With `display`, it compares display values instead of linear ones. Display
/// values are clamped to `[0, 1]`, mapped by the curve, and not rounded.
///
/// # Errors
/// [`Error::Usage`] if the sizes differ.
pub(crate) fn compare(
    a: &Image,
    b: &Image,
    display: Option<Transfer>,
) -> Result<(Comparison, Image)> {
    if (a.width, a.height) != (b.width, b.height) {
        return Err(Error::Usage(format!(
            "cannot compare images of different sizes: {} × {} and {} × {}",
            a.width, a.height, b.width, b.height
        )));
    }
    let value = |v: f32| match display {
        None => f64::from(v),
        Some(transfer) => transfer.display(v),
    };
    let mut sums = [0.0; 4];
    let mut largest = (0.0, 0);
    let mut differences = Vec::with_capacity(a.pixels.len());
    for (i, (pa, pb)) in a.pixels.iter().zip(&b.pixels).enumerate() {
        let mut worst = 0.0f64;
        for (&va, &vb) in pa.iter().zip(pb) {
            let (va, vb) = (value(va), value(vb));
            // Equal infinities do not differ.
            let d = if va == vb { 0.0 } else { (va - vb).abs() };
            let d2 = d * d;
            sums[0] += d2;
            sums[1] += d2 / (vb * vb + 0.01);
            sums[2] += va;
            sums[3] += vb;
            // NaN counts as the largest difference.
            worst = if d <= worst { worst } else { d };
        }
        if !(worst <= largest.0) {
            largest = (worst, i);
        }
        differences.push(worst);
    }
    let n = (a.pixels.len() * 3) as f64;
    let mse = sums[0] / n;
    let comparison = Comparison {
        identical: a.hash() == b.hash(),
        mse,
        relative_mse: sums[1] / n,
        psnr: -10.0 * mse.log10(),
        largest: largest.0,
        largest_at: (largest.1 as u32 % a.width, largest.1 as u32 / a.width),
        ratio_of_means: if sums[2] == sums[3] { 1.0 } else { sums[2] / sums[3] },
    };
    let pixels = differences.iter().map(|&d| false_colour(d / largest.0)).collect();
    Ok((comparison, Image::from_pixels(a.width, a.height, pixels)))
}

/// Maps `x` in `[0, 1]` to a colour from black through red and yellow to white. The colour shows
/// the square root of `x`, so that small differences are visible.
fn false_colour(x: f64) -> [f32; 3] {
    let s = 3.0 * x.sqrt() as f32;
    [s, s - 1.0, s - 2.0].map(|c| crate::math::clamp(c, 0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measures_match_values_computed_by_hand() {
        let a = Image::from_pixels(2, 1, vec![[1.0; 3], [0.5, 0.5, 0.8]]);
        let b = Image::from_pixels(2, 1, vec![[1.0; 3], [0.5; 3]]);
        let (c, heatmap) = compare(&a, &b, None).unwrap();
        assert!(!c.identical);
        assert!((c.mse - 0.09 / 6.0).abs() < 1e-7);
        assert!((c.relative_mse - 0.09 / 0.26 / 6.0).abs() < 1e-6);
        assert!((c.psnr - 18.239).abs() < 1e-3);
        assert!((c.largest - 0.3).abs() < 1e-6);
        assert_eq!(c.largest_at, (1, 0));
        assert!((c.ratio_of_means - 4.8 / 4.5).abs() < 1e-6);
        assert_eq!(heatmap.pixels(), [[0.0; 3], [1.0; 3]]);

        let (same, _) = compare(&a, &a, None).unwrap();
        assert!(same.identical && same.mse == 0.0 && same.psnr == f64::INFINITY);
        assert!(compare(&a, &Image::new(1, 1), None).is_err());
    }

    #[test]
    fn as_displayed_clamps_and_applies_the_curve() {
        let a = Image::from_pixels(1, 1, vec![[9.0, 0.25, -1.0]]);
        let b = Image::from_pixels(1, 1, vec![[1.0, 0.0, 0.0]]);
        let (c, _) = compare(&a, &b, Some(Transfer::Gamma2)).unwrap();
        assert!((c.mse - 0.25 / 3.0).abs() < 1e-12, "{}", c.mse);
    }

    #[test]
    fn nan_is_the_largest_difference() {
        let a = Image::from_pixels(2, 1, vec![[1.0; 3], [f32::NAN; 3]]);
        let (c, _) = compare(&a, &Image::new(2, 1), None).unwrap();
        assert!(c.largest.is_nan());
        assert_eq!(c.largest_at, (1, 0));
    }
}
