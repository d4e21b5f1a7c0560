//! Direct light: a light sample and a shadow ray a vertex.

use super::Shading;
use super::scatter::Bsdf;
use super::vertex::Vertex;
use crate::accel::RayVector;
use crate::engine::contract::SHADOW_REACH;
use crate::engine::dimension::Dimension;
use crate::engine::wavefront::collide::transmittance;
use crate::engine::wavefront::connect::Shadows;
use crate::engine::wavefront::light::LightSamples;
use crate::scene::Sampling;
use crate::simd::{Float, Vec3x};

impl Shading<'_> {
    /// Samples a light from each vertex.
    #[inline(always)]
    pub(super) fn direct<B: Bsdf>(&self, vertex: &Vertex, bsdf: &B, shadows: &mut Shadows) {
        let rough = vertex.present & (!bsdf.specular()).bits();
        if rough == 0 {
            return;
        }
        let (from, time) = (vertex.surface.spawn(vertex.normal), vertex.segment.time);
        let lights = self.lights.choose(&vertex.randoms);
        let LightSamples { direction, distance, pdf, front, visible } =
            lights.sample(from, time, vertex.randoms.two(Dimension::LIGHT));
        let emitted = lights.radiance(front);
        let (f_cos, bsdf_pdf) = bsdf.evaluate(direction);
        let some = |light: Vec3x| light.max_element().gt(Float::ZERO);
        let lit = rough & (visible & some(f_cos) & some(emitted)).bits();
        let pdf = pdf * lights.chance();
        let weight = match self.settings.sampling {
            Sampling::Mis => power_heuristic(pdf, bsdf_pdf),
            _ => Float::splat(1.0),
        };
        let origin = if B::TRANSMITS {
            // What is seen through the surface is as far from its other side, but for rounding.
            let above = direction.dot(vertex.normal).gt(Float::ZERO);
            vertex.surface.spawn(Vec3x::select(above, vertex.normal, -vertex.normal))
        } else {
            from
        };
        let mut share = weight / pdf;
        if !self.scene.media().is_empty() {
            share = share * transmittance(self.scene.media(), origin, direction, distance);
        }
        let arriving = f_cos * emitted * share;
        let t_max = distance * Float::splat(SHADOW_REACH);
        let rays = RayVector { origin, direction, time, t_min: Float::ZERO, t_max };
        shadows.append(&rays, vertex.history.beta * arriving, &vertex.path, lit);
    }
}

/// Weight of a sample that was drawn with density `of` where `other` could have drawn it too
/// (Veach 1997, section 9.2.4, exponent 2).
#[inline(always)]
pub(super) fn power_heuristic(of: Float, other: Float) -> Float {
    let (one, ratio) = (Float::splat(1.0), other / of);
    one / (one + ratio * ratio)
}
