//! Ends of paths: the background and lights.

use super::direct::power_heuristic;
use super::vertex::Vertex;
use super::{Shaded, Shading};
use crate::engine::wavefront::paths::Segment;
use crate::engine::wavefront::sort::Queue;
use crate::geometry::lanes::Shape;
use crate::scene::{Background, Sampling};
use crate::simd::{Float, LANES, Vec3x};

impl Shading<'_> {
    /// Paths that leave the scene.
    pub(super) fn background(&self, queue: Queue<'_>, shaded: &mut Shaded<'_>) {
        for first in (0..queue.len()).step_by(LANES) {
            let path = shaded.paths.indices(queue.rows(first)[0]);
            let seen = match *self.scene.background() {
                Background::Constant(seen) => Vec3x::splat(seen),
                Background::Gradient { bottom, top } => {
                    let one = Float::splat(1.0);
                    let direction = shaded.paths.segments(&path).direction;
                    let t = Float::splat(0.5) * (direction[1] + one);
                    Vec3x::splat(bottom) * (one - t) + Vec3x::splat(top) * t
                }
            };
            let mut history = shaded.paths.histories(&path);
            history.radiance = history.radiance + history.beta * seen;
            shaded.paths.set_radiance(&path, &history);
        }
        shaded.endings.background += queue.len() as u64;
    }

    /// Paths that hit lights.
    pub(super) fn light(&self, shape: Shape, queue: Queue<'_>, shaded: &mut Shaded<'_>) {
        for first in (0..queue.len()).step_by(LANES) {
            let vertex = self.vertex(Some(shape), queue, first, shaded.paths);
            let (emission, one_sided) = self.solid(&vertex.primitive);
            let dark = one_sided.gt(Float::ZERO) & !vertex.front;
            let emission = Vec3x::select(dark, Vec3x::ZERO, emission);
            let weight = self.emission_weight(shape, &vertex);
            let mut history = vertex.history;
            history.radiance = history.radiance + history.beta * emission * weight;
            shaded.paths.set_radiance(&vertex.path, &history);
        }
        shaded.endings.light += queue.len() as u64;
    }

    /// The share of a light's emission that counts where a path hits it: the rest is found by
    /// light samples.
    #[inline(always)]
    fn emission_weight(&self, shape: Shape, vertex: &Vertex) -> Float {
        let one = Float::splat(1.0);
        if self.settings.sampling == Sampling::Bsdf || self.scene.lights().is_empty() {
            return one;
        }
        let Segment { origin, direction, time, pdf } = vertex.segment;
        let (lights, are_lights) = self.lights.of(self.scene.lights(), &vertex.primitive);
        let sampled = are_lights & !pdf.eq(Float::splat(Segment::SPECULAR));
        let weight = if self.settings.sampling == Sampling::Light {
            Float::ZERO
        } else {
            let of_light = lights.pdf(shape, (origin, direction), time, vertex.t);
            power_heuristic(pdf, of_light * lights.chance())
        };
        sampled.select(weight, one)
    }
}
