//! Direct light: a light sample and a shadow ray a vertex.

use super::Shading;
use super::scatter::Bsdf;
use super::vertex::Vertex;
use crate::accel::RayVector;
use crate::engine::dimension::Dimension;
use crate::engine::wavefront::connect::Shadows;
use crate::engine::wavefront::light::{self, LightSamples};
use crate::scene::{Sampling, Sides};
use crate::simd::{Float, LANES, Lanes, Vec3x, by_key};

impl Shading<'_> {
    /// Samples a light from each vertex.
    #[inline(always)]
    pub(super) fn direct<B: Bsdf>(&self, vertex: &Vertex, bsdf: &B, shadows: &mut Shadows) {
        let rough = vertex.present & (!bsdf.specular()).bits();
        if rough == 0 {
            return;
        }
        let from = vertex.surface.spawn(vertex.normal);
        let lights = self.scene.lights();
        let (count, numbers) = (lights.len() as f32, vertex.randoms.two(Dimension::LIGHT));
        let choice = vertex.randoms.one(Dimension::LIGHT_CHOICE) * Float::splat(count);
        let mut chosen: Lanes<u32> = [0; LANES];
        for (chosen, choice) in chosen.iter_mut().zip(choice.to_array()) {
            *chosen = (choice as u32).min(lights.len() as u32 - 1);
        }
        // One light after the other: mostly there are few.
        for (chosen, lanes) in by_key(rough, &chosen) {
            let light = &lights[chosen as usize];
            let time = vertex.segment.time;
            let LightSamples { direction, reach, pdf, front, visible } =
                light::sample(self.scene, light, from, time, numbers);
            let (f_cos, bsdf_pdf) = bsdf.evaluate(direction);
            let mut lit = lanes & (visible & f_cos.max_element().gt(Float::ZERO)).bits();
            if light.emission.sides == Sides::Front {
                lit &= front.bits();
            }
            let pdf = pdf * Float::splat(1.0 / count);
            let weight = match self.settings.sampling {
                Sampling::Mis => power_heuristic(pdf, bsdf_pdf),
                _ => Float::splat(1.0),
            };
            let emitted = Vec3x::splat(light.emission.radiance);
            let arriving = f_cos * emitted * (weight / pdf);
            let origin = if B::TRANSMITS {
                // What is seen through the surface is as far from its other side, but for rounding.
                let above = direction.dot(vertex.normal).gt(Float::ZERO);
                vertex.surface.spawn(Vec3x::select(above, vertex.normal, -vertex.normal))
            } else {
                from
            };
            let (t_min, t_max) = (Float::ZERO, reach);
            let rays = RayVector { origin, direction, time, t_min, t_max };
            shadows.append(&rays, vertex.history.beta * arriving, &vertex.path, lit);
        }
    }
}

/// Weight of a sample that was drawn with density `of` where `other` could have drawn it too
/// (Veach 1997, section 9.2.4, exponent 2).
#[inline(always)]
pub(super) fn power_heuristic(of: Float, other: Float) -> Float {
    let (one, ratio) = (Float::splat(1.0), other / of);
    one / (one + ratio * ratio)
}
