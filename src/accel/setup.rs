//! What the kernels compute once a ray, a vector of rays at a time.

use glam::Vec3;

use super::batch::RayBatch;
use super::slab::SLACK;
use crate::geometry::lanes::RayLanes;
use crate::geometry::{Bounds, Geometry};
use crate::math::{UNIT_ROUNDOFF, max_element};
use crate::simd::{Float, Mask, Vec3x, axes, first_bits};

/// What a layout says of its scene that rays must know.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    /// Box around all that is in boxes.
    bounds: Bounds,
    /// Largest [`condition`](crate::geometry::Quad::condition) of the scene's quads, at least 1.
    condition: f32,
    /// Whether no product of the slab test can overflow or underflow for a tame ray.
    tame: bool,
    /// Whether there are boxes to test.
    boxes: bool,
    /// Whether there are triangles to test.
    pub(super) triangles: bool,
}

impl Extent {
    pub(super) fn new(geometry: &Geometry, bounds: Bounds) -> Self {
        let condition = geometry.condition();
        let is_empty = bounds == Bounds::EMPTY;
        // No boxes, no overflow; the farthest distance must still be a number.
        let bounds = if is_empty { Bounds { min: Vec3::ZERO, max: Vec3::ZERO } } else { bounds };
        let tame = max_element(bounds.min.abs()) <= TAME_COORDINATE
            && max_element(bounds.max.abs()) <= TAME_COORDINATE
            && (is_empty || (bounds.max - bounds.min).element_sum() >= TAME_EDGES);
        let triangles = !geometry.triangles.is_empty();
        Self { bounds, condition, tame, boxes: !is_empty, triangles }
    }

    /// The slack that is enough for rays which begin no farther from all boxes than `reach` times
    /// the sum of the edges of a box around them.
    pub(super) fn slack_within(&self, reach: f32) -> f32 {
        let Bounds { min, max } = self.bounds;
        let edges = (max - min).element_sum();
        let coordinate = max_element(min.abs().max(max.abs()));
        (1.0 + 3.0 * reach) * edges * (SLACK * self.condition)
            + (coordinate + reach * edges) * (4.0 * UNIT_ROUNDOFF)
    }
}

/// A vector of rays with what the tests share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Setup {
    pub(super) ray: RayLanes,
    pub(super) t_max: Float,
    pub(super) slab: SlabLanes,
    pub(super) shear: Shear,
    /// The rays that are there, finite, and have a direction.
    pub(super) active: u32,
}

/// The slab test of [`super::slab`] in the form plane × inverse − offset: one operation a
/// plane. Or middle × inverse − offset, ∓ half edge × steepness: one more for both planes of an
/// axis, and no choice between them.
///
/// Departures from the scalar test:
/// 1. A component of the direction below 1e-10 of the largest is taken as that, so that no
///    product is NaN. This moves a plane by 1e-10 of the scene's size, well within the slack.
/// 2. All is rounded, at most, by 3 roundings of the origin and 4 of the farthest distance; the
///    slack contains 4 of the one and 6 of the other.
/// 3. Planes move outward by the slack in the boxes that are made so ([`super::pair`]), or else
///    in the offsets ([`Setup::offsets`]).
#[derive(Clone, Copy, Debug)]
pub(super) struct SlabLanes {
    pub(super) inverse: Vec3x,
    /// The inverse's magnitude.
    pub(super) steepness: Vec3x,
    /// Origin × inverse.
    pub(super) offset: Vec3x,
    /// How far planes must move outward.
    pub(super) slack: Float,
}

/// The shear of triangle tests. Where the rays' longest axes differ, each lane has its own.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shear {
    pub(super) shear: Vec3x,
    /// Rays whose longest axis is x; y; neither.
    pub(super) longest: [Mask; 3],
    /// Rays whose direction is negative on the longest axis.
    pub(super) negative: Mask,
}

/// Largest coordinate, least sum of the edges of a box around all, and range of a direction's
/// largest component, for which no product of the slab test overflows, or underflows where it
/// matters.
const TAME_COORDINATE: f32 = 1e10;
const TAME_EDGES: f32 = 1e-20;
const TAME_DIRECTION: std::ops::Range<f32> = 1e-15..1e15;

impl Setup {
    pub(super) const NONE: Self = Self {
        ray: RayLanes::NONE,
        t_max: Float::ZERO,
        slab: SlabLanes::NONE,
        shear: Shear::NONE,
        active: 0,
    };

    /// Rays `first..` of `rays`, those below `end` active. The second value has the
    /// bits of rays that are finite but too wild for the slab test.
    #[inline(always)]
    pub(super) fn load(rays: &RayBatch, first: usize, end: usize, extent: &Extent) -> (Self, u32) {
        let load = |array: &Vec<f32>| Float::load(&array[first..]);
        let vector = |arrays: &[Vec<f32>; 3]| Vec3x(axes(|axis| load(&arrays[axis])));
        let (origin, direction) = (vector(&rays.origin), vector(&rays.direction));
        let (time, t_min, t_max) = (load(&rays.time), load(&rays.t_min), load(&rays.t_max));

        let [ax, ay, az] = axes(|axis| direction[axis].abs());
        let largest = ax.max(ay).max(az);
        let reach = axes(|axis| origin[axis].abs());
        let far = reach[0].max(reach[1]).max(reach[2]);
        // 0 x is 0 where x is finite, else NaN.
        let zero = |v: Vec3x| v[0] * Float::ZERO + v[1] * Float::ZERO + v[2] * Float::ZERO;
        let finite = (zero(origin) + zero(direction) + time * Float::ZERO).eq(Float::ZERO);
        let moves = largest.gt(Float::ZERO);
        let tame = far.le(Float::splat(TAME_COORDINATE))
            & largest.ge(Float::splat(TAME_DIRECTION.start))
            & largest.le(Float::splat(TAME_DIRECTION.end));
        let tame = if extent.tame { tame.bits() } else { 0 };
        // Nothing lies in an interval that is empty or NaN.
        let real = (finite & moves & t_min.lt(t_max)).bits() & first_bits(end - first);

        let length2 = direction.dot(direction);
        let one = Float::splat(1.0);
        let ray = RayLanes { origin, direction, time, length2, inv_length2: one / length2, t_min };
        let setup = Self {
            ray,
            t_max,
            slab: if extent.boxes {
                SlabLanes::new(&ray, largest, far, extent)
            } else {
                SlabLanes::NONE
            },
            shear: if extent.triangles { Shear::new(direction, [ax, ay, az]) } else { Shear::NONE },
            active: real & tame,
        };
        (setup, real & !tame)
    }

    /// For each of a box's [`Planes`](super::slab::Planes) the offset with the slack in it: low
    /// ones move down and high ones up, whichever of them is near.
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

    #[inline(always)]
    fn new(ray: &RayLanes, largest: Float, far: Float, extent: &Extent) -> Self {
        let Vec3x(origin) = ray.origin;
        let reach = |axis: usize| {
            let to = |plane: Vec3| (Float::splat(plane[axis]) - origin[axis]).abs();
            to(extent.bounds.min).max(to(extent.bounds.max))
        };
        let farthest = reach(0) + reach(1) + reach(2);
        let slack = farthest * Float::splat(SLACK * extent.condition)
            + far * Float::splat(4.0 * UNIT_ROUNDOFF);
        let least = largest * Float::splat(1e-10);
        let Vec3x(direction) = ray.direction;
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
