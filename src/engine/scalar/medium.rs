//! What media do to rays.

use crate::engine::dimension::{Dimension, Randoms};
use crate::geometry::Ray;
use crate::math::powers::{exp, ln};
use crate::math::{max, min};
use crate::scene::Medium;

/// The first collision along `ray` before distance `end`. Media do not overlap, and so each has its own
/// chance: the nearest of their collisions is the first.
pub(in crate::engine) fn collide<'a>(
    media: &'a [Medium],
    ray: &Ray,
    end: f32,
    randoms: &Randoms,
) -> Option<(f32, &'a Medium)> {
    let mut first = None;
    let mut end = end;
    for (index, medium) in (0..).zip(media) {
        let (near, far) = medium.volume.interval(ray);
        // An exponential distance: e^−σt of the light gets farther than t.
        let chance = 1.0 - randoms.one(Dimension::medium(index));
        let t = near - ln(chance) / medium.density;
        if t < min(far, end) {
            (first, end) = (Some((t, medium)), t);
        }
    }
    first
}

/// The share of light that crosses `ray` up to distance `end` without a collision.
pub(in crate::engine) fn transmittance(media: &[Medium], ray: &Ray, end: f32) -> f32 {
    let mut depth = 0.0;
    for medium in media {
        let (near, far) = medium.volume.interval(ray);
        depth += medium.density * max(0.0, min(far, end) - near);
    }
    exp(-depth)
}
