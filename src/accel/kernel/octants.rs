//! The octants of a packet's rays.

use crate::accel::ray::{Packet, Rays};
use crate::math::Real;
use crate::simd::{Float, axes};

/// The signs of the rays' directions.
pub(crate) struct Octants {
    /// Whether the directions of the active rays differ in sign on some axis.
    pub(crate) mixed: bool,
    /// For each axis, whether the directions of most active rays are negative along it.
    pub(crate) negative: [bool; 3],
}

impl Octants {
    #[inline(always)]
    pub(crate) fn new<const V: usize>(packet: &Packet<V>) -> Self {
        let active: u32 = packet.vectors.iter().map(|rays| rays.setup.active.count_ones()).sum();
        let down = axes(|axis| {
            let down = |rays: &Rays| rays.setup.slab.inverse[axis].lt(Float::ZERO).bits();
            let count = |rays: &Rays| (down(rays) & rays.setup.active).count_ones();
            packet.vectors.iter().map(count).sum::<u32>()
        });
        let negative = axes(|axis| 2 * down[axis] > active);
        let differs = |axis: usize| down[axis] != 0 && down[axis] != active;
        Self { mixed: differs(0) || differs(1) || differs(2), negative }
    }
}
