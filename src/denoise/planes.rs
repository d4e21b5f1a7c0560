//! Planes: one number for each pixel of a window of the image.

use std::cell::RefCell;

use crate::math::Real;
use crate::simd::{Float, LANES};

/// Planes can be read this far beyond their border, where their numbers mean nothing.
const PAD: usize = LANES;

/// The size of a window. All its rows are whole vectors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Size {
    pub(super) width: usize,
    pub(super) height: usize,
}

impl Size {
    /// Distance between rows.
    pub(super) fn stride(self) -> usize {
        self.width + 2 * PAD
    }

    /// Numbers of a plane.
    pub(super) fn count(self) -> usize {
        self.stride() * (self.height + 2 * PAD)
    }

    /// Where pixel (x, y) is in a plane.
    pub(super) fn index(self, x: usize, y: usize) -> usize {
        (y + PAD) * self.stride() + x + PAD
    }

    /// The indices of vectors that cover all pixels but `inset` at each side.
    pub(super) fn inside(self, inset: usize) -> impl Iterator<Item = usize> {
        let row = (inset / LANES * LANES..self.width - inset).step_by(LANES);
        (inset..self.height - inset).flat_map(move |y| row.clone().map(move |x| self.index(x, y)))
    }
}

/// A part of an image, whose size is `image` and which is mirrored at its border.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    pub(super) image: [usize; 2],
    /// The image's coordinates of the window's first pixel.
    pub(super) left: isize,
    pub(super) top: isize,
    pub(super) size: Size,
}

/// The pixel of a row of `count` that is seen at `x` if mirrors stand on the first and the last one. Copies of these
/// themselves would look like neighbours that agree with them.
fn mirrored(x: isize, count: usize) -> usize {
    let period = (2 * count as isize - 2).max(1);
    let x = x.rem_euclid(period);
    x.min(period - x).unsigned_abs().min(count - 1)
}

impl Window {
    /// The first numbers of each pixel in the window's part of `values`, after `convert`.
    pub(super) fn load<const N: usize>(
        &self,
        values: &[[f32; 3]],
        convert: impl Fn(f32) -> f32,
    ) -> [Plane; N] {
        let [width, height] = self.image;
        let mut planes = [(); N].map(|()| Plane::new(self.size));
        // The columns from `first` to `last` are in the image.
        let columns = self.size.width as isize;
        let first = (-self.left).clamp(0, columns);
        let last = (width as isize - self.left).clamp(first, columns);
        let from = (self.left + first).clamp(0, width as isize) as usize;
        let [first, last] = [first, last].map(isize::unsigned_abs);
        for y in 0..self.size.height {
            let row = &values[mirrored(self.top + y as isize, height) * width..][..width];
            let mut rows = planes.each_mut().map(|plane| plane.row_mut(y));
            for x in (0..first).chain(last..self.size.width) {
                let pixel = row[mirrored(self.left + x as isize, width)];
                rows.iter_mut().zip(pixel).for_each(|(row, value)| row[x] = convert(value));
            }
            let mut rows = rows.map(|row| &mut row[first..last]);
            for (x, pixel) in row[from..].iter().enumerate().take(last - first) {
                for (row, &value) in rows.iter_mut().zip(pixel) {
                    row[x] = convert(value);
                }
            }
        }
        planes
    }
}

thread_local! {
    /// Memory of earlier planes. Getting it from the system again for each tile would take half of the time of `fast`.
    static SPARE: RefCell<Vec<Vec<f32>>> = const { RefCell::new(Vec::new()) };
}

/// Gives back the memory that this thread kept for planes.
pub(super) fn forget_spare() {
    SPARE.take();
}

/// One number per pixel of a window.
#[derive(Debug)]
pub(super) struct Plane {
    size: Size,
    values: Vec<f32>,
    /// The first number. All rows begin where a vector in memory would, since others are slower to reach.
    start: usize,
}

impl Plane {
    /// A plane whose numbers mean nothing yet.
    pub(super) fn new(size: Size) -> Self {
        let mut values = SPARE.with_borrow_mut(Vec::pop).unwrap_or_default();
        values.resize(size.count() + LANES, 0.0);
        let start = values.as_ptr().align_offset(size_of::<Float>()).min(LANES);
        Self { size, values, start }
    }

    pub(super) fn zeros(size: Size) -> Self {
        let mut plane = Self::new(size);
        plane.values.fill(0.0);
        plane
    }

    /// The planes whose vectors at an index `value` computes. The index is that of other planes of this size.
    #[inline(always)]
    pub(super) fn compute<const N: usize>(
        size: Size,
        value: impl Fn(usize) -> [Float; N],
    ) -> [Self; N] {
        let mut planes = [(); N].map(|()| Self::new(size));
        for index in size.inside(0) {
            for (plane, value) in planes.iter_mut().zip(value(index)) {
                plane.set(index, value);
            }
        }
        planes
    }

    pub(super) fn size(&self) -> Size {
        self.size
    }

    #[inline(always)]
    pub(super) fn set(&mut self, index: usize, value: Float) {
        value.store(&mut self.values[self.start + index..]);
    }

    /// The vector at `index`.
    #[inline(always)]
    pub(super) fn at(&self, index: usize) -> Float {
        Float::load(&self.values[self.start + index..])
    }

    /// The vector `dx` pixels to the right of `index` and `dy` below it.
    #[inline(always)]
    pub(super) fn near(&self, index: usize, dx: isize, dy: isize) -> Float {
        self.at(index.wrapping_add_signed(dy * self.size.stride() as isize + dx))
    }

    /// All `count` numbers. Slices of one length are checked together when all are read in the same place.
    pub(super) fn numbers(&self, count: usize) -> &[f32] {
        &self.values[self.start..][..count]
    }

    /// The pixels of row `y`.
    pub(super) fn row(&self, y: usize) -> &[f32] {
        &self.values[self.start + self.size.index(0, y)..][..self.size.width]
    }

    fn row_mut(&mut self, y: usize) -> &mut [f32] {
        &mut self.values[self.start + self.size.index(0, y)..][..self.size.width]
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

impl Drop for Plane {
    fn drop(&mut self) {
        SPARE.with_borrow_mut(|spare| spare.push(std::mem::take(&mut self.values)));
    }
}

/// The planes of `a` less those of `b`.
pub(super) fn difference<const N: usize>(a: &[Plane; N], b: &[Plane; N]) -> [Plane; N] {
    Plane::compute(a[0].size(), |i| std::array::from_fn(|c| a[c].at(i) - b[c].at(i)))
}

/// The sum of the squares of all planes, times `factor`.
pub(super) fn squares(planes: &[Plane], factor: f32) -> Plane {
    let [sum] = Plane::compute(planes[0].size(), |i| {
        let squares = planes.iter().map(|plane| plane.at(i) * plane.at(i));
        [squares.fold(Float::splat(0.0), |sum, square| sum + square) * Float::splat(factor)]
    });
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(image: [usize; 2], left: isize, top: isize) -> Window {
        Window { image, left, top, size: Size { width: 2 * LANES, height: 9 } }
    }

    #[test]
    fn windows_are_mirrored_at_the_border_of_the_image() {
        let values: Vec<[f32; 3]> = (0..15).map(|pixel| [pixel as f32, 0.0, 1.0]).collect();
        let [plane, zeros, _] = window([5, 3], -3, -2).load(&values, |x| x);
        assert_eq!(plane.row(2)[..10], [3.0, 2.0, 1.0, 0.0, 1.0, 2.0, 3.0, 4.0, 3.0, 2.0]);
        assert_eq!(plane.row(0)[3..8], [10.0, 11.0, 12.0, 13.0, 14.0]);
        assert_eq!([plane.row(4)[3], plane.row(5)[3], zeros.row(1)[1]], [10.0, 5.0, 0.0]);
        // Beyond the image, and beyond its mirror.
        for (left, first) in [(5, 3.0), (7, 1.0), (-9, 1.0), (-40, 0.0)] {
            assert_eq!(
                window([5, 3], left, 0).load::<1>(&values, |x| x)[0].row(0)[0],
                first,
                "{left}"
            );
        }
        assert_eq!(
            window([1, 1], -3, -2).load::<1>(&values[7..8], |x| x)[0].row(8),
            [7.0; 2 * LANES]
        );
    }

    #[test]
    fn blurred_planes_have_the_mean_of_neighbours() {
        let values: Vec<_> = (0..360).map(|i| [(i % 40 + i / 40 * 3) as f32, 0.0, 0.0]).collect();
        let [plane] = window([40, 9], -2, 0).load(&values, |x| x);
        let blurred = plane.blurred::<2>();
        assert!((blurred.row(4)[9] - plane.row(4)[9]).abs() < 1e-4);
        // At the border, the mirrored pixels count: (2 + 1 + 0 + 1 + 2) / 5 columns from the left.
        assert!((blurred.row(4)[2] - (1.2 + 12.0)).abs() < 1e-4);
    }
}
