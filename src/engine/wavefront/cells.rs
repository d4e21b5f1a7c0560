//! Cells: rays of a cell start near each other and go the same way.

use glam::Vec3;

use crate::geometry::Bounds;
use crate::simd::{Float, Int, LANES, Vec3x, axes};

/// A grid over a scene. Cells that are eight apart along an axis share their number: the rays of a
/// wave, which comes from a small part of the image, mostly start close together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    low: Vec3,
    /// Cells a unit of length.
    scale: f32,
}

impl Cells {
    /// Bits of a cell's number.
    pub(super) const BITS: u32 = 16;
    /// Along the longest edge of a scene.
    const ACROSS: f32 = 24.0;

    pub(super) fn new(bounds: &Bounds) -> Self {
        let edges = bounds.max - bounds.min;
        let scale = Self::ACROSS / edges.max_element();
        Self { low: bounds.min, scale: if scale.is_finite() { scale } else { 1.0 } }
    }

    /// The cells of rays. From the highest bits: the octant of the direction; the place by fours of
    /// cells; the direction within the octant; the place within the fours. The lowest bits may be
    /// left out.
    #[inline(always)]
    pub(super) fn of(&self, origin: Vec3x, direction: Vec3x) -> Int {
        // 1.5 · 2²³: the sum is rounded to an integer, which is in its last bits.
        let magic = Float::splat(12_582_912.0);
        let place = axes(|axis| {
            let place = (origin[axis] - Float::splat(self.low[axis])) * Float::splat(self.scale);
            SPREAD.shuffled((place + magic).to_bits() & Int::splat(7))
        });
        // The squares of x, y, z add up to 1: two of them tell the third.
        let part = axes(|axis| {
            let square = direction[axis] * direction[axis];
            (square * Float::splat(3.0) + magic).to_bits() & Int::splat(3)
        });
        let down = axes(|axis| direction[axis].to_bits().shifted_down(31));
        place[0]
            | place[1].shifted_up(1)
            | place[2].shifted_up(2)
            | part[0].shifted_up(3)
            | part[2].shifted_up(5)
            | down[0].shifted_up(13)
            | down[1].shifted_up(14)
            | down[2].shifted_up(15)
    }
}

/// The bits of each number below 8, where those of a place along x go.
const SPREAD: Int = {
    let (mut spread, mut number) = ([0; LANES], 0);
    while number < 8 {
        let n = number as u32;
        spread[number] = n & 1 | (n & 2) << 6 | (n & 4) << 8;
        number += 1;
    }
    Int::new(spread)
};
