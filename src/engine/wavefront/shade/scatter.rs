//! What all scattering materials share: a path takes its next direction, or ends.

use super::vertex::Vertex;
use super::{Shaded, Shading};
use crate::engine::contract::{ROULETTE_FROM, ROULETTE_MAX};
use crate::engine::dimension::Dimension;
use crate::engine::wavefront::connect::Shadows;
use crate::engine::wavefront::materials::Pattern;
use crate::engine::wavefront::paths::{History, Segment};
use crate::engine::wavefront::sort::Queue;
use crate::geometry::lanes::Shape;
use crate::simd::{Float, Int, LANES, Vec3x};

/// The next segments of paths.
pub(super) struct Scatter {
    pub(super) origin: Vec3x,
    /// Of unit length.
    pub(super) direction: Vec3x,
    /// f·cos θ/pdf.
    pub(super) weight: Vec3x,
    pub(super) pdf: Float,
    /// Paths that are not absorbed.
    pub(super) scattered: u32,
}

/// A kind of materials.
pub(super) trait Scatterer {
    /// Where paths go from `vertex`.
    fn scatter(&self, shading: &Shading<'_>, vertex: &Vertex, shadows: &mut Shadows) -> Scatter;
}

/// A kind of materials that have an albedo.
pub(super) trait Colored: Scatterer {
    /// Those whose colours vary so.
    fn of(pattern: Pattern) -> Self;
}

impl Shading<'_> {
    /// [`Self::scatter`] with a loop for each pattern.
    pub(super) fn scatter_colored<M: Colored>(
        &self,
        pattern: Pattern,
        shape: Shape,
        queue: &Queue,
        shaded: &mut Shaded<'_>,
    ) {
        match pattern {
            Pattern::Solid => self.scatter(shape, queue, shaded, &M::of(Pattern::Solid)),
            Pattern::Checker => self.scatter(shape, queue, shaded, &M::of(Pattern::Checker)),
            Pattern::Image => self.scatter(shape, queue, shaded, &M::of(Pattern::Image)),
        }
    }

    /// Lets `material` scatter the paths of `queue`, and appends those that go on.
    #[inline(always)]
    pub(super) fn scatter(
        &self,
        shape: Shape,
        queue: &Queue,
        shaded: &mut Shaded<'_>,
        material: &impl Scatterer,
    ) {
        for first in (0..queue.len()).step_by(LANES) {
            let vertex = self.vertex(shape, queue, first, shaded.paths);
            let scatter = material.scatter(self, &vertex, shaded.shadows);
            let mut beta = vertex.history.beta * scatter.weight;
            // Paths that can add nothing end; those that can add little mostly do.
            let mut survival = beta.max_element();
            let present = vertex.present;
            let scattered = present & scatter.scattered;
            let black = scattered & survival.le(Float::ZERO).bits();
            let mut goes_on = scattered & !black;
            let endings = &mut *shaded.endings;
            endings.absorbed += u64::from((present & !scattered).count_ones());
            endings.black += u64::from(black.count_ones());
            if self.settings.roulette && self.segment + 1 >= ROULETTE_FROM {
                survival = survival.min(Float::splat(ROULETTE_MAX));
                let chance = vertex.randoms.one(Dimension::ROULETTE);
                let ended = goes_on & chance.ge(survival).bits();
                endings.roulette += u64::from(ended.count_ones());
                goes_on &= !ended;
                beta = beta / survival;
            }
            let Scatter { origin, direction, pdf, .. } = scatter;
            let segments = Segment { origin, direction, pdf, ..vertex.segment };
            shaded.paths.set_segments(&vertex.path, &segments);
            let histories = History { beta, ..vertex.history };
            shaded.paths.set_beta(&vertex.path, &histories);
            let cells = self.cells.of(origin, direction);
            shaded.next.append(&[Int::new(*vertex.path.lanes()), cells], goes_on);
        }
    }
}

/// `direction` mirrored at a surface with normal `normal`.
#[inline(always)]
pub(super) fn reflect(direction: Vec3x, normal: Vec3x) -> Vec3x {
    direction - normal * (Float::splat(2.0) * direction.dot(normal))
}
