//! The rays of a segment, in the order of tracing.

use super::{CellSort, Paths, Segment};
use crate::accel::{RayBatch, RayVector};
use crate::simd::{Int, LANES};

/// Rays and the paths to which they belong.
#[derive(Debug)]
pub(super) struct WaveRays {
    pub(super) batch: RayBatch,
    /// The path of each ray in the batch, padded to a multiple of [`LANES`].
    pub(super) paths: Vec<u32>,
    pub(super) sort: CellSort,
}

impl WaveRays {
    /// Creates an empty list with room for `capacity` rays.
    pub(super) fn with_capacity(capacity: usize) -> Self {
        Self {
            batch: RayBatch::with_capacity(capacity),
            paths: Vec::with_capacity(capacity + LANES),
            sort: CellSort::default(),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.batch.len()
    }

    /// The paths of the rays from `first` on, one per lane.
    #[inline(always)]
    pub(super) fn paths(&self, first: usize) -> Int {
        Int::load(&self.paths[first..])
    }

    /// Begins a wave of `paths` paths, numbered from 0. The caller adds their rays to the batch.
    pub(super) fn begin(&mut self, paths: usize) {
        self.batch.clear();
        self.paths.clear();
        self.paths.extend(0..paths.next_multiple_of(LANES) as u32);
    }

    /// Fills the batch with the rays of `self.paths`, and pads `self.paths` with the last path.
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
