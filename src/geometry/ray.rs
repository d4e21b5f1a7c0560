//! Rays, and the values that are computed once per ray.

use glam::Vec3;

use crate::math::{Real, dot};

/// A ray `origin + t direction` at one moment of the shutter, or one ray per lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray<R: Real = f32> {
    /// Starting point.
    pub origin: R::Vec3,
    /// Direction of any length. Distances along the ray are in units of this length.
    pub direction: R::Vec3,
    /// Moment of the shutter, which determines the position of moving spheres.
    pub time: R,
}

impl Ray {
    /// Whether all values are finite. Non-finite rays hit nothing.
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.origin.is_finite() && self.direction.is_finite() && self.time.is_finite()
    }
}

/// The closest hit of a ray, or one hit per lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit<R: Real = f32> {
    /// Distance along the ray in units of the direction's length.
    pub t: R,
    /// Number of the primitive. Spheres come first, then quads, then triangles, then the triangles
    /// of the meshes that instances place.
    pub primitive: R::Word,
    /// Index of the instance to which the triangle of a mesh belongs; 0 for other primitives.
    pub instance: R::Word,
}

impl Hit {
    /// The number that marks a miss.
    pub const MISS: u32 = u32::MAX;

    /// The hit of a primitive that is not part of an instance.
    pub fn of(primitive: u32, t: f32) -> Self {
        Self { t, primitive, instance: 0 }
    }
}

/// A ray with precomputed values that the primitive tests share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PreparedRay {
    /// The ray itself.
    pub ray: Ray,
    /// Squared length of the direction.
    pub(super) length2: f32,
    /// Reciprocal of `length2`.
    pub(super) inv_length2: f32,
    /// The axes in the order of [`shear_axes`]: the direction is longest along the last one.
    pub(super) axes: [usize; 3],
    /// Shear and scale that map the direction to (0, 0, 1) in the order of `axes`.
    pub(super) shear: Vec3,
}

impl PreparedRay {
    /// Prepares `ray` for any number of primitive tests.
    pub(crate) fn new(ray: &Ray) -> Self {
        let d = ray.direction;
        let length2 = dot(d, d);
        let (ax, ay, az) = (d.x.abs(), d.y.abs(), d.z.abs());
        let longest = if ax > ay {
            if ax > az { 0 } else { 2 }
        } else if ay > az {
            1
        } else {
            2
        };
        let axes @ [first, second, longest] = shear_axes(longest, d[longest] < 0.0);
        let inv = 1.0 / d[longest];
        Self {
            ray: *ray,
            length2,
            inv_length2: 1.0 / length2,
            axes,
            shear: Vec3::new(d[first] * inv, d[second] * inv, inv),
        }
    }
}

/// The order of the axes in triangle tests. The axis along which the direction is longest comes
/// last. The other two are swapped if the direction is negative along it, to preserve the winding
/// of triangles (Woop et al. 2013).
#[inline(always)]
pub(crate) fn shear_axes(longest: usize, negative: bool) -> [usize; 3] {
    const NEXT: [usize; 3] = [1, 2, 0];
    const LAST: [usize; 3] = [2, 0, 1];
    // This does not change the value, but removes the bounds checks below.
    let longest = longest % 3;
    let (next, last) = (NEXT[longest], LAST[longest]);
    if negative { [last, next, longest] } else { [next, last, longest] }
}
