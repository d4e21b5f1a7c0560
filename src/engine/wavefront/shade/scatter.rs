//! What all scattering materials share: a path takes its next direction, or ends.

use super::vertex::Vertex;
use super::{Shaded, Shading};
use crate::engine::contract::{ROULETTE_FROM, ROULETTE_MAX};
use crate::engine::dimension::{Dimension, Randoms};
use crate::engine::wavefront::materials::Pattern;
use crate::engine::wavefront::paths::{History, Segment};
use crate::engine::wavefront::sort::Queue;
use crate::geometry::lanes::Shape;
use crate::simd::random::PathKeys;
use crate::simd::{Float, Int, LANES, Mask, Vec3x};

/// Directions that paths take.
pub(super) struct Scatter {
    /// Of unit length.
    pub(super) direction: Vec3x,
    /// The normals on whose side they leave.
    pub(super) side: Vec3x,
    /// f·|cos θ|/pdf.
    pub(super) weight: Vec3x,
    /// Density per unit solid angle, or [`Segment::SPECULAR`].
    pub(super) pdf: Float,
    /// Lanes of paths that are not absorbed; others may be among them.
    pub(super) scattered: u32,
}

/// The light that surfaces scatter from all directions to those from which paths have come.
pub(super) trait Bsdf {
    /// Whether they scatter light to their other side.
    const TRANSMITS: bool = false;

    /// Those for which there is but one direction, or two.
    fn specular(&self) -> Mask;

    /// Directions about as likely as they carry light.
    fn sample(&self, randoms: &Randoms<PathKeys>) -> Scatter;

    /// f·|cos θ| for unit vectors, and the density with which [`Self::sample`] draws them; neither
    /// tells of specular directions.
    fn evaluate(&self, direction: Vec3x) -> (Vec3x, Float);
}

/// A kind of materials.
pub(super) trait Material {
    /// What they make of surfaces.
    type Bsdf: Bsdf;

    /// How they scatter light at `vertex`.
    fn bsdf(&self, shading: &Shading<'_>, vertex: &Vertex) -> Self::Bsdf;
}

/// A kind of materials that have an albedo.
pub(super) trait Colored: Material {
    /// Those whose colours vary so.
    fn of(pattern: Pattern) -> Self;
}

impl Shading<'_> {
    /// [`Self::scatter`] with a loop for each pattern.
    pub(super) fn scatter_colored<M: Colored>(
        &self,
        pattern: Pattern,
        shape: Shape,
        queue: Queue<'_>,
        shaded: &mut Shaded<'_>,
    ) {
        match pattern {
            Pattern::Solid => self.scatter(Some(shape), queue, shaded, &M::of(Pattern::Solid)),
            Pattern::Checker => self.scatter(Some(shape), queue, shaded, &M::of(Pattern::Checker)),
            Pattern::Image => self.scatter(Some(shape), queue, shaded, &M::of(Pattern::Image)),
        }
    }

    /// Lets `material` scatter the paths of `queue`, on surfaces of one shape or in media, and appends
    /// those that go on.
    #[inline(always)]
    pub(super) fn scatter(
        &self,
        shape: Option<Shape>,
        queue: Queue<'_>,
        shaded: &mut Shaded<'_>,
        material: &impl Material,
    ) {
        for first in (0..queue.len()).step_by(LANES) {
            let vertex = self.vertex(shape, queue, first, shaded.paths);
            let bsdf = material.bsdf(self, &vertex);
            if self.settings.samples_lights(self.scene) {
                self.direct(&vertex, &bsdf, shaded.shadows);
            }
            let scatter = bsdf.sample(&vertex.randoms);
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
            let Scatter { direction, side, pdf, .. } = scatter;
            let origin = vertex.surface.spawn(side);
            let segments = Segment { origin, direction, pdf, ..vertex.segment };
            shaded.paths.set_segments(&vertex.path, &segments);
            let histories = History { beta, ..vertex.history };
            shaded.paths.set_beta(&vertex.path, &histories);
            let cells = self.cells.of(origin, direction);
            shaded.next.append(&[Int::new(*vertex.path.lanes()), cells], goes_on);
        }
    }
}
