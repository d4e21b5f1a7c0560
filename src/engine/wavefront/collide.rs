//! Collide: finds collisions of paths in media, in front of their hits.

use super::{Paths, WaveRays};
use crate::accel::HitBatch;
use crate::sampler::{Randoms, Sampler};
use crate::shading::SceneTables;
use crate::simd::{Float, Int, LANES};

/// Replaces the hit of each ray with its first collision in a medium, if it has one before the hit.
#[inline(never)]
pub(super) fn collide(
    tables: &SceneTables,
    (sampler, segment): (Sampler, u32),
    paths: &Paths,
    rays: &WaveRays,
    hits: &mut HitBatch,
) {
    for first in (0..rays.len()).step_by(LANES) {
        let path = paths.indices(rays.paths(first));
        let randoms = Randoms::new(sampler, paths.keys(&path), segment);
        let hit = (Float::load(&hits.t[first..]), Int::load(&hits.primitive[first..]));
        let (t, primitive) = tables.media.collide(&rays.batch.vector(first).ray(), hit, &randoms);
        t.store(&mut hits.t[first..]);
        primitive.store(&mut hits.primitive[first..]);
    }
}
