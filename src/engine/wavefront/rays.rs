//! The rays of a segment, in the order in which they are traced.

use super::cells::Cells;
use super::columns::Columns;
use super::paths::{Paths, Segment};
use crate::accel::{RayBatch, RayVector};
use crate::simd::{Float, LANES, Lanes};

/// Rays, and which path each is of.
#[derive(Debug)]
pub(super) struct Rays {
    pub(super) batch: RayBatch,
    /// In the order of the batch; the last is repeated until they fill a vector.
    paths: Vec<u32>,
    /// Where the paths of each cell begin.
    starts: Vec<u32>,
}

/// Paths that go on: path, cell.
pub(super) type Next = Columns<2>;

impl Rays {
    /// None, and room for `capacity`.
    pub(super) fn with_capacity(capacity: usize) -> Self {
        Self {
            batch: RayBatch::with_capacity(capacity),
            paths: Vec::with_capacity(capacity + LANES),
            starts: Vec::with_capacity(1 << Cells::BITS),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.batch.len()
    }

    /// The paths of rays `first..`, one a lane.
    #[inline(always)]
    pub(super) fn paths(&self, first: usize) -> Lanes<u32> {
        *self.paths[first..].first_chunk().expect("whole vectors")
    }

    /// Begins a wave, whose paths are numbered from 0.
    pub(super) fn begin(&mut self, paths: usize) {
        self.batch.clear();
        self.paths.clear();
        self.paths.extend(0..paths.next_multiple_of(LANES) as u32);
    }

    /// The rays of the paths `next`, cell by cell: those that start near each other and go the same
    /// way are together.
    pub(super) fn order(&mut self, next: &Next, paths: &Paths) {
        // About as many cells as rays: more cost more than they bring.
        let bits = next.len().ilog2().clamp(3, Cells::BITS);
        let leave_out = Cells::BITS - bits;
        let starts = &mut self.starts;
        starts.clear();
        starts.resize(1 << bits, 0);
        for &cell in next.column(1) {
            starts[(cell >> leave_out) as usize] += 1;
        }
        let mut sum = 0;
        for start in starts.iter_mut() {
            sum += std::mem::replace(start, sum);
        }
        self.paths.resize(next.len(), 0);
        for (&path, &cell) in next.column(0).iter().zip(next.column(1)) {
            let place = &mut starts[(cell >> leave_out) as usize];
            self.paths[*place as usize] = path;
            *place += 1;
        }
        self.fill(paths);
    }

    /// The rays of the paths `next` as they come.
    pub(super) fn take(&mut self, next: &Next, paths: &Paths) {
        self.paths.clear();
        self.paths.extend_from_slice(next.column(0));
        self.fill(paths);
    }

    /// The batch of the rays of `self.paths`.
    fn fill(&mut self, paths: &Paths) {
        let len = self.paths.len();
        let last = self.paths.last().copied().unwrap_or(0);
        self.paths.resize(len.next_multiple_of(LANES), last);
        self.batch.clear();
        for first in (0..len).step_by(LANES) {
            let Segment { origin, time, direction, .. } = paths.segments(&self.paths(first));
            let (t_min, t_max) = (Float::ZERO, Float::INFINITY);
            let rays = RayVector { origin, direction, time, t_min, t_max };
            self.batch.extend(&rays, LANES.min(len - first));
        }
    }
}
