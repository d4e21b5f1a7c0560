//! Scattering: samples the next direction of each path, or terminates it.

use super::bodies::Sides;
use super::vertex::Vertex;
use super::{ShadeInputs, ShadeOutputs};
use crate::engine::wavefront::{History, Queue, Segment};
use crate::geometry::{Ray, Shape, Surface};
use crate::math::{Real, max_element};
use crate::sampler::Dimension;
use crate::shading::Nesting;
use crate::shading::material::{Bsdf, MaterialModel, MaterialTable, Scatter};
use crate::simd::{Float, Int, LANES, Vec3x};

/// The loops over surfaces, from the fastest to the slowest: without textures, with textures, and also with normal
/// maps, instances and bodies that absorb light. Code that is never used slows a loop down by 6 to 10%. Kinds with
/// much code of their own have only the last one.
pub(super) const PLAIN: u8 = 0;
pub(super) const COLORED: u8 = 1;
pub(super) const GENERAL: u8 = 2;

impl ShadeInputs<'_> {
    /// Scatters the paths of `queue` at surfaces of one shape and kind of material.
    ///
    /// It is not inlined, so that each kind of material has all registers to itself.
    #[inline(never)]
    pub(super) fn scatter<M: MaterialModel, const LOOP: u8>(
        &self,
        table: &MaterialTable<M::Entry>,
        shape: Shape,
        queue: Queue<'_>,
        shaded: &mut ShadeOutputs<'_>,
    ) {
        let instanced = LOOP >= GENERAL && shape == Shape::Instance;
        for first in (0..queue.len()).step_by(LANES) {
            let vertex = self.vertex(queue, first, shaded.paths, instanced);
            let (ray, hit) = (vertex.segment.ray, vertex.hit);
            let mut at =
                self.tables.interaction(shape, ray, hit, LOOP > PLAIN, M::GLOSSY, instanced);
            let rows = &table.entries[..];
            let entries = self.tables.looks.entries::<Float>(shape, hit.primitive, rows.len());
            if LOOP >= GENERAL {
                at.map_normals(table, entries, M::GLOSSY);
            }
            let bsdf = M::bsdf::<Float>(rows, entries, &at);
            let beyond =
                |here: Nesting<Float>| here.beyond(Float::pick(&table.bodies, entries), at.front);
            let sides =
                if LOOP >= GENERAL { self.sides(&vertex, shaded.paths, beyond) } else { None };
            let bsdf = at.smoothed(bsdf);
            self.go_on(&vertex, sides, &at.surface, at.normal, &bsdf, shaded);
        }
    }

    /// Scatters the paths of `queue` in media.
    #[inline(never)]
    pub(super) fn scatter_in_media(&self, queue: Queue<'_>, shaded: &mut ShadeOutputs<'_>) {
        for first in (0..queue.len()).step_by(LANES) {
            let vertex = self.vertex(queue, first, shaded.paths, false);
            let Ray { origin, direction, .. } = vertex.segment.ray;
            // A medium has no surface that rays could hit again, so they start at offset 0.
            let point = origin + direction * vertex.hit.t;
            let surface = Surface::flat(point, direction, Float::ZERO);
            let phase = self.tables.media.phase(vertex.hit.primitive);
            let sides = self.sides(&vertex, shaded.paths, |here| here);
            self.go_on(&vertex, sides, &surface, -direction, &phase, shaded);
        }
    }

    /// Samples direct light, scatters the paths, and appends those that continue. `normal` is on
    /// the side where they arrive.
    #[inline(always)]
    fn go_on<B: Bsdf<Float>>(
        &self,
        vertex: &Vertex,
        sides: Option<Sides>,
        surface: &Surface<Float>,
        normal: Vec3x,
        bsdf: &B,
        shaded: &mut ShadeOutputs<'_>,
    ) {
        if self.settings.samples_lights(self.scene) {
            self.direct(vertex, sides, surface, normal, bsdf, shaded.shadows);
        }
        let Scatter { direction, transmitted, weight, pdf, scattered } =
            bsdf.sample(&vertex.randoms);
        let mut beta = vertex.history.beta * weight;
        // Terminate paths of zero throughput, and most paths of low throughput.
        let present = vertex.present;
        let scattered = present & scattered.bits();
        let black = scattered & max_element(beta).le(Float::ZERO).bits();
        let mut goes_on = scattered & !black;
        let endings = &mut *shaded.endings;
        endings.absorbed += u64::from((present & !scattered).count_ones());
        endings.black += u64::from(black.count_ones());
        if self.survival.applies(self.segment + 1) {
            let survival: Float = self.survival.probability(beta);
            let ended = goes_on & vertex.randoms.one(Dimension::ROULETTE).ge(survival).bits();
            endings.roulette += u64::from(ended.count_ones());
            goes_on &= !ended;
            beta = beta / survival;
        }
        let side = transmitted.select(-normal, normal);
        let ray = Ray { origin: surface.spawn(side), direction, time: vertex.segment.ray.time };
        shaded.paths.set_segments(&vertex.path, &Segment { ray, pdf });
        shaded.paths.set_beta(&vertex.path, &History { beta, ..vertex.history });
        if let Some(sides) = sides {
            shaded.paths.set_nestings(&vertex.path, sides.select(transmitted));
        }
        let cells = self.cells.of(ray.origin, direction);
        shaded.next.append(&[Int::new(*vertex.path.lanes()), cells], goes_on);
    }
}
