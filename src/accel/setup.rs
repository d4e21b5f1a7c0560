//! Per-ray setup: values that the kernels compute once for each ray, a vector at a time.

use super::slab::SLACK;
use super::{Extent, ExtentLanes, RayVector};
use crate::geometry::{Ray, RayLanes};
use crate::math::{Real, UNIT_ROUNDOFF};
use crate::simd::{Float, Mask, Vec3x, axes};

/// A vector of rays, with the values that several tests share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Setup {
    pub(super) ray: RayLanes,
    pub(super) slab: SlabLanes,
    pub(super) shear: Shear,
    /// Bits of the active lanes: those whose ray is present, is safe for the slab test, and has a
    /// non-empty interval.
    pub(super) active: u32,
}

/// The slab test of [`super::slab`] over lanes.
///
/// The distance of a plane is plane × inverse − offset, one operation for each plane. With mixed
/// directions, the distances of both planes of an axis are middle × inverse − offset ∓ half edge ×
/// steepness: one operation more for each axis, but near and far plane need not be selected.
///
/// Departures from the scalar test:
/// 1. A component of the direction whose magnitude is less than 1e-10 times the sum of the three
///    magnitudes is raised to that value, so that no product is NaN. This moves a plane by 3e-10 of
///    the farthest distance, well within the slack.
/// 2. The rounding error is at most 3 roundings of the origin and 4 of the farthest distance; the
///    slack allows for 4 and 6.
/// 3. The slack that moves planes outward is contained either in the boxes ([`super::tree::pair`])
///    or in the offsets ([`Setup::offsets`]).
#[derive(Clone, Copy, Debug)]
pub(super) struct SlabLanes {
    pub(super) inverse: Vec3x,
    /// Magnitude of the inverse.
    pub(super) steepness: Vec3x,
    /// Origin × inverse.
    pub(super) offset: Vec3x,
    /// Distance by which planes must move outward.
    pub(super) slack: Float,
}

/// The shear of triangle tests. Each lane has its own, so rays may differ in their longest axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shear {
    pub(super) shear: Vec3x,
    /// Lanes whose direction is longest on x, on y, and on neither of them.
    pub(super) longest: [Mask; 3],
    /// Lanes whose direction is negative on its longest axis.
    pub(super) negative: Mask,
}

impl Setup {
    pub(super) const NONE: Self =
        Self { ray: RayLanes::NONE, slab: SlabLanes::NONE, shear: Shear::NONE, active: 0 };

    /// Prepares the `rays` whose bits are set in `present`. Returns the bits of the "wild" rays,
    /// which are finite but too large or too small for the slab test. The scalar reference must
    /// trace them.
    ///
    /// The setup is written in place, because moving a large value copies it. Only the parts that
    /// the scene needs are computed.
    #[inline(always)]
    pub(super) fn load(&mut self, rays: &RayVector, present: u32, extent: &Extent) -> u32 {
        let RayVector { origin, direction, time, t_min, t_max } = *rays;

        // Sums propagate NaN, while a maximum may hide it.
        let [ax, ay, az] = axes(|axis| direction[axis].abs());
        let speed = ax + ay + az;
        let far = origin[0].abs() + origin[1].abs() + origin[2].abs();
        let tame = (far + time.abs()).le(Float::splat(extent.tame_reach))
            & speed.ge(Float::splat(extent.tame_speed.start))
            & speed.le(Float::splat(extent.tame_speed.end));
        // An interval that is empty or has a NaN contains no hit.
        let open = t_min.lt(t_max).bits() & present;
        self.active = open & tame.bits();
        let mut wild = open & !tame.bits();
        if wild != 0 {
            // 0 · x is 0 if x is finite, else NaN.
            let zero = |v: Vec3x| v[0] * Float::ZERO + v[1] * Float::ZERO + v[2] * Float::ZERO;
            let finite = zero(origin) + zero(direction) + time * Float::ZERO;
            let moves = ax.max(ay).max(az).gt(Float::ZERO);
            wild &= (finite.eq(Float::ZERO) & moves).bits();
        }

        self.ray = RayLanes::new(origin, direction, time, t_min);
        if extent.boxes {
            self.slab = SlabLanes::new(&self.ray, speed, far, &extent.lanes());
        }
        if extent.triangles {
            self.shear = Shear::new(direction, [ax, ay, az]);
        }
        wild
    }

    /// Prepares rays in the object spaces of instances, where no product overflows. The lengths of
    /// their directions are left out, because the tests of triangles do not need them.
    #[inline(always)]
    pub(super) fn in_object_space(ray: Ray<Float>, t_min: Float, extent: &ExtentLanes) -> Self {
        let Ray { origin, direction, time } = ray;
        let [ax, ay, az] = axes(|axis| direction[axis].abs());
        let far = origin[0].abs() + origin[1].abs() + origin[2].abs();
        let ray = RayLanes { origin, direction, time, t_min, ..RayLanes::NONE };
        let slab = SlabLanes::new(&ray, ax + ay + az, far, extent);
        Self { ray, slab, shear: Shear::new(direction, [ax, ay, az]), active: 0 }
    }

    /// Returns the offset of each of a box's [`Planes`](super::slab::Planes), slack included: low
    /// planes move down and high planes up, whichever of them is near.
    #[inline(always)]
    pub(super) fn offsets(&self) -> [Float; 6] {
        let SlabLanes { inverse, slack, .. } = self.slab;
        let low = |axis: usize| (self.ray.origin[axis] + slack) * inverse[axis];
        let high = |axis: usize| (self.ray.origin[axis] - slack) * inverse[axis];
        [low(0), low(1), low(2), high(0), high(1), high(2)]
    }
}

impl SlabLanes {
    const NONE: Self = Self {
        inverse: Vec3x::ZERO,
        steepness: Vec3x::ZERO,
        offset: Vec3x::ZERO,
        slack: Float::ZERO,
    };

    /// `speed` and `far` are the sums of the magnitudes of the components of the rays' directions
    /// and origins.
    #[inline(always)]
    fn new(ray: &RayLanes, speed: Float, far: Float, extent: &ExtentLanes) -> Self {
        let (Vec3x(origin), Vec3x(direction)) = (ray.origin, ray.direction);
        let from_middle = |axis: usize| (origin[axis] - extent.middle[axis]).abs();
        let farthest = from_middle(0) + from_middle(1) + from_middle(2) + extent.half_edges;
        let slack = farthest * (extent.condition * SLACK) + far * Float::splat(4.0 * UNIT_ROUNDOFF);
        let least = speed * Float::splat(1e-10);
        let steepness = axes(|axis| Float::splat(1.0) / direction[axis].abs().max(least));
        let inverse = axes(|axis| steepness[axis].copysign(direction[axis]));
        let offset = axes(|axis| origin[axis] * inverse[axis]);
        Self { inverse: Vec3x(inverse), steepness: Vec3x(steepness), offset: Vec3x(offset), slack }
    }
}

impl Shear {
    const NONE: Self = Self { shear: Vec3x::ZERO, longest: [Mask::NONE; 3], negative: Mask::NONE };

    #[inline(always)]
    fn new(Vec3x([dx, dy, dz]): Vec3x, [ax, ay, az]: [Float; 3]) -> Self {
        let is_x = ax.gt(ay) & ax.gt(az);
        let is_y = !ax.gt(ay) & ay.gt(az);
        let by_axis = |x, y, z| is_x.select(x, is_y.select(y, z));
        let longest = by_axis(dx, dy, dz);
        let negative = longest.lt(Float::ZERO);
        let (next, last) = (by_axis(dy, dz, dx), by_axis(dz, dx, dy));
        let (first, second) = (negative.select(last, next), negative.select(next, last));
        let inverse = Float::splat(1.0) / longest;
        Self {
            shear: Vec3x([first * inverse, second * inverse, inverse]),
            longest: [is_x, is_y, !(is_x | is_y)],
            negative,
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::geometry::{Bounds, Geometry, Quad};
    use crate::math::{Stream, max, max_element};

    /// Except for rounding, the slack is at least that of [`SlabRay`](super::super::slab::SlabRay),
    /// and at most three times as large. For rays that begin near the boxes, it does not exceed the
    /// slack that [`Extent::slack_within`] returns.
    #[test]
    fn slack_is_that_of_the_reference() {
        let (mut random, mut within, mut conditions) = (Stream::new(21), 0, 1.0);
        for round in 0..10_000 {
            let size = [1e-6, 1.0, 1e6][round % 3];
            let mut point =
                |size: f32| Vec3::from_array([(); 3].map(|()| random.between(-size, size)));
            let (a, b, shift) = (point(size), point(size), point([0.0, 10.0 * size][round % 2]));
            let bounds = Bounds { min: a.min(b) + shift, max: a.max(b) + shift };
            // Alternate between no quad and a thin one.
            let thin = (Vec3::X, Vec3::X + Vec3::Y * (0.02 + 0.01 * (round % 50) as f32));
            let quads = Quad::new(Vec3::ZERO, thin.0, thin.1).into_iter().take(round % 2).collect();
            let geometry = Geometry { quads, ..Geometry::default() };
            let condition = geometry.condition();
            conditions = max(conditions, condition);
            let extent = Extent::new(&geometry, bounds, bounds);
            let (origin, reach) = (shift + point(8.0 * size), [1.0, 4.0][round % 2]);
            let want = SLACK * condition * bounds.farthest_distance(origin)
                + 4.0 * UNIT_ROUNDOFF * max_element(origin.abs());
            let lanes = |v: Vec3| Vec3x(axes(|axis| Float::splat(v[axis])));
            let ray =
                RayLanes { origin: lanes(origin), direction: lanes(Vec3::ONE), ..RayLanes::NONE };
            let far = Float::splat(origin.abs().element_sum());
            let slack = SlabLanes::new(&ray, Float::splat(3.0), far, &extent.lanes()).slack.first();
            assert!(slack >= want * (1.0 - 1e-5) && slack <= 3.0 * want, "{slack} {want}");
            let edges = (bounds.max - bounds.min).element_sum();
            let away = (bounds.min - origin).max(origin - bounds.max);
            if max_element(away) <= 0.999 * reach * edges {
                within += 1;
                assert!(slack <= extent.slack_within(reach), "{bounds:?} {origin}");
            }
        }
        assert!(within > 1000, "only {within} rays begin near the boxes");
        assert!(conditions > 10.0, "the thinnest quad has condition {conditions}, not above 10");
    }
}
