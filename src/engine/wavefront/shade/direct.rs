//! Direct light: one light sample and one shadow ray per vertex.

use super::ShadeInputs;
use super::bodies::Sides;
use super::vertex::Vertex;
use crate::accel::RayVector;
use crate::engine::wavefront::Shadows;
use crate::engine::{SHADOW_REACH, power_heuristic};
use crate::geometry::{Ray, Surface};
use crate::math::{Real, dot, max_element};
use crate::sampler::Dimension;
use crate::scene::Sampling;
use crate::shading::light::LightSample;
use crate::shading::material::Bsdf;
use crate::simd::{Float, Vec3x};

impl ShadeInputs<'_> {
    /// Samples a light from each vertex and appends its shadow ray. `normal` is on the side where
    /// the path arrives.
    #[inline(always)]
    pub(super) fn direct<B: Bsdf<Float>>(
        &self,
        vertex: &Vertex,
        sides: Option<Sides>,
        surface: &Surface<Float>,
        normal: Vec3x,
        bsdf: &B,
        shadows: &mut Shadows,
    ) {
        let rough = vertex.present & (!bsdf.specular()).bits();
        if rough == 0 {
            return;
        }
        let (from, time) = (surface.spawn(normal), vertex.segment.ray.time);
        let light = self.tables.lights.choose(&vertex.randoms, from);
        let LightSample { direction, distance, pdf, tint, front, visible } =
            light.sample(from, time, vertex.randoms.two(Dimension::LIGHT));
        let mut emitted = light.radiance(front) * tint;
        if self.tables.lights.has_varied() {
            let ray = Ray { origin: from, direction, time };
            emitted = self.tables.radiance_of_sample(&light, (emitted, front), &ray, distance);
        }
        let (f_cos, bsdf_pdf) = bsdf.evaluate(direction);
        let some = |light: Vec3x| max_element(light).gt(Float::ZERO);
        let lit = rough & (visible & some(f_cos) & some(emitted)).bits();
        let pdf = pdf * light.chance(from);
        let mut weight = match self.settings.sampling {
            Sampling::Mis => power_heuristic(pdf, bsdf_pdf),
            _ => Float::ONE,
        };
        if self.tables.lights.has_unseen() {
            weight = light.unseen().select(Float::ONE, weight);
        }
        let origin = if B::TRANSMITS {
            // A light behind the surface is sampled from the front but needs a shadow ray from the
            // back. Both origins have the same distance to the light, up to rounding errors.
            let above = dot(direction, normal).gt(Float::ZERO);
            surface.spawn(above.select(normal, -normal))
        } else {
            from
        };
        let ray = Ray { origin, direction, time };
        let mut share = weight / pdf;
        if !self.tables.media.is_empty() {
            share = share * self.tables.media.transmittance(&ray, distance);
        }
        let mut light = f_cos * emitted * share;
        if let Some(sides) = sides {
            let nesting = sides.select(dot(direction, normal).le(Float::ZERO));
            light = light * self.tables.bodies.transmittance(nesting, distance);
        }
        let arriving = vertex.history.beta * light;
        let t_max = distance * SHADOW_REACH;
        let rays = RayVector { t_max, ..RayVector::unbounded(ray) };
        shadows.append(&rays, arriving, &vertex.path, lit);
    }
}
