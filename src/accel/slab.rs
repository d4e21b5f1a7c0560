//! The slab test of a ray and a box, conservative in the face of rounding.

use glam::Vec3;

use crate::geometry::{Bounds, Ray};
use crate::math::{UNIT_ROUNDOFF, max, max_element, min};
use crate::simd::axes;

/// A ray prepared for slab tests (report, III.F; Majercik et al. 2018).
///
/// Departures from the report's test:
/// 1. Its exit distance takes `max` where `min` is meant, so that hardly a box is missed.
/// 2. The planes are moved outward: a primitive's distance is rounded, by an amount that
///    grows with how far away it is, and a box must not be skipped for a hit that the
///    primitive would report (Ize 2013, "Robust BVH Ray Traversal", widens the exit only).
///    The slack is built into two origins, one for near and one for far planes.
#[derive(Clone, Copy, Debug)]
pub(super) struct SlabRay {
    /// Origin as the near planes and as the far planes see it.
    near_origin: Vec3,
    far_origin: Vec3,
    inv_direction: Vec3,
    /// Which of a box's [`Planes`] the ray meets first on each axis, and which last.
    near: [usize; 3],
    far: [usize; 3],
}

/// The planes of a box: lower x, y, z, upper x, y, z.
pub(super) type Planes = [f32; 6];

/// The planes of `bounds`.
pub(super) fn planes(bounds: &Bounds) -> Planes {
    let (low, high) = (bounds.min, bounds.max);
    [low.x, low.y, low.z, high.x, high.y, high.z]
}

/// Which of a box's planes a ray meets first on each axis, and which last: by the signs of its
/// direction.
#[inline(always)]
pub(super) fn near_and_far(negative: [bool; 3]) -> ([usize; 3], [usize; 3]) {
    let plane = |high: bool, axis: usize| axis + 3 * usize::from(high);
    (axes(|axis| plane(negative[axis], axis)), axes(|axis| plane(!negative[axis], axis)))
}

/// Bound of all rounding errors between a box's entry and the distance of a primitive in
/// it, in units of roundoff × distance: 24 for the primitive's own test (sphere: origin to
/// centre 2, projection 9, root 11; triangle: shear 5, height 3; quad: 8, magnified by
/// [`Quad::condition`](crate::geometry::Quad::condition)), 6 for the slab's.
pub(super) const SLACK: f32 = 32.0 * UNIT_ROUNDOFF;

impl SlabRay {
    /// `scene` is a box around all primitives, `condition` ≥ 1 the largest of its quads'.
    #[inline]
    pub(super) fn new(ray: &Ray, scene: &Bounds, condition: f32) -> Self {
        let (o, d) = (ray.origin, ray.direction);
        let slack = SLACK * condition * scene.farthest_distance(o)
            + 4.0 * UNIT_ROUNDOFF * max_element(o.abs());
        // The sign bit, so that −0 goes with its reciprocal −∞.
        let negative = d.to_array().map(f32::is_sign_negative);
        let sign = Vec3::from_array(negative.map(|n| if n { -slack } else { slack }));
        let (near, far) = near_and_far(negative);
        Self {
            near_origin: o + sign,
            far_origin: o - sign,
            inv_direction: Vec3::new(1.0 / d.x, 1.0 / d.y, 1.0 / d.z),
            near,
            far,
        }
    }

    /// Distance at which the ray enters the box, if it does in `[t_min, t_max]`.
    ///
    /// A component 0 of the direction gives infinite distances, or NaN for an origin in the
    /// very plane, which the order of the comparisons ignores.
    #[inline]
    pub(super) fn enter(&self, planes: &Planes, t_min: f32, t_max: f32) -> Option<f32> {
        let (mut entry, mut exit) = (t_min, t_max);
        for axis in 0..3 {
            let (near, far) = (planes[self.near[axis]], planes[self.far[axis]]);
            entry = max((near - self.near_origin[axis]) * self.inv_direction[axis], entry);
            exit = min((far - self.far_origin[axis]) * self.inv_direction[axis], exit);
        }
        (entry <= exit).then_some(entry)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn enter(origin: Vec3, direction: Vec3) -> Option<f32> {
        let bounds = Bounds { min: Vec3::ONE, max: Vec3::splat(2.0) };
        let ray = Ray { origin, direction, time: 0.0 };
        let planes = [1.0, 1.0, 1.0, 2.0, 2.0, 2.0];
        SlabRay::new(&ray, &bounds, 1.0).enter(&planes, 0.0, f32::INFINITY)
    }

    /// Hits on thin quads are off by more roundings, and boxes reach as much farther.
    #[test]
    fn slack_grows_with_the_condition() {
        let bounds = Bounds { min: Vec3::ONE, max: Vec3::splat(2.0) };
        let ray = Ray { origin: Vec3::ZERO, direction: Vec3::Z, time: 0.0 };
        for condition in [1.0, 8.0, 100.0] {
            let slab = SlabRay::new(&ray, &bounds, condition);
            let want = SLACK * condition * bounds.farthest_distance(Vec3::ZERO);
            assert_eq!((slab.near_origin.z, slab.far_origin.z), (want, -want));
        }
    }

    #[test]
    fn boxes_are_entered_or_missed() {
        let entry = enter(Vec3::ZERO, Vec3::ONE).unwrap();
        assert!((entry - 1.0).abs() < 1e-4 && entry < 1.0, "{entry}: rounded downward");
        assert_eq!(enter(Vec3::splat(1.5), Vec3::X), Some(0.0), "from inside");
        assert_eq!(enter(Vec3::ZERO, Vec3::NEG_ONE), None, "behind");
        assert_eq!(enter(Vec3::ZERO, Vec3::X), None, "beside");
        assert!(enter(Vec3::new(0.0, 1.5, 1.5), Vec3::X).is_some());
        assert!(enter(Vec3::new(0.0, 1.5, 1.5), Vec3::new(1.0, -0.0, 0.0)).is_some());
        assert!(enter(Vec3::new(0.0, 1.0, 2.0), Vec3::X).is_some(), "along an edge");
        assert!(enter(Vec3::new(3.0, 1.5, 1.5), Vec3::NEG_X).is_some());
    }
}
