//! Vertices: the points at which the segments of paths end.

use super::Shading;
use crate::engine::wavefront::paths::{History, Paths, Segment};
use crate::engine::wavefront::sort::Queue;
use crate::sampler::Randoms;
use crate::simd::{Float, Indices, Int, LANES, first_bits};

/// The ends of segments, one per lane.
pub(super) struct Vertex {
    pub(super) path: Indices,
    /// Bits of the lanes that have a path. Other lanes repeat the last path.
    pub(super) present: u32,
    /// The segment that ends here.
    pub(super) segment: Segment,
    pub(super) t: Float,
    /// The number of the primitive or the medium that the path has hit.
    pub(super) primitive: Int,
    pub(super) history: History,
    pub(super) randoms: Randoms<Float>,
}

impl Shading<'_> {
    /// Returns the vertices of up to [`LANES`] paths of `queue`, from index `first` on.
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
