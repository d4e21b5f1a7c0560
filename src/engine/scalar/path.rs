//! The path tracing loop.

use glam::Vec3;

use super::bsdf::{Arrival, Bsdf, SPECULAR};
use super::intersect::Intersect;
use super::light::{self, LightSample};
use super::medium;
use crate::engine::contract::{ROULETTE_FROM, ROULETTE_MAX, SHADOW_REACH};
use crate::engine::dimension::{Dimension, Randoms};
use crate::engine::settings::RenderSettings;
use crate::engine::{Endings, RayCounts};
use crate::geometry::{Ray, Surface};
use crate::math::random::PathKey;
use crate::math::{dot, face_forward, max_element, min};
use crate::scene::{Material, Sampling, Scene};

/// Estimates the radiance along camera rays, and counts the rays that this takes.
pub(in crate::engine) struct PathTracer<'a, I> {
    scene: &'a Scene,
    pub(in crate::engine) intersect: I,
    settings: &'a RenderSettings,
    pub(in crate::engine) rays: RayCounts,
    pub(in crate::engine) endings: Endings,
}

impl<'a, I: Intersect> PathTracer<'a, I> {
    pub(in crate::engine) fn new(
        scene: &'a Scene,
        intersect: I,
        settings: &'a RenderSettings,
    ) -> Self {
        Self { scene, intersect, settings, rays: RayCounts::default(), endings: Endings::default() }
    }

    /// One estimate of the radiance that arrives along `ray` (report, III.A, as a loop).
    pub(in crate::engine) fn radiance(&mut self, mut ray: Ray, key: PathKey) -> Vec3 {
        let mut radiance = Vec3::ZERO;
        let mut beta = Vec3::ONE; // throughput: what a unit of radiance here adds to the pixel
        let mut pdf = SPECULAR; // density with which the segment's direction was chosen
        self.rays.primary += 1;

        for segment in 1..=self.settings.depth {
            // Extend: the closest surface, or the background, or a collision before these.
            let hit = self.intersect.closest(&ray, segment);
            let randoms = Randoms::new(self.settings.sampler, key, segment);
            let end = hit.map_or(f32::INFINITY, |hit| hit.t);
            let collision = medium::collide(self.scene.media(), &ray, end, &randoms);

            // Shade: emit, or choose the next direction.
            let (surface, normal, bsdf) = if let Some((t, medium)) = collision {
                self.intersect.collided(t);
                if segment == self.settings.depth {
                    self.endings.depth += 1;
                    break;
                }
                // Nothing that rays would have to leave.
                let point = ray.origin + ray.direction * t;
                let surface = Surface { point, normal: ray.direction, offset: 0.0 };
                (surface, -ray.direction, Bsdf::phase(medium.albedo))
            } else {
                let Some(hit) = hit else {
                    radiance += beta * self.scene.background().radiance(ray.direction);
                    self.endings.background += 1;
                    break;
                };
                let primitive = self.scene.geometry().get(hit.primitive);
                let surface = primitive.surface(&ray, hit.t);
                let (normal, front) = face_forward(surface.normal, ray.direction);
                let material = self.scene.material(hit.primitive);
                if let Material::Light(emission) = material {
                    let weight = self.emission_weight(hit.primitive, &ray, hit.t, pdf);
                    radiance += beta * emission.radiance(front) * weight;
                    self.endings.light += 1;
                    break;
                }
                if segment == self.settings.depth {
                    self.endings.depth += 1;
                    break;
                }
                let color = |texture: u32| {
                    let uv = || primitive.uv(&ray, &surface, hit.t);
                    self.scene.textures()[texture as usize].color(surface.point, uv)
                };
                let arrival = Arrival { direction: ray.direction, normal, front };
                (surface, normal, Bsdf::new(material, arrival, color))
            };
            // Connect: one light, one shadow ray, which is the path's next segment.
            radiance += beta * self.direct(&bsdf, &surface, normal, ray.time, segment, &randoms);
            let Some(scatter) = bsdf.sample(&randoms) else {
                self.endings.absorbed += 1;
                break;
            };
            beta *= scatter.weight;
            pdf = scatter.pdf;
            let origin = surface.spawn(scatter.side);
            ray = Ray { origin, direction: scatter.direction, time: ray.time };

            // Paths that can add nothing end; those that can add little mostly do.
            let mut survival = max_element(beta);
            if survival <= 0.0 {
                self.endings.black += 1;
                break;
            }
            if self.settings.roulette && segment + 1 >= ROULETTE_FROM {
                survival = min(survival, ROULETTE_MAX);
                if randoms.one(Dimension::ROULETTE) >= survival {
                    self.endings.roulette += 1;
                    break;
                }
                beta /= survival;
            }
            self.rays.bounce += 1;
        }
        radiance
    }

    /// The share of a light's emission that counts where a path hits it: the rest is found
    /// by [`Self::direct`].
    fn emission_weight(&self, primitive: u32, ray: &Ray, t: f32, pdf: f32) -> f32 {
        let Some(light) = self.scene.lights().of(primitive).filter(|_| pdf != SPECULAR) else {
            return 1.0;
        };
        match self.settings.sampling {
            Sampling::Bsdf => 1.0,
            Sampling::Light => 0.0,
            Sampling::Mis => power_heuristic(pdf, light::pdf(light, ray, t) * light.chance),
        }
    }

    /// Radiance that one light sends directly to `surface` and on along the path, estimated
    /// with one shadow ray.
    fn direct(
        &mut self,
        bsdf: &Bsdf,
        surface: &Surface,
        normal: Vec3,
        time: f32,
        segment: u32,
        randoms: &Randoms,
    ) -> Vec3 {
        if !self.settings.samples_lights(self.scene) || bsdf.is_specular() {
            return Vec3::ZERO;
        }
        let light = self.scene.lights().choose(randoms.bits(Dimension::LIGHT_CHOICE));
        let from = surface.spawn(normal);
        let sample = light::sample(light, from, time, randoms.two(Dimension::LIGHT));
        let Some(LightSample { direction, distance, pdf, front }) = sample else {
            return Vec3::ZERO;
        };
        let emitted = light.emission.radiance(front);
        let (f_cos, bsdf_pdf) = bsdf.evaluate(direction);
        if !(max_element(f_cos) > 0.0) || emitted == Vec3::ZERO {
            return Vec3::ZERO;
        }
        self.rays.shadow += 1;
        // What is seen through the surface is as far from its other side, but for rounding.
        let side = if dot(direction, normal) > 0.0 { normal } else { -normal };
        let shadow = Ray { origin: surface.spawn(side), direction, time };
        if self.intersect.occluded(&shadow, distance * SHADOW_REACH, segment) {
            return Vec3::ZERO;
        }
        let pdf = pdf * light.chance;
        let weight = match self.settings.sampling {
            Sampling::Mis => power_heuristic(pdf, bsdf_pdf),
            _ => 1.0,
        };
        let crossing = medium::transmittance(self.scene.media(), &shadow, distance);
        f_cos * emitted * (weight / pdf * crossing)
    }
}

/// Weight of a sample that was drawn with density `of` where `other` could have drawn it too
/// (Veach 1997, section 9.2.4, exponent 2), written so that no square overflows.
#[inline]
fn power_heuristic(of: f32, other: f32) -> f32 {
    let ratio = other / of;
    1.0 / (1.0 + ratio * ratio)
}
