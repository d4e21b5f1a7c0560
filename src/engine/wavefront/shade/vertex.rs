//! The points where paths arrive.

use super::Shading;
use crate::engine::dimension::Randoms;
use crate::engine::wavefront::paths::{History, Paths, Segment};
use crate::engine::wavefront::sort::Queue;
use crate::geometry::lanes::{HitPoints, Shape, SurfaceLanes};
use crate::simd::random::PathKeys;
use crate::simd::{Float, Indices, LANES, Lanes, Mask, Vec3x, first_bits};

/// A point of a surface a lane, and a path that has come there.
pub(super) struct Vertex {
    pub(super) path: Indices,
    /// Lanes of paths; others repeat the last.
    pub(super) present: u32,
    /// Which has come there.
    pub(super) segment: Segment,
    pub(super) t: Float,
    /// What they have hit; a code of [`Materials::medium`](super::super::materials::Materials::medium)
    /// in media.
    pub(super) primitive: Lanes<u32>,
    pub(super) surface: SurfaceLanes,
    /// On the side that was hit.
    pub(super) normal: Vec3x,
    /// Whether that is the front.
    pub(super) front: Mask,
    pub(super) history: History,
    pub(super) randoms: Randoms<PathKeys>,
}

impl Shading<'_> {
    /// The vertices of the paths `first..` of `queue`: on surfaces of one shape, or in media.
    #[inline(always)]
    pub(super) fn vertex(
        &self,
        shape: Option<Shape>,
        queue: Queue<'_>,
        first: usize,
        paths: &Paths,
    ) -> Vertex {
        let [path, t, primitive] = queue.rows(first);
        let (path, t) = (paths.indices(path), Float::from_bits(t));
        let primitive = primitive.to_array();
        let segment = paths.segments(&path);
        let Segment { origin, direction, time, .. } = segment;
        let surface = match shape {
            Some(shape) => {
                self.surfaces.find(shape, &HitPoints { origin, direction, time, t, primitive })
            }
            // Nothing that rays would have to leave.
            None => {
                let point = origin + direction * t;
                SurfaceLanes { point, normal: direction, offset: Float::ZERO }
            }
        };
        let (normal, front) = surface.normal.face_forward(direction);
        let history = paths.histories(&path);
        Vertex {
            path,
            present: first_bits((queue.len() - first).min(LANES)),
            segment,
            t,
            primitive,
            surface,
            normal,
            front,
            history,
            randoms: Randoms::new(self.settings.sampler, history.keys, self.segment),
        }
    }
}
