//! Ends of paths: the background and lights.

use super::direct::power_heuristic;
use super::vertex::Vertex;
use super::{Shaded, Shading};
use crate::engine::wavefront::light;
use crate::engine::wavefront::paths::Segment;
use crate::engine::wavefront::sort::Queue;
use crate::geometry::lanes::Shape;
use crate::scene::{Background, Sampling};
use crate::simd::{Bits, Float, LANES, Mask, Vec3x, by_key};

impl Shading<'_> {
    /// Paths that leave the scene.
    pub(super) fn background(&self, queue: &Queue, shaded: &mut Shaded<'_>) {
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
    pub(super) fn light(&self, shape: Shape, queue: &Queue, shaded: &mut Shaded<'_>) {
        for first in (0..queue.len()).step_by(LANES) {
            let vertex = self.vertex(shape, queue, first, shaded.paths);
            let (emission, one_sided) = self.solid(&vertex.primitive);
            let dark = one_sided.gt(Float::ZERO) & !vertex.front;
            let emission = Vec3x::select(dark, Vec3x::ZERO, emission);
            let weight = self.emission_weight(&vertex);
            let mut history = vertex.history;
            history.radiance = history.radiance + history.beta * emission * weight;
            shaded.paths.set_radiance(&vertex.path, &history);
        }
        shaded.endings.light += queue.len() as u64;
    }

    /// The share of a light's emission that counts where a path hits it: the rest is found by
    /// light samples.
    fn emission_weight(&self, vertex: &Vertex) -> Float {
        let one = Float::splat(1.0);
        if self.settings.sampling == Sampling::Bsdf {
            return one;
        }
        let diffuse = !vertex.segment.pdf.eq(Float::splat(Segment::SPECULAR));
        let mut sampled = 0;
        for lane in Bits(diffuse.bits()) {
            sampled |= u32::from(self.scene.light(vertex.primitive[lane]).is_some()) << lane;
        }
        if self.settings.sampling == Sampling::Light {
            return Mask::from_bits(sampled).select(Float::ZERO, one);
        }
        let choice_pdf = Float::splat(1.0 / self.scene.lights().len() as f32);
        let Segment { origin, direction, time, pdf } = vertex.segment;
        let mut weights = one;
        // One light after the other: mostly there are few.
        for (primitive, lanes) in by_key(sampled, &vertex.primitive) {
            let light = self.scene.light(primitive).expect("it is sampled");
            let of_light = light::pdf(self.scene, light, (origin, direction), time, vertex.t);
            let weight = power_heuristic(pdf, of_light * choice_pdf);
            weights = Mask::from_bits(lanes).select(weight, weights);
        }
        weights
    }
}
