//! Direct light: a light sample and a shadow ray a vertex.

use glam::Vec3;

use super::Shading;
use super::diffuse::Diffuse;
use super::emit::power_heuristic;
use super::vertex::Vertex;
use crate::accel::RayVector;
use crate::engine::dimension::Dimension;
use crate::engine::scalar::light::{self, LightSample};
use crate::engine::wavefront::connect::Shadows;
use crate::math::dot;
use crate::scene::Sampling;
use crate::simd::{Bits, Float, LANES, Lanes, Vec3x, axes};

impl Shading<'_> {
    /// Samples a light from each vertex.
    pub(super) fn direct<const COSINE: bool>(
        &self,
        vertex: &Vertex,
        diffuse: &Diffuse<COSINE>,
        from: Vec3x,
        shadows: &mut Shadows,
    ) {
        let lights = self.scene.lights();
        let count = lights.len() as f32;
        let choice = (vertex.randoms.one(Dimension::LIGHT_CHOICE) * Float::splat(count)).to_array();
        let (u, v) = vertex.randoms.two(Dimension::LIGHT);
        let (u, v) = (u.to_array(), v.to_array());
        let vectors = [from, diffuse.normal, diffuse.albedo];
        let [origin, normal, albedo] = vectors.map(|v| axes(|axis| v[axis].to_array()));
        let time = vertex.segment.time.to_array();
        let (mut directions, mut lit, mut reach) =
            ([[0.0; LANES]; 3], [[0.0; LANES]; 3], [0.0; LANES]);
        let mut seen = 0;
        for lane in Bits(vertex.present) {
            let at = |v: &[Lanes; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
            let light = &lights[(choice[lane] as usize).min(lights.len() - 1)];
            let sample =
                light::sample(self.scene, light, at(&origin), time[lane], (u[lane], v[lane]));
            let Some(LightSample { direction, reach: far, pdf, front }) = sample else { continue };
            let emitted = light.emission.radiance(front);
            let f_cos = Diffuse::<COSINE>::evaluate(dot(at(&normal), direction));
            if f_cos <= 0.0 || emitted == Vec3::ZERO {
                continue;
            }
            let pdf = pdf * (1.0 / count);
            let weight = match self.settings.sampling {
                Sampling::Mis => power_heuristic(pdf, f_cos),
                _ => 1.0,
            };
            let light = at(&albedo) * emitted * (f_cos * weight / pdf);
            seen |= 1 << lane;
            reach[lane] = far;
            for axis in 0..3 {
                directions[axis][lane] = direction[axis];
                lit[axis][lane] = light[axis];
            }
        }
        let rays = RayVector {
            origin: from,
            direction: Vec3x::new(&directions),
            time: vertex.segment.time,
            t_min: Float::ZERO,
            t_max: Float::new(reach),
        };
        shadows.append(&rays, vertex.history.beta * Vec3x::new(&lit), &vertex.path, seen);
    }
}
