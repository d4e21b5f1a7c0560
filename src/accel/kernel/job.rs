//! The loop over packets, whatever is done with each.

use crate::accel::batch::{HitBatch, RayBatch};
use crate::accel::counters::Count;
use crate::accel::leaf::{BlockRef, Blocks};
use crate::accel::ray::packet::Packet;
use crate::accel::setup::Extent;
use crate::simd::{Bits, LANES, first_bits};

/// Rays to be traced, and what every one of them is tested against.
pub(crate) struct Job<'a> {
    pub(crate) rays: &'a RayBatch,
    /// The first of the rays, and the end.
    pub(crate) ends: (usize, usize),
    pub(crate) extent: &'a Extent,
    /// Blocks that every ray is tested against before the tree.
    pub(crate) blocks: &'a Blocks,
    pub(crate) spanning: &'a [BlockRef],
}

impl Job<'_> {
    /// Tests the rays, packet by packet, against the spanning blocks, then calls `search`.
    /// Returns the rays that it leaves to others, which are too wild for the box test.
    #[inline(always)]
    pub(crate) fn trace<const ANY: bool, const V: usize, C: Count>(
        &self,
        hits: &mut HitBatch,
        count: &mut C,
        mut search: impl FnMut(&mut Packet<V>, &mut C),
    ) -> Vec<usize> {
        let (first, end) = self.ends;
        let mut wild = Vec::new();
        // Loaded in place: large values that move are copied.
        let mut packet = Packet::<V>::NONE;
        for first in (first..end).step_by(V * LANES) {
            for (v, vector) in packet.vectors.iter_mut().enumerate() {
                let first = end.min(first + v * LANES);
                let rays = self.rays.vector(first);
                let wild_bits = vector.load(&rays, first_bits(end - first), self.extent);
                wild.extend(Bits(wild_bits).map(|lane| first + lane));
            }
            self.search_all::<ANY, V, C>(&mut packet, count, &mut search);
            packet.store::<ANY>(first, end, hits);
        }
        wild
    }

    /// Tests a packet against the spanning blocks, then calls `search`.
    #[inline(always)]
    pub(crate) fn search_all<const ANY: bool, const V: usize, C: Count>(
        &self,
        packet: &mut Packet<V>,
        count: &mut C,
        search: &mut impl FnMut(&mut Packet<V>, &mut C),
    ) {
        if packet.vectors.iter().all(|rays| rays.setup.active == 0) {
            return;
        }
        for &block in self.spanning {
            // Mostly huge: they are near many rays, and leave the filter no choice.
            self.blocks.test_packet::<V, ANY, ANY, true>(block, block.valid(), packet, count);
        }
        search(packet, count);
    }
}
