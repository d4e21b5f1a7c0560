//! The points where paths arrive.

use super::Shading;
use crate::engine::wavefront::paths::{History, Paths, Segment};
use crate::engine::wavefront::sort::Queue;
use crate::sampler::Randoms;
use crate::simd::{Float, Indices, Int, LANES, first_bits};

/// The end of a path's segment, one a lane.
pub(super) struct Vertex {
    pub(super) path: Indices,
    /// Lanes of paths; others repeat the last.
    pub(super) present: u32,
    /// That ends here.
    pub(super) segment: Segment,
    pub(super) t: Float,
    /// What the path has hit: a primitive or a medium.
    pub(super) primitive: Int,
    pub(super) history: History,
    pub(super) randoms: Randoms<Float>,
}

impl Shading<'_> {
    /// The vertices of the paths `first..` of `queue`.
    #[inline(always)]
    pub(super) fn vertex(&self, queue: Queue<'_>, first: usize, paths: &Paths) -> Vertex {
        let [path, t, primitive] = queue.rows(first);
        let path = paths.indices(path);
        let history = paths.histories(&path);
        Vertex {
            path,
            present: first_bits((queue.len() - first).min(LANES)),
            segment: paths.segments(&path),
            t: Float::from_bits(t),
            primitive,
            history,
            randoms: Randoms::new(self.settings.sampler, history.keys, self.segment),
        }
    }
}
