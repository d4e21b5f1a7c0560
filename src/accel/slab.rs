//! The slab test of a ray against a box, which stays conservative despite rounding.

use glam::Vec3;

use crate::geometry::{Bounds, Ray};
use crate::math::{UNIT_ROUNDOFF, max, max_element, min};
use crate::simd::axes;

/// A ray prepared for slab tests (report, III.F; Majercik et al. 2018).
///
/// Departures from the report's test:
/// 1. The exit distance is a minimum. The report writes `max`, with which hardly any box is missed,
///    but means `min`.
/// 2. The planes are moved outward by a slack. The rounding error of a primitive's distance grows
///    with that distance, and a box must not be skipped if a primitive in it would report a hit.
///    (Ize 2013, "Robust BVH Ray Traversal", widens the exit only.) The slack is built into two
///    origins, one for near and one for far planes.
#[derive(Clone, Copy, Debug)]
pub(super) struct SlabRay {
    /// Origin from which the distances of near planes are computed.
    near_origin: Vec3,
    /// Origin from which the distances of far planes are computed.
    far_origin: Vec3,
    inv_direction: Vec3,
    /// Index of the plane in [`Planes`] that the ray meets first on each axis.
    near: [usize; 3],
    /// Index of the plane in [`Planes`] that the ray meets last on each axis.
    far: [usize; 3],
}

/// The planes of a box: lower x, y, z, upper x, y, z.
pub(super) type Planes = [f32; 6];

/// The planes of `bounds`.
pub(super) fn planes(bounds: &Bounds) -> Planes {
    let (low, high) = (bounds.min, bounds.max);
    [low.x, low.y, low.z, high.x, high.y, high.z]
}

/// Returns the indices of the [`Planes`] that a ray meets first and last on each axis, given on
/// which axes its direction is negative.
#[inline(always)]
pub(super) fn near_and_far(negative: [bool; 3]) -> ([usize; 3], [usize; 3]) {
    let plane = |high: bool, axis: usize| axis + 3 * usize::from(high);
    (axes(|axis| plane(negative[axis], axis)), axes(|axis| plane(!negative[axis], axis)))
}

/// Bound on the sum of the rounding errors of the entry into a box and of the distance of a
/// primitive in it, relative to the distance. In units of roundoff, the primitive's own test
/// contributes at most 24 (sphere: origin to centre 2, projection 9, root 11; triangle: shear 5,
/// height 3; quad: 8, magnified by [`Quad::condition`](crate::geometry::Quad::condition)), and the
/// slab test 6.
///
/// An instance contributes 23, magnified by its condition number |L⁻¹| |L|: 4 by mapping the origin o
/// to L (o − c), 3 by mapping the direction, and 16 by the test of its triangles. Since o − c counts,
/// the box from which distances are measured must contain c.
pub(super) const SLACK: f32 = 32.0 * UNIT_ROUNDOFF;

impl SlabRay {
    /// `scene` is a bounding box of all elements and of the origins of object spaces. `condition` is
    /// that of the geometry ([`Geometry::condition`](crate::geometry::Geometry::condition)).
    #[inline]
    pub(super) fn new(ray: &Ray, scene: &Bounds, condition: f32) -> Self {
        let (o, d) = (ray.origin, ray.direction);
        let slack = SLACK * condition * scene.farthest_distance(o)
            + 4.0 * UNIT_ROUNDOFF * max_element(o.abs());
        // The sign bit makes −0 negative, like its reciprocal −∞.
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

    /// Returns the distance at which the ray enters the box, if it does so in `[t_min, t_max]`.
    ///
    /// If a component of the direction is 0, distances are infinite, or NaN for an origin in the
    /// plane. The argument order of `max` and `min` discards the NaN.
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

    /// The distances of thin quads have larger rounding errors, so boxes must grow accordingly.
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
        assert!((entry - 1.0).abs() < 1e-4 && entry < 1.0, "entry {entry} is not just below 1");
        assert_eq!(enter(Vec3::splat(1.5), Vec3::X), Some(0.0), "from inside");
        assert_eq!(enter(Vec3::ZERO, Vec3::NEG_ONE), None, "behind");
        assert_eq!(enter(Vec3::ZERO, Vec3::X), None, "beside");
        assert!(enter(Vec3::new(0.0, 1.5, 1.5), Vec3::X).is_some());
        assert!(enter(Vec3::new(0.0, 1.5, 1.5), Vec3::new(1.0, -0.0, 0.0)).is_some());
        assert!(enter(Vec3::new(0.0, 1.0, 2.0), Vec3::X).is_some(), "along an edge");
        assert!(enter(Vec3::new(3.0, 1.5, 1.5), Vec3::NEG_X).is_some());
    }
}
