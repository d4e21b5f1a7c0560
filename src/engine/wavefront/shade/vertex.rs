//! Vertices: the points at which the segments of paths end.

use super::ShadeInputs;
use crate::engine::wavefront::{History, Paths, Queue, Segment};
use crate::geometry::Hit;
use crate::math::Real;
use crate::sampler::Randoms;
use crate::simd::{Float, Indices, Int, LANES, first_bits};

/// The ends of segments, one per lane.
pub(in super::super) struct Vertex {
    pub(in super::super) path: Indices,
    /// Bits of the lanes that have a path. Other lanes repeat the last path.
    pub(in super::super) present: u32,
    /// The segment that ends here.
    pub(in super::super) segment: Segment,
    /// The hit of the segment. For a collision in a medium, the primitive is the medium's number.
    pub(in super::super) hit: Hit<Float>,
    pub(in super::super) history: History,
    pub(in super::super) randoms: Randoms<Float>,
}

impl ShadeInputs<'_> {
    /// Returns the vertices of up to [`LANES`] paths of `queue`, from index `first` on. `instanced`
    /// is set if they are on instances.
    #[inline(always)]
    pub(in super::super) fn vertex(
        &self,
        queue: Queue<'_>,
        first: usize,
        paths: &Paths,
        instanced: bool,
    ) -> Vertex {
        let [path, t, primitive] = queue.rows(first);
        let instance = if instanced { queue.instances(first) } else { Int::ZERO };
        let path = paths.indices(path);
        let history = paths.histories(&path);
        Vertex {
            path,
            present: first_bits((queue.len() - first).min(LANES)),
            segment: paths.segments(&path),
            hit: Hit { t: Float::from_bits(t), primitive, instance },
            history,
            randoms: Randoms::new(self.settings.sampler, history.keys, self.segment),
        }
    }
}
