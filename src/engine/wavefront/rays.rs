//! The rays of a segment, in the order in which they are traced.

use super::cells::Cells;
use super::paths::{Paths, Segment};
use crate::accel::{RayBatch, RayVector};
use crate::simd::{Int, LANES};

/// Rays, and which path each is of.
#[derive(Debug)]
pub(super) struct Rays {
    pub(super) batch: RayBatch,
    /// In the order of the batch; the last is repeated until they fill a vector.
    pub(super) paths: Vec<u32>,
    /// Where the paths of each cell begin.
    pub(super) starts: Vec<u32>,
}

impl Rays {
    /// None, and room for `capacity`.
    pub(super) fn with_capacity(capacity: usize) -> Self {
        Self {
            batch: RayBatch::with_capacity(capacity),
            paths: Vec::with_capacity(capacity + LANES),
            starts: Vec::with_capacity(1 << Cells::bits_for(capacity)),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.batch.len()
    }

    /// The paths of rays `first..`, one a lane.
    #[inline(always)]
    pub(super) fn paths(&self, first: usize) -> Int {
        Int::load(&self.paths[first..])
    }

    /// Begins a wave, whose paths are numbered from 0.
    pub(super) fn begin(&mut self, paths: usize) {
        self.batch.clear();
        self.paths.clear();
        self.paths.extend(0..paths.next_multiple_of(LANES) as u32);
    }

    /// The batch of the rays of `self.paths`.
    #[inline(never)]
    pub(super) fn fill(&mut self, paths: &Paths) {
        let len = self.paths.len();
        let last = self.paths.last().copied().unwrap_or(0);
        self.paths.resize(len.next_multiple_of(LANES), last);
        self.batch.clear();
        for first in (0..len).step_by(LANES) {
            let Segment { ray, .. } = paths.segments(&paths.indices(self.paths(first)));
            self.batch.extend(&RayVector::unbounded(ray), LANES.min(len - first));
        }
    }
}
