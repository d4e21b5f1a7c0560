//! First hits that do not depend on surfaces.

use super::ShadeInputs;
use crate::engine::first_hit::FirstHit;
use crate::engine::wavefront::layer_samples::LayerSamples;
use crate::engine::wavefront::{Paths, Queue};
use crate::math::Real;
use crate::shading::Key;
use crate::shading::material::Bsdf;
use crate::simd::{Float, LANES, Mask};

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
}
