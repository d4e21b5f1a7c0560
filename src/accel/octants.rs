//! Which way rays go.

use super::packet::Packet;
use super::rays::Rays;
use super::slab::near_and_far;
use crate::simd::{Float, axes};

/// The signs of the rays' directions as box tests need them.
pub(super) struct Octants {
    /// Whether they differ from ray to ray on some axis.
    pub(super) mixed: bool,
    /// Where a ray (where they differ: the first) goes down an axis.
    pub(super) negative: [bool; 3],
    /// Which of a box's planes it meets first, and last.
    pub(super) near: [usize; 3],
    pub(super) far: [usize; 3],
}

impl Octants {
    #[inline(always)]
    pub(super) fn new<const V: usize>(packet: &Packet<V>) -> Self {
        let first = packet.vectors.iter().find(|rays| rays.setup.active != 0);
        let first = first.unwrap_or(&packet.vectors[0]);
        let lane = first.setup.active.trailing_zeros() % 32;
        let down = |rays: &Rays, axis: usize| rays.setup.slab.inverse[axis].lt(Float::ZERO).bits();
        let negative = axes(|axis| down(first, axis) >> lane & 1 == 1);
        let differs = |axis: usize| {
            let as_first = if negative[axis] { u32::MAX } else { 0 };
            packet
                .vectors
                .iter()
                .fold(0, |bits, rays| bits | (down(rays, axis) ^ as_first) & rays.setup.active)
                != 0
        };
        let (near, far) = near_and_far(negative);
        Self { mixed: differs(0) || differs(1) || differs(2), negative, near, far }
    }
}
