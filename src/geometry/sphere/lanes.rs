//! Tests of spheres and rays in lanes.

use crate::geometry::{HitLanes, RayLanes};
use crate::math::{Real, UNIT_ROUNDOFF};
use crate::simd::{Float, Vec3x};

/// Intersects rays with spheres whose centres are at `center` at the rays' times. Only distances
/// above `t_min` count as hits. Returns `None` if no lane comes near its sphere.
///
/// With `ASK`, rays that start outside the sphere and point away from it are ruled out before the
/// square root is taken. That pays off if [`misses`] has not been called or, for huge spheres,
/// does not reject such rays because of its margin.
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
        // Both roots are 0 or less: b + √… has the sign of b, and c is not negative.
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

/// Returns the lanes whose rays certainly miss their spheres. These are most of the lanes without a
/// hit in [`hits`]. This function takes half the work of [`hits`], in free arithmetic (fused
/// multiply-adds), and pays off if usually no lane comes near its sphere.
///
/// With `f` known exactly and u the unit roundoff, r² − l·l = r² − f·f + (f·d)²/d·d is off by at
/// most 17u f·f + 3u r² here, and by 16u f·f in [`hits`]. For a ray that hits, r² + (f·d)²/d·d is
/// thus at least f·f up to an error of 16u f·f. A margin of 37u of both terms is enough, and the
/// code takes 64u. If the sign of f·d is in doubt, (f·d)²/d·d is below 9u² f·f. A ray that
/// certainly starts outside and points away hits nothing at distances above 0.
#[inline(always)]
pub(crate) fn misses(ray: &RayLanes, center: Vec3x, padded_radius2: Float) -> u32 {
    let (Vec3x([fx, fy, fz]), Vec3x([dx, dy, dz])) = (ray.origin - center, ray.direction);
    let away = fz.free_mul_add(dz, fy.free_mul_add(dy, fx * dx));
    let toward = away.min(Float::ZERO);
    // `outside` is f·f − r². For rays that point toward the sphere, the discriminant is r² − l·l.
    // The margin makes `outside` too small and the discriminant too large.
    let outside = fz.free_mul_add(fz, fy.free_mul_add(fy, fx.free_mul_sub(fx, padded_radius2)));
    let discriminant = (toward * ray.padded_inv_length2).free_mul_sub(toward, outside);
    discriminant.lt(Float::ZERO).bits()
}

/// r², enlarged by the margin of [`misses`].
#[inline(always)]
pub(crate) fn padded_radius2(radius: Float) -> Float {
    // The tiny summand covers underflow.
    radius * (radius * Float::splat(1.0 + 72.0 * UNIT_ROUNDOFF)) + Float::splat(1e-36)
}
