//! Bodies of glass: absorption along segments, and the bodies that paths enter and leave.

use super::ShadeInputs;
use super::vertex::Vertex;
use crate::engine::wavefront::{Paths, Queue};
use crate::math::Real;
use crate::shading::Nesting;
use crate::simd::{Float, LANES};

/// The bodies on both sides of the points that paths reach, one per lane.
#[derive(Clone, Copy)]
pub(super) struct Sides {
    pub(super) here: Nesting<Float>,
    pub(super) beyond: Nesting<Float>,
}

impl Sides {
    /// The bodies on one side.
    #[inline(always)]
    pub(super) fn select(&self, beyond: <Float as Real>::Mask) -> Nesting<Float> {
        Nesting(beyond.select(self.beyond.0, self.here.0))
    }
}

impl ShadeInputs<'_> {
    /// Multiplies the throughput of the paths of `queue` by the share of light that passes their segments.
    #[inline(never)]
    pub(super) fn absorb(&self, queue: Queue<'_>, paths: &mut Paths) {
        for first in (0..queue.len()).step_by(LANES) {
            let [path, t, _] = queue.rows(first);
            let path = paths.indices(path);
            let mut history = paths.histories(&path);
            let (nesting, t) = (paths.nestings(&path), Float::from_bits(t));
            history.beta = history.beta * self.tables.bodies.transmittance(nesting, t);
            paths.set_beta(&path, &history);
        }
    }

    /// The bodies on both sides of `vertex`, or `None` if no body absorbs light. `beyond` finds the second.
    #[inline(always)]
    pub(super) fn sides(
        &self,
        vertex: &Vertex,
        paths: &Paths,
        beyond: impl FnOnce(Nesting<Float>) -> Nesting<Float>,
    ) -> Option<Sides> {
        if self.tables.bodies.are_clear() {
            return None;
        }
        let here = paths.nestings(&vertex.path);
        Some(Sides { here, beyond: beyond(here) })
    }
}
