//! Sorts rays by the cells of a grid so that neighbours start near each other and have similar directions.

use glam::Vec3;

use crate::geometry::Bounds;
use crate::math::{Real, Word};
use crate::simd::{Float, Int, Vec3x, axes};

/// A grid over a scene, which numbers the cells of rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    low: Vec3,
    /// Cells per unit of length.
    scale: f32,
}

impl Cells {
    /// Number of bits of a position along an axis.
    const BITS: usize = 8;
    /// The highest position.
    const LAST: u32 = (1 << Self::BITS) - 1;

    pub(super) fn new(bounds: &Bounds) -> Self {
        let edges = bounds.max - bounds.min;
        let scale = Self::LAST as f32 / edges.max_element();
        Self { low: bounds.min, scale: if scale.is_finite() { scale } else { 1.0 } }
    }

    /// The cell numbers of rays. From the lowest bits up, a number consists of the position along
    /// each axis (8 bits each), the direction within its octant (4 bits), and the octant (3 bits).
    /// Rays that start outside the grid belong to its border.
    #[inline(always)]
    pub(super) fn of(&self, origin: Vec3x, direction: Vec3x) -> Int {
        // Adding 1.5 · 2²³ rounds to an integer and moves it to the lowest bits of the sum.
        let magic = Float::splat(12_582_912.0);
        let along = axes(|axis| {
            let at = (origin[axis] - Float::splat(self.low[axis])) * Float::splat(self.scale);
            let inside = at.max(Float::ZERO).min(Float::splat(Self::LAST as f32));
            (inside + magic).to_bits() & Int::splat(Self::LAST)
        });
        // The squares of x, y and z add up to 1, so those of x and z are enough.
        let part = axes(|axis| {
            let square = direction[axis] * direction[axis];
            (square * Float::splat(3.0) + magic).to_bits() & Int::splat(3)
        });
        let down = axes(|axis| direction[axis].to_bits() >> 31);
        along[0]
            | along[1] << 8
            | along[2] << 16
            | part[0] << 24
            | part[2] << 26
            | down[0] << 28
            | down[1] << 29
            | down[2] << 30
    }

    /// The position of a cell along `axis`.
    #[inline(always)]
    fn position(cell: u32, axis: usize) -> u32 {
        cell >> (Self::BITS * axis) & Self::LAST
    }
}

/// The box around the cells of a wave's rays. In the first segments it is small, later it covers
/// the whole scene, so positions are measured by its longest edge.
struct Region {
    low: [u32; 3],
    /// Eighths of the longest edge per cell, times 2^16, rounded up.
    scale: u32,
}

impl Region {
    /// Number of bits of a key.
    const BITS: u32 = 16;

    fn of(cells: &[u32]) -> Self {
        let (mut low, mut high) = ([Cells::LAST; 3], [0; 3]);
        for &cell in cells {
            for axis in 0..3 {
                let position = Cells::position(cell, axis);
                (low[axis], high[axis]) = (low[axis].min(position), high[axis].max(position));
            }
        }
        let [x, y, z] = axes(|axis| high[axis].saturating_sub(low[axis]));
        Self { low, scale: (8_u32 << 16).div_ceil(1 + x.max(y).max(z)) }
    }

    /// Returns how many bits of the keys, counted from the highest, to use for sorting `rays` rays.
    /// These bits distinguish about as many keys as there are rays, since more keys cost more than
    /// they gain.
    fn bits_for(rays: usize) -> u32 {
        rays.max(1).ilog2().clamp(3, Self::BITS)
    }

    /// The key by which the rays of a cell are sorted. The cell must be in the region. From the
    /// highest bits down, a key consists of the octant of the direction, the position along each
    /// axis in quarters of the longest edge, the direction within the octant, and which half of its
    /// quarter the position is in along each axis.
    #[inline(always)]
    fn key(&self, cell: u32) -> u32 {
        let eighths = |axis| ((Cells::position(cell, axis) - self.low[axis]) * self.scale) >> 16;
        let [x, y, z] = axes(eighths);
        let quarters = x >> 1 | y >> 1 << 2 | z >> 1 << 4;
        let halves = x & 1 | (y & 1) << 1 | (z & 1) << 2;
        let (octant, part) = (cell >> 28, cell >> 24 & 15);
        octant << 13 | quarters << 7 | part << 3 | halves
    }
}

/// A counting sort by the keys of cells.
#[derive(Debug, Default)]
pub(super) struct CellSort {
    /// The key of each value.
    keys: Vec<u32>,
    /// For each key, the index of its next value.
    starts: Vec<u32>,
}

impl CellSort {
    /// Replaces the contents of `list` with `values`, sorted by the keys of their `cells`. Values
    /// with the same key stay in order.
    #[inline(always)]
    pub(super) fn list(
        &mut self,
        cells: &[u32],
        values: impl Iterator<Item = u32>,
        list: &mut Vec<u32>,
    ) {
        let (region, bits) = (Region::of(cells), Region::bits_for(cells.len()));
        self.keys.reserve_exact(cells.len().saturating_sub(self.keys.len()));
        self.keys.resize(cells.len(), 0);
        self.starts.clear();
        self.starts.resize(1 << bits, 0);
        list.resize(cells.len(), 0);
        // These are slices because the pointer of a `Vec` would be loaded again after each write.
        let (keys, starts, list) = (&mut self.keys[..], &mut self.starts[..], &mut list[..]);
        // A loop of its own, which the compiler vectorizes.
        for (key, &cell) in keys.iter_mut().zip(cells) {
            *key = region.key(cell) >> (Region::BITS - bits);
        }
        for &key in &*keys {
            starts[key as usize] += 1;
        }
        let mut sum = 0;
        for start in starts.iter_mut() {
            sum += std::mem::replace(start, sum);
        }
        for (value, &key) in values.zip(&*keys) {
            let next = &mut starts[key as usize];
            list[*next as usize] = value;
            *next += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Stream, Vector};
    use crate::simd::Lanes;

    fn cells() -> Cells {
        Cells::new(&Bounds { min: Vec3::ZERO, max: Vec3::new(255.0, 100.0, 255.0) })
    }

    fn cell(origin: Vec3, direction: Vec3) -> u32 {
        cells().of(<Vec3x as Vector>::splat(origin), <Vec3x as Vector>::splat(direction)).to_array()
            [0]
    }

    /// Each property of a ray changes only its own bits of the cell number.
    #[test]
    fn fields_have_separate_bits() {
        let along = crate::math::normalize(Vec3::new(0.1, 1.0, 0.1));
        let base = cell(Vec3::ZERO, along);
        assert_eq!(base, 0);
        for (axis, by) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().enumerate() {
            for position in [1, 17, 255] {
                assert_eq!(cell(by * position as f32, along), position << (8 * axis));
            }
            let mirrored = Vec3::ONE - 2.0 * by;
            assert_eq!(cell(Vec3::ZERO, along * mirrored), 1 << (28 + axis));
        }
        for outside in [-1.0, -300.0, f32::NEG_INFINITY, f32::NAN] {
            assert_eq!(cell(Vec3::X * outside, along), 0);
        }
        for outside in [256.0, 1000.0, 1e38, f32::INFINITY] {
            assert_eq!(cell(Vec3::Y * outside, along), 255 << 8);
        }
        for (direction, part) in [(Vec3::X, 3), (Vec3::Z, 3 << 2), (Vec3::Y, 0)] {
            assert_eq!(cell(Vec3::ZERO, direction) >> 24, part);
        }
    }

    #[test]
    fn keys_compare_octant_then_quarter_then_direction_then_half() {
        let turned = crate::math::normalize(Vec3::new(1.0, 0.1, 0.1));
        // The longest edge of the region is 80 long, so a quarter is 20.
        let corner = Vec3::new(100.0, 50.0, 30.0);
        let rays = [
            (corner, Vec3::Y),
            (corner + Vec3::X * 11.0, Vec3::Y),
            (corner, turned),
            (corner + Vec3::X * 21.0, Vec3::Y),
            (corner + Vec3::X * 79.0, Vec3::Y),
            (corner + Vec3::Y * 21.0, Vec3::Y),
            (corner + Vec3::Z * 41.0, turned),
            (corner, Vec3::NEG_Y),
        ];
        let numbers = rays.map(|(origin, direction)| cell(origin, direction));
        let region = Region::of(&numbers);
        let keys = numbers.map(|number| region.key(number));
        assert!(keys.is_sorted_by(|a, b| a < b), "{keys:?}");
        // The same rays elsewhere in the scene have the same keys.
        let moved = rays.map(|(origin, direction)| cell(origin + Vec3::X * 70.0, direction));
        let region = Region::of(&moved);
        assert_eq!(moved.map(|number| region.key(number)), keys);
    }

    #[test]
    fn eighths_of_all_regions_are_exact() {
        for edge in 0..=Cells::LAST {
            for axis in 0..3 {
                let at = |position: u32| position << (Cells::BITS * axis);
                let region = Region::of(&[0, at(edge)]);
                for position in 0..=edge {
                    let eighth = 8 * position / (edge + 1);
                    let expected = eighth >> 1 << (7 + 2 * axis) | (eighth & 1) << axis;
                    assert_eq!(region.key(at(position)), expected, "{position} of {edge}");
                }
            }
        }
    }

    #[test]
    fn lists_are_sorted_and_stable() {
        let mut random = Stream::new(4);
        let (mut sort, mut list) = (CellSort::default(), Vec::new());
        for rays in [3000, 0, 1, 70] {
            let cells: Vec<u32> = (0..rays).map(|_| random.bits() as u32 & 0x7F03_0703).collect();
            sort.list(&cells, 7.., &mut list);
            let region = Region::of(&cells);
            let left_out = Region::BITS - Region::bits_for(rays);
            let key = |&value: &u32| region.key(cells[value as usize - 7]) >> left_out;
            assert!(list.is_sorted_by_key(|value| (key(value), *value)));
            list.sort_unstable();
            assert_eq!(list, (7..rays as u32 + 7).collect::<Vec<_>>());
        }
    }

    /// Every key is a valid index into the table of counts, even for rays with non-finite or
    /// extreme components.
    #[test]
    fn keys_are_in_range() {
        let (mut random, odd) =
            (Stream::new(3), [f32::NAN, f32::INFINITY, -0.0, 1e38, 1e-45, -7.0]);
        for _ in 0..10_000 {
            let mut number = || match random.bits() as usize % 12 {
                i if i < odd.len() => odd[i],
                _ => random.between(-20.0, 400.0),
            };
            let mut lanes = || std::array::from_fn(|_| number());
            let mut vector = || Vec3x::of_lanes(&[lanes(), lanes(), lanes()]);
            let numbers: Lanes<u32> = cells().of(vector(), vector()).to_array();
            let region = Region::of(&numbers);
            let keys = numbers.map(|number| region.key(number));
            assert!(keys.iter().all(|&key| key < 1 << Region::BITS), "{keys:?}");
        }
        assert_eq!([0, 1, 8, 4095, 4096, 1 << 20].map(Region::bits_for), [3, 3, 3, 11, 12, 16]);
    }
}
