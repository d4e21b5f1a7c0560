//! First hits, for layers.

use super::ShadeInputs;
use crate::engine::first_hit::FirstHit;
use crate::engine::wavefront::layer_samples::LayerSamples;
use crate::engine::wavefront::{Paths, Queue};
use crate::geometry::{Hit, Shape};
use crate::math::Real;
use crate::shading::Key;
use crate::shading::material::{Bsdf, MaterialModel, MaterialTable};
use crate::simd::{Float, Int, LANES, Mask};

impl ShadeInputs<'_> {
    /// Stores the first hits of the paths of `queue`, which do not depend on surfaces.
    #[inline(never)]
    pub(super) fn first_hits(
        &self,
        key: Key,
        queue: Queue<'_>,
        paths: &Paths,
        samples: &mut LayerSamples,
    ) {
        for first in (0..queue.len()).step_by(LANES) {
            let [path, t, primitive] = queue.rows(first);
            let path = paths.indices(path);
            let hit = match key {
                Key::Background => FirstHit::none(self.segment),
                Key::Medium => {
                    let ray = paths.segments(&path).ray;
                    let point = ray.origin + ray.direction * Float::from_bits(t);
                    let albedo = self.tables.media.phase::<Float>(primitive).albedo();
                    FirstHit::in_medium(self.scene, self.camera, point, albedo)
                }
                Key::Surface { .. } => FirstHit::anything(),
            };
            samples.store(&path, &hit, Mask::NONE);
            if self.segment == 1 && !hit.exists {
                samples.meet_background(&path);
            }
        }
    }

    /// Stores the first hits of the paths of `queue` on surfaces of one shape and kind of material. Scattering computes
    /// the same once more: only the first segments of paths need both, and loops with both would take long to compile.
    #[inline(never)]
    pub(super) fn first_hits_on<M: MaterialModel>(
        &self,
        table: &MaterialTable<M::Entry>,
        shape: Shape,
        queue: Queue<'_>,
        paths: &Paths,
        samples: &mut LayerSamples,
    ) {
        let instanced = shape == Shape::Instance;
        for first in (0..queue.len()).step_by(LANES) {
            let [path, t, primitive] = queue.rows(first);
            let instance = if instanced { queue.instances(first) } else { Int::ZERO };
            let path = paths.indices(path);
            let hit = Hit { t: Float::from_bits(t), primitive, instance };
            let ray = paths.segments(&path).ray;
            let mut at = self.tables.interaction(shape, ray, hit, true, M::GLOSSY, instanced);
            let rows = &table.entries[..];
            let entries = self.tables.looks.entries::<Float>(shape, primitive, rows.len());
            at.map_normals(table, entries, M::GLOSSY);
            let bsdf = M::bsdf::<Float>(rows, entries, &at);
            let hit = FirstHit::on_surface(self.scene, self.camera, &at, &bsdf);
            samples.store(&path, &hit, bsdf.specular());
        }
    }
}
