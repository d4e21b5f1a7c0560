//! Emitted light: the background, and surfaces that emit light towards the paths.

use super::{Shaded, Shading};
use crate::engine::contract::power_heuristic;
use crate::engine::wavefront::paths::Segment;
use crate::engine::wavefront::sort::Queue;
use crate::geometry::{Hit, Shape};
use crate::math::Real;
use crate::scene::Sampling;
use crate::scene::material::SPECULAR;
use crate::simd::{Float, LANES, Mask, Vec3x};

impl Shading<'_> {
    /// Adds the background's light to the paths of `queue`, which leave the scene and end.
    #[inline(never)]
    pub(super) fn background(&self, queue: Queue<'_>, shaded: &mut Shaded<'_>) {
        for first in (0..queue.len()).step_by(LANES) {
            let path = shaded.paths.indices(queue.rows(first)[0]);
            let direction = || shaded.paths.segments(&path).ray.direction;
            let seen = self.scene.background().radiance(direction);
            let mut history = shaded.paths.histories(&path);
            history.radiance = history.radiance + history.beta * seen;
            shaded.paths.set_radiance(&path, &history);
        }
        shaded.endings.background += queue.len() as u64;
    }

    /// Adds the light that surfaces of one shape emit towards the paths of `queue`.
    #[inline(never)]
    pub(super) fn emit(&self, shape: Shape, queue: Queue<'_>, shaded: &mut Shaded<'_>) {
        if self.tables.lights.is_empty() {
            return;
        }
        for first in (0..queue.len()).step_by(LANES) {
            let vertex = self.vertex(queue, first, shaded.paths, false);
            let Segment { ray, pdf } = vertex.segment;
            let Hit { t, primitive, .. } = vertex.hit;
            let at = self.tables.interaction(shape, ray, vertex.hit, false, false, false);
            let (light, is_light) = self.tables.looks.lights::<Float>(shape, primitive);
            let light = self.tables.lights.get::<Float>(light);
            let weight = match self.settings.sampling {
                Sampling::Bsdf => Float::ONE,
                Sampling::Light => Float::ZERO,
                Sampling::Mis => power_heuristic(pdf, light.pdf(&ray, t) * light.chance()),
            };
            // The weight applies only to emission that light samples could also find. Light samples
            // contribute the rest.
            let sampled: Mask = is_light & !pdf.eq(Float::splat(SPECULAR));
            let weight = sampled.select(weight, Float::ONE);
            let emitted: Vec3x = is_light.select(light.radiance(at.front), Vec3x::ZERO);
            let mut history = vertex.history;
            history.radiance = history.radiance + history.beta * emitted * weight;
            shaded.paths.set_radiance(&vertex.path, &history);
        }
    }
}
