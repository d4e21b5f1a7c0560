//! Collide: where paths meet media before what they hit.

use super::materials::Materials;
use super::paths::Paths;
use super::rays::Rays;
use crate::accel::{HitBatch, RayVector};
use crate::engine::dimension::{Dimension, Randoms};
use crate::engine::settings::Sampler;
use crate::geometry::lanes::interval;
use crate::scene::Medium;
use crate::simd::powers::{exp, ln};
use crate::simd::{Float, Int, LANES, Vec3x};

/// Puts the first collision of each ray, if it has one, in the place of what it hit: a collision is
/// told by [`Materials::first_medium`] and the medium's number.
#[inline(never)]
pub(super) fn collide(
    media: &[Medium],
    materials: &Materials,
    (sampler, segment): (Sampler, u32),
    paths: &Paths,
    rays: &Rays,
    hits: &mut HitBatch,
) {
    for first in (0..rays.len()).step_by(LANES) {
        let path = paths.indices(rays.paths(first));
        let randoms = Randoms::new(sampler, paths.keys(&path), segment);
        let RayVector { origin, direction, .. } = rays.batch.vector(first);
        let mut end = Float::load(&hits.t[first..]);
        let mut what = Int::load(&hits.primitive[first..]);
        for (index, medium) in (0..).zip(media) {
            let (near, far) = interval(&medium.volume, origin, direction);
            let chance = Float::splat(1.0) - randoms.one(Dimension::medium(index));
            let t = near - ln(chance) / Float::splat(medium.density);
            let collides = t.lt(far.min(end));
            end = collides.select(t, end);
            what = Int::select(collides, Int::splat(materials.first_medium() + index), what);
        }
        end.store(&mut hits.t[first..]);
        what.store(&mut hits.primitive[first..]);
    }
}

/// The share of light that crosses rays up to distance `end` without a collision.
#[inline(always)]
pub(super) fn transmittance(
    media: &[Medium],
    origin: Vec3x,
    direction: Vec3x,
    end: Float,
) -> Float {
    let mut depth = Float::ZERO;
    for medium in media {
        let (near, far) = interval(&medium.volume, origin, direction);
        let length = Float::ZERO.max(far.min(end) - near);
        depth = depth + Float::splat(medium.density) * length;
    }
    exp(-depth)
}
