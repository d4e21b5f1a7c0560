//! Spheres over lanes.

use crate::geometry::ray_lanes::{HitLanes, RayLanes};
use crate::math::UNIT_ROUNDOFF;
use crate::simd::{Float, Vec3x};

/// Hits of spheres that are at `center` at the rays' times, above `t_min`; `None` where no
/// lane comes near.
///
/// With `ASK`, rays that are outside and go away are ruled out before a root is taken: worth it
/// where [`misses`]'s margin has not done so, that is for huge spheres, or without it.
#[inline(always)]
pub(crate) fn hits<const ASK: bool>(
    ray: &RayLanes,
    center: Vec3x,
    radius: Float,
) -> Option<HitLanes> {
    let f = ray.origin - center;
    let b = -f.dot(ray.direction);
    let l = f + ray.direction * (b * ray.inv_length2);
    let discriminant = radius * radius - l.dot(l);
    let c = f.dot(f) - radius * radius;
    let mut real = discriminant.ge(Float::ZERO);
    if ASK {
        // Roots that are both 0 or less: b + √… has the sign of b, c is not negative.
        real = real & !(b.lt(Float::ZERO) & c.ge(Float::ZERO));
    }
    if !real.any() {
        return None;
    }
    let q = b + (ray.length2 * discriminant).sqrt().copysign(b);
    let by_sum = q * ray.inv_length2;
    let most = by_sum.abs();
    let by_product = (c / q).max(-most).min(most);
    let ahead = b.gt(Float::ZERO);
    let (near, far) = (ahead.select(by_product, by_sum), ahead.select(by_sum, by_product));
    let t = near.gt(ray.t_min).select(near, far);
    Some(HitLanes { t, hit: real & t.gt(ray.t_min) })
}

/// Lanes whose rays surely miss spheres: most of those for which [`hits`] has no hit. In free
/// arithmetic, half the work of the test: for lanes of which mostly none comes near. Of the spheres
/// it takes [`padded_radius2`].
///
/// With `f` known exactly and u the unit roundoff, r² − l·l = r² − f·f + (f·d)²/d·d is off by at most
/// 17u f·f + 3u r² here, by 16u f·f in the test. Of a ray that hits, r² + (f·d)²/d·d is thus f·f but
/// for 16u of it, and 37u of both terms are enough; 64u are taken. Where the sign of f·d is in doubt,
/// (f·d)²/d·d is below 9u² f·f. A ray that is surely outside and goes away hits nothing at distances
/// above 0.
#[inline(always)]
pub(crate) fn misses(ray: &RayLanes, center: Vec3x, padded_radius2: Float) -> u32 {
    let (Vec3x([fx, fy, fz]), Vec3x([dx, dy, dz])) = (ray.origin - center, ray.direction);
    let away = fz.free_mul_add(dz, fy.free_mul_add(dy, fx * dx));
    let toward = away.min(Float::ZERO);
    // f·f − r², and of rays that go toward the sphere l·l − r², both too small by the margin.
    let outside = fz.free_mul_add(fz, fy.free_mul_add(fy, fx.free_mul_sub(fx, padded_radius2)));
    let discriminant = (toward * ray.padded_inv_length2).free_mul_sub(toward, outside);
    discriminant.lt(Float::ZERO).bits()
}

/// r² and the margin of [`misses`].
#[inline(always)]
pub(crate) fn padded_radius2(radius: Float) -> Float {
    // The tiny number is for underflow.
    radius * (radius * Float::splat(1.0 + 72.0 * UNIT_ROUNDOFF)) + Float::splat(1e-36)
}
