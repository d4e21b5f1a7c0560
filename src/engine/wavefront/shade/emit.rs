//! Ends of paths: the background and lights.

use glam::Vec3;

use super::vertex::Vertex;
use super::{Shaded, Shading};
use crate::engine::scalar::light;
use crate::engine::wavefront::paths::Segment;
use crate::engine::wavefront::sort::Queue;
use crate::geometry::Ray;
use crate::geometry::lanes::Shape;
use crate::scene::{Background, Sampling};
use crate::simd::{Bits, Float, Int, LANES, Lanes, Mask, Vec3x, axes};

impl Shading<'_> {
    /// Paths that leave the scene.
    pub(super) fn background(&self, queue: &Queue, shaded: &mut Shaded<'_>) {
        for first in (0..queue.len()).step_by(LANES) {
            let [path, ..] = queue.rows(first).map(Int::to_array);
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
    #[inline(always)]
    fn emission_weight(&self, vertex: &Vertex) -> Float {
        let one = Float::splat(1.0);
        let diffuse = !vertex.segment.pdf.eq(Float::splat(Segment::SPECULAR));
        let mut sampled = 0;
        let primitive = &vertex.primitive;
        for lane in Bits(diffuse.bits()) {
            sampled |= u32::from(self.scene.light(primitive[lane]).is_some()) << lane;
        }
        match self.settings.sampling {
            Sampling::Bsdf => one,
            Sampling::Light => Mask::from_bits(sampled).select(Float::ZERO, one),
            Sampling::Mis => {
                let mut weights = [1.0; LANES];
                let vectors = [vertex.segment.origin, vertex.segment.direction];
                let [origin, direction] = vectors.map(|v| axes(|axis| v[axis].to_array()));
                let (t, time) = (vertex.t.to_array(), vertex.segment.time.to_array());
                let pdf = vertex.segment.pdf.to_array();
                for lane in Bits(sampled) {
                    let at = |v: &[Lanes; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
                    let ray =
                        Ray { origin: at(&origin), direction: at(&direction), time: time[lane] };
                    let light = self.scene.light(primitive[lane]).expect("it is sampled");
                    let light_pdf = light::pdf(self.scene, light, &ray, t[lane])
                        * (1.0 / self.scene.lights().len() as f32);
                    weights[lane] = power_heuristic(pdf[lane], light_pdf);
                }
                Float::new(weights)
            }
        }
    }
}

/// Weight of a sample that was drawn with density `of` where `other` could have drawn it too.
pub(super) fn power_heuristic(of: f32, other: f32) -> f32 {
    let ratio = other / of;
    1.0 / (1.0 + ratio * ratio)
}
