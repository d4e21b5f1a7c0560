//! Cells: rays of a cell start near each other and go the same way.

use glam::Vec3;

use crate::geometry::Bounds;
use crate::simd::{Float, Int, Vec3x, axes};

/// A grid over a scene. Cells that are eight apart along an axis share their number: the rays of a
/// wave, which comes from a small part of the image, mostly start close together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    low: Vec3,
    /// Cells a unit of length.
    scale: f32,
}

impl Cells {
    /// How many there are.
    pub(super) const COUNT: usize = 8 * 8 * 8 * 8;
    /// Along the longest edge of a scene.
    const ACROSS: f32 = 32.0;

    pub(super) fn new(bounds: &Bounds) -> Self {
        let edges = bounds.max - bounds.min;
        let scale = Self::ACROSS / edges.max_element();
        Self { low: bounds.min, scale: if scale.is_finite() { scale } else { 1.0 } }
    }

    /// The cells of rays.
    #[inline(always)]
    pub(super) fn of(&self, origin: Vec3x, direction: Vec3x) -> Int {
        // 1.5 · 2²³: the sum is rounded to an integer, which is in its last bits.
        let magic = Float::splat(12_582_912.0);
        let place = axes(|axis| {
            let place = (origin[axis] - Float::splat(self.low[axis])) * Float::splat(self.scale);
            (place + magic).to_bits() & Int::splat(7)
        });
        let down = axes(|axis| direction[axis].to_bits().shifted_down(31));
        place[0]
            | place[1].shifted_up(3)
            | place[2].shifted_up(6)
            | down[0].shifted_up(9)
            | down[1].shifted_up(10)
            | down[2].shifted_up(11)
    }
}
