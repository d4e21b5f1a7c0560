//! The kernel `flat`, which tests packets against every primitive, without boxes.

use super::job::TraceJob;
use crate::accel::ray::VECTORS;
use crate::accel::{Count, Extent, HitBatch, LeafBlocks, LeafRef};
use crate::geometry::{Bounds, Geometry};

/// All primitives, without boxes.
#[derive(Debug)]
pub(crate) struct Flat {
    blocks: LeafBlocks,
    all: Vec<LeafRef>,
    extent: Extent,
}

impl Flat {
    /// Lays out a scene whose primitives lie in `bounds`.
    pub(crate) fn new(geometry: &Geometry, bounds: Bounds) -> Self {
        let mut blocks = LeafBlocks::default();
        let each: Vec<u32> = (0..geometry.len() as u32).collect();
        let all = blocks.push_all(geometry, &each);
        Self { blocks, all, extent: Extent::new(geometry, bounds, Bounds::EMPTY) }
    }

    /// Size in memory.
    pub(crate) fn bytes(&self) -> usize {
        self.blocks.bytes()
    }

    /// Tests the rays of `job` against all primitives. Returns the indices of the wild rays (see
    /// `Setup::load`), which are left to the scalar reference.
    #[inline(never)] // so that profilers find it
    pub(crate) fn trace<const ANY: bool, C: Count>(
        &self,
        job: &TraceJob<'_>,
        hits: &mut HitBatch,
        count: &mut C,
    ) -> Vec<usize> {
        let Self { blocks, all, extent } = self;
        let job = TraceJob { blocks, spanning: all, extent, ..*job };
        job.trace::<ANY, false, VECTORS, C>(hits, count, |_, _| {})
    }
}
