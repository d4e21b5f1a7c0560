//! Planes: one number per pixel, with a margin, so that the neighbours of pixels at the border can be read.

use rayon::prelude::*;

use crate::math::Real;
use crate::simd::{Float, LANES};

/// Width of the margin, which mirrors the image at its border. No filter reaches further.
pub(super) const MARGIN: usize = 8;

/// The size of an image, and the layout of its planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Size {
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Size {
    /// Distance between rows. The last vector of a row may reach beyond the image.
    pub(super) fn stride(self) -> usize {
        self.width.next_multiple_of(LANES) + LANES + 2 * MARGIN
    }

    pub(super) fn len(self) -> usize {
        self.stride() * (self.height + 2 * MARGIN)
    }

    /// Where pixel (x, y) is in a plane.
    pub(super) fn index(self, x: usize, y: usize) -> usize {
        (y + MARGIN) * self.stride() + x + MARGIN
    }

    /// The first pixels of all vectors of a row.
    pub(super) fn vectors(self) -> impl Iterator<Item = usize> {
        (0..self.width).step_by(LANES)
    }
}

/// One number per pixel.
#[derive(Clone, Debug)]
pub(super) struct Plane {
    size: Size,
    values: Vec<f32>,
}

impl Plane {
    /// The planes whose bands of `high` rows `work` writes, given the number of the first row. Bands include the margin
    /// to the left and right, which is written afterwards.
    pub(super) fn by_bands<const N: usize>(
        size: Size,
        high: usize,
        work: impl Fn(usize, &mut [&mut [f32]; N]) + Sync,
    ) -> [Self; N] {
        let stride = size.stride();
        let mut planes = [(); N].map(|()| vec![0.0; size.len()]);
        let inside = MARGIN * stride..(MARGIN + size.height) * stride;
        let mut parts =
            planes.each_mut().map(|plane| plane[inside.clone()].chunks_mut(high * stride));
        let mut bands: Vec<[&mut [f32]; N]> = Vec::new();
        for _ in (0..size.height).step_by(high) {
            bands.push(parts.each_mut().map(|part| part.next().expect("a band of each plane")));
        }
        bands.into_par_iter().enumerate().for_each(|(band, mut parts)| {
            work(band * high, &mut parts);
            for row in parts.into_iter().flat_map(|part| part.chunks_exact_mut(stride)) {
                extend(row, size.width);
            }
        });
        planes.map(|values| Self { size, values }.extended())
    }

    /// The planes whose vectors at an index `value` computes. The index is that of other planes of this size.
    pub(super) fn compute<const N: usize>(
        size: Size,
        value: impl Fn(usize) -> [Float; N] + Sync,
    ) -> [Self; N] {
        Self::by_bands(size, 1, |y, rows| {
            for x in size.vectors() {
                let values = value(size.index(x, y));
                for (row, value) in rows.iter_mut().zip(values) {
                    value.store(&mut row[MARGIN + x..]);
                }
            }
        })
    }

    /// The planes of the numbers of each pixel, row by row.
    pub(super) fn of_rows<const N: usize>(
        size: Size,
        value: impl Fn(usize) -> [f32; N] + Sync,
    ) -> [Self; N] {
        let first = size.index(0, 0);
        Self::compute(size, |index| {
            let (x, y) = ((index - first) % size.stride(), (index - first) / size.stride());
            let mut lanes = [[0.0; LANES]; N];
            for lane in 0..LANES.min(size.width - x) {
                let values = value(y * size.width + x + lane);
                lanes.iter_mut().zip(values).for_each(|(lanes, value)| lanes[lane] = value);
            }
            lanes.map(Float::new)
        })
    }

    /// Mirrors rows at the first and the last one into the margin.
    fn extended(mut self) -> Self {
        let (stride, height) = (self.size.stride(), self.size.height);
        for k in 1..=MARGIN {
            let from = k.min(height - 1);
            for (from, to) in [(from, MARGIN - k), (height - 1 - from, MARGIN + height - 1 + k)] {
                let from = (MARGIN + from) * stride;
                self.values.copy_within(from..from + stride, to * stride);
            }
        }
        self
    }

    pub(super) fn size(&self) -> Size {
        self.size
    }

    /// The vector at `index`.
    #[inline(always)]
    pub(super) fn at(&self, index: usize) -> Float {
        Float::load(&self.values[index..])
    }

    /// The vector `dx` pixels to the right of `index` and `dy` below it.
    #[inline(always)]
    pub(super) fn near(&self, index: usize, dx: isize, dy: isize) -> Float {
        self.at(index.wrapping_add_signed(dy * self.size.stride() as isize + dx))
    }

    /// The number of pixel (x, y).
    pub(super) fn pixel(&self, x: usize, y: usize) -> f32 {
        self.values[self.size.index(x, y)]
    }

    /// The mean of the numbers within `reach` pixels to each side.
    pub(super) fn blurred<const REACH: isize>(&self) -> Self {
        let factor = Float::splat(1.0 / (2 * REACH + 1) as f32);
        let mean = |plane: &Self, dx: isize, dy: isize| {
            let [mean] = Self::compute(self.size, |index| {
                let near = |k| plane.near(index, k * dx, k * dy);
                [(1 - REACH..=REACH).fold(near(-REACH), |sum, k| sum + near(k)) * factor]
            });
            mean
        };
        mean(&mean(self, 1, 0), 0, 1)
    }
}

/// Mirrors a row at its first and its last pixel into its margin. Copies of these pixels themselves would look like
/// neighbours that agree with them.
fn extend(row: &mut [f32], width: usize) {
    let (first, last) = (MARGIN, MARGIN + width - 1);
    let beyond = row[last];
    row[last + 1..].fill(beyond);
    for k in 1..=MARGIN {
        let from = k.min(width - 1);
        row[first - k] = row[first + from];
        row[last + k] = row[last - from];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_are_mirrored_at_their_border() {
        let size = Size { width: 5, height: 3 };
        let [plane] = Plane::of_rows(size, |pixel| [pixel as f32]);
        assert_eq!([plane.pixel(0, 0), plane.pixel(4, 2)], [0.0, 14.0]);
        let near = |x, y, dx, dy| plane.near(size.index(x, y), dx, dy).first();
        assert_eq!([near(0, 0, -1, 0), near(0, 0, -3, 1), near(0, 0, -8, -8)], [1.0, 8.0, 14.0]);
        assert_eq!([near(4, 2, 1, 0), near(4, 2, 0, 2), near(4, 2, 8, 8)], [13.0, 4.0, 0.0]);
        let [one] = Plane::of_rows(Size { width: 1, height: 1 }, |_| [3.0]);
        assert_eq!(one.near(one.size().index(0, 0), -8, 8).first(), 3.0);
    }

    #[test]
    fn blurred_planes_have_the_mean_of_neighbours() {
        let size = Size { width: 40, height: 9 };
        let [plane] =
            Plane::of_rows(size, |pixel| [(pixel % 40) as f32 + 3.0 * (pixel / 40) as f32]);
        let blurred = plane.blurred::<2>();
        assert!((blurred.pixel(20, 4) - plane.pixel(20, 4)).abs() < 1e-4);
        // At the border, the margin counts: (2 + 1 + 0 + 1 + 2) / 5 columns from the left.
        assert!((blurred.pixel(0, 4) - (1.2 + 12.0)).abs() < 1e-4);
    }
}
