//! The loop over packets, which all packet kernels share.

use crate::accel::ray::Packet;
use crate::accel::{Count, Extent, HitBatch, LeafBlocks, LeafRef, NoMeshes, RayBatch};
use crate::simd::{Bits, LANES, first_bits};

/// Rays to trace, and the scene data that all of them need.
pub(crate) struct TraceJob<'a> {
    pub(crate) rays: &'a RayBatch,
    /// Index of the first ray, and one past the last.
    pub(crate) ends: (usize, usize),
    pub(crate) extent: &'a Extent,
    /// The table that contains the `spanning` blocks.
    pub(crate) blocks: &'a LeafBlocks,
    /// Blocks that every ray is tested against before the tree.
    pub(crate) spanning: &'a [LeafRef],
    /// The number of the first triangle of a mesh.
    pub(crate) meshes: u32,
}

impl TraceJob<'_> {
    /// Tests the rays, packet by packet, against the spanning blocks, then calls `search`. Returns
    /// the indices of the wild rays (see [`Rays::load`](crate::accel::ray::Rays::load)),
    /// which are left to the scalar reference.
    #[inline(always)]
    pub(crate) fn trace<const ANY: bool, const INSTANCES: bool, const V: usize, C: Count>(
        &self,
        hits: &mut HitBatch,
        count: &mut C,
        mut search: impl FnMut(&mut Packet<V>, &mut C),
    ) -> Vec<usize> {
        let (first, end) = self.ends;
        let mut wild = Vec::new();
        // Packets are loaded in place, since moving large values copies them.
        let mut packet = Packet::<V>::NONE;
        for first in (first..end).step_by(V * LANES) {
            for (v, vector) in packet.vectors.iter_mut().enumerate() {
                let first = end.min(first + v * LANES);
                let rays = self.rays.vector(first);
                let wild_bits = vector.load(&rays, first_bits(end - first), self.extent);
                wild.extend(Bits(wild_bits).map(|lane| first + lane));
            }
            if packet.vectors.iter().any(|rays| rays.setup.active != 0) {
                for &block in self.spanning {
                    // Spanning primitives are mostly huge, so that only shadow rays often all miss
                    // one.
                    self.blocks.test_packet::<V, ANY, ANY, true>(
                        block,
                        block.valid(),
                        &mut packet,
                        &mut NoMeshes,
                        count,
                    );
                }
                search(&mut packet, count);
            }
            packet.store::<ANY>(first, end, hits);
            if INSTANCES && !ANY && hits.has_instances() {
                let end = end.min(first + V * LANES);
                packet.store_instances(first, end, self.meshes, hits);
            }
        }
        wild
    }
}
