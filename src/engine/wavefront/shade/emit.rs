//! Emitted light: the background, and surfaces that emit light towards the paths.

use super::{ShadeInputs, ShadeOutputs};
use crate::engine::emission_weight;
use crate::engine::wavefront::{Queue, Segment};
use crate::geometry::{Hit, Shape};
use crate::math::{Real, Row};
use crate::simd::{Float, LANES, Mask, Vec3x};

impl ShadeInputs<'_> {
    /// Adds the background's light to the paths of `queue`, which leave the scene and end.
    #[inline(never)]
    pub(super) fn background(&self, queue: Queue<'_>, shaded: &mut ShadeOutputs<'_>) {
        let environment = self.tables.lights.environment::<Float>();
        let hidden = self.segment == 1 && self.settings.transparent;
        for first in (0..queue.len()).step_by(LANES) {
            let path = shaded.paths.indices(queue.rows(first)[0]);
            let seen = match &environment {
                _ if hidden => Vec3x::ZERO,
                None => {
                    let direction = || shaded.paths.segments(&path).ray.direction;
                    self.scene.background().radiance(direction)
                }
                Some((map, light)) => {
                    let Segment { ray, pdf } = shaded.paths.segments(&path);
                    let (radiance, density) = map.look::<Float>(ray.direction);
                    let light_pdf = || density * light.chance(ray.origin);
                    let weight = emission_weight(self.settings.sampling, pdf, light_pdf);
                    // A compensated map is never sampled where it is dark.
                    let weight = density.eq(Float::ZERO).select(Float::ONE, weight);
                    radiance * light.radiance(Mask::ALL) * weight
                }
            };
            let mut history = shaded.paths.histories(&path);
            history.radiance = history.radiance + history.beta * seen;
            shaded.paths.set_radiance(&path, &history);
        }
        shaded.endings.background += queue.len() as u64;
    }

    /// Adds the light that surfaces of one shape emit towards the paths of `queue`. `emission_rows` are the
    /// rows of their light, if that of any varies.
    #[inline(never)]
    pub(super) fn emit(
        &self,
        shape: Shape,
        emission_rows: &[Row],
        queue: Queue<'_>,
        shaded: &mut ShadeOutputs<'_>,
    ) {
        let instanced = shape == Shape::Instance;
        for first in (0..queue.len()).step_by(LANES) {
            let vertex = self.vertex(queue, first, shaded.paths, instanced);
            let Segment { ray, pdf } = vertex.segment;
            let Hit { t, primitive, .. } = vertex.hit;
            let textured = !emission_rows.is_empty();
            let at = self.tables.interaction(shape, ray, vertex.hit, textured, false, instanced);
            let mut history = vertex.history;
            let mut texture = Vec3x::ZERO;
            if textured {
                let entries =
                    self.tables.looks.entries::<Float>(shape, primitive, emission_rows.len());
                texture = at.color(Float::gather(emission_rows, entries, |row| row));
                if self.tables.lights.is_empty() {
                    history.radiance = history.radiance + history.beta * texture;
                    shaded.paths.set_radiance(&vertex.path, &history);
                    continue;
                }
            }
            let (light, is_light) = self.tables.looks.lights::<Float>(shape, primitive);
            let light = self.tables.lights.get::<Float>(light);
            let light_pdf = || light.pdf(&ray, t) * light.chance(ray.origin);
            let weight = emission_weight(self.settings.sampling, pdf, light_pdf);
            let weight = is_light.select(weight, Float::ONE);
            let mut emitted: Vec3x = is_light.select(light.radiance(at.front), Vec3x::ZERO);
            if textured {
                let constant = is_light & (!light.varies() | light.is_dark(at.front));
                emitted = constant.select(emitted, texture);
            }
            history.radiance = history.radiance + history.beta * emitted * weight;
            shaded.paths.set_radiance(&vertex.path, &history);
        }
    }
}
