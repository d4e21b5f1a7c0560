//! Cells: groups of rays that start near each other and have similar directions.

use glam::Vec3;

use crate::geometry::Bounds;
use crate::simd::{Float, Int, LANES, Vec3x, axes};

/// A grid over a scene. Cells eight apart along an axis share a number. This rarely matters: a wave
/// covers a small part of the image, so its rays mostly start close together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    low: Vec3,
    /// Cells per unit of length.
    scale: f32,
}

impl Cells {
    /// Number of bits of a cell number.
    pub(super) const BITS: u32 = 16;
    /// Number of cells along the longest edge of a scene.
    const ACROSS: f32 = 24.0;

    pub(super) fn new(bounds: &Bounds) -> Self {
        let edges = bounds.max - bounds.min;
        let scale = Self::ACROSS / edges.max_element();
        Self { low: bounds.min, scale: if scale.is_finite() { scale } else { 1.0 } }
    }

    /// Returns how many bits of the cell numbers, counted from the highest, to use for sorting
    /// `rays` rays. These bits distinguish about as many cells as there are rays, since more cells
    /// cost more than they gain.
    pub(super) fn bits_for(rays: usize) -> u32 {
        rays.max(1).ilog2().clamp(3, Self::BITS)
    }

    /// The cell numbers of rays. From the highest bits down, a number consists of the octant of the
    /// direction, the position along each axis in units of two cells, the direction within the
    /// octant, and which of the two cells it is along each axis. The lowest bits may be ignored.
    #[inline(always)]
    pub(super) fn of(&self, origin: Vec3x, direction: Vec3x) -> Int {
        // Adding 1.5 · 2²³ rounds to an integer and moves it to the lowest bits of the sum.
        let magic = Float::splat(12_582_912.0);
        let position = axes(|axis| {
            let position = (origin[axis] - Float::splat(self.low[axis])) * Float::splat(self.scale);
            SPREAD.shuffled((position + magic).to_bits() & Int::splat(7))
        });
        // The squares of x, y and z add up to 1, so those of x and z are enough.
        let part = axes(|axis| {
            let square = direction[axis] * direction[axis];
            (square * Float::splat(3.0) + magic).to_bits() & Int::splat(3)
        });
        let down = axes(|axis| direction[axis].to_bits() >> 31);
        position[0]
            | position[1] << 1
            | position[2] << 2
            | part[0] << 3
            | part[2] << 5
            | down[0] << 13
            | down[1] << 14
            | down[2] << 15
    }
}

/// A counting sort by cell.
#[derive(Debug, Default)]
pub(super) struct CellSort {
    /// For each cell, the index of its next value.
    starts: Vec<u32>,
}

impl CellSort {
    /// Replaces the contents of `list` with `values`, sorted by `cells`. Values of the same cell stay
    /// in order.
    #[inline(always)]
    pub(super) fn list(
        &mut self,
        cells: &[u32],
        values: impl Iterator<Item = u32>,
        list: &mut Vec<u32>,
    ) {
        let bits = Cells::bits_for(cells.len());
        let leave_out = Cells::BITS - bits;
        self.starts.clear();
        self.starts.resize(1 << bits, 0);
        list.resize(cells.len(), 0);
        // These are slices because the pointer of a `Vec` would be loaded again after each write.
        let (starts, list) = (&mut self.starts[..], &mut list[..]);
        for &cell in cells {
            starts[(cell >> leave_out) as usize] += 1;
        }
        let mut sum = 0;
        for start in starts.iter_mut() {
            sum += std::mem::replace(start, sum);
        }
        for (value, &cell) in values.zip(cells) {
            let next = &mut starts[(cell >> leave_out) as usize];
            list[*next as usize] = value;
            *next += 1;
        }
    }
}

/// The bits of each number below 8, moved to the bits of a cell number that hold a position along
/// x.
const SPREAD: Int = {
    let (mut spread, mut number) = ([0; LANES], 0);
    while number < 8 {
        let n = number as u32;
        spread[number] = n & 1 | (n & 2) << 6 | (n & 4) << 8;
        number += 1;
    }
    Int::new(spread)
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vector;
    use crate::math::random::Stream;
    use crate::simd::Lanes;

    fn cells() -> Cells {
        Cells::new(&Bounds { min: Vec3::splat(-12.0), max: Vec3::splat(12.0) })
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
        let position = |x: f32, y: f32, z: f32| cell(Vec3::new(x, y, z), along) ^ base;
        assert_eq!(
            [position(1.0, 0.0, 0.0), position(0.0, 1.0, 0.0), position(0.0, 0.0, 1.0)],
            [1, 2, 4]
        );
        for (axis, by) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().enumerate() {
            for cells in 2..8 {
                let changed = cell(by * cells as f32, along) ^ base;
                assert_eq!(changed & !((1 | 1 << 7 | 1 << 10) << axis), 0, "{changed:b}");
            }
            assert_eq!(cell(by * 8.0, along), base, "cells eight apart share their number");
            let mirrored = Vec3::ONE - 2.0 * by;
            assert_eq!(cell(Vec3::ZERO, along * mirrored) ^ base, 1 << (13 + axis));
        }
        for (direction, part) in [(Vec3::X, 3), (Vec3::Z, 3 << 2), (Vec3::Y, 0)] {
            assert_eq!(cell(Vec3::ZERO, direction) >> 3 & 15, part);
        }
    }

    /// Every cell number is a valid index into the table of counts, even for rays with non-finite
    /// or extreme components.
    #[test]
    fn cell_numbers_are_in_range() {
        let (mut random, odd) =
            (Stream::new(3), [f32::NAN, f32::INFINITY, -0.0, 1e38, 1e-45, -7.0]);
        for _ in 0..10_000 {
            let mut number = || match random.bits() as usize % 12 {
                i if i < odd.len() => odd[i],
                _ => random.between(-20.0, 20.0),
            };
            let mut lanes = || std::array::from_fn(|_| number());
            let mut vector = || Vec3x::of_lanes(&[lanes(), lanes(), lanes()]);
            let numbers: Lanes<u32> = cells().of(vector(), vector()).to_array();
            assert!(numbers.iter().all(|&number| number < 1 << Cells::BITS), "{numbers:?}");
        }
        assert_eq!([0, 1, 8, 4095, 4096, 1 << 20].map(Cells::bits_for), [3, 3, 3, 11, 12, 16]);
    }
}
