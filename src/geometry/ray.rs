//! Rays and what is computed once a ray.

use glam::Vec3;

use crate::math::{Real, dot};

/// A ray `origin + t direction` at one moment of the shutter, or one a lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray<R: Real = f32> {
    /// Where it starts.
    pub origin: R::Vec3,
    /// Where it goes; of any length, distances are in its units.
    pub direction: R::Vec3,
    /// When, as the parameter of a moving sphere.
    pub time: R,
}

impl Ray {
    /// Whether all is finite. A ray that is not hits nothing.
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.origin.is_finite() && self.direction.is_finite() && self.time.is_finite()
    }
}

/// The closest primitive along a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance in units of the direction's length.
    pub t: f32,
    /// Index of the primitive: spheres, then quads, then triangles.
    pub primitive: u32,
}

impl Hit {
    /// The index that stands for no primitive.
    pub const MISS: u32 = u32::MAX;
}

/// A ray with the values that the primitive tests share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PreparedRay {
    /// The ray itself.
    pub ray: Ray,
    /// Squared length of the direction.
    pub(super) length2: f32,
    /// Its reciprocal.
    pub(super) inv_length2: f32,
    /// Axes (x, y, z) permuted so that the direction is longest along the last.
    pub(super) axes: [usize; 3],
    /// Shear and scale that take the direction to (0, 0, 1) in those axes.
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

/// The axes in the order in which triangles are seen: the one along which a direction is longest
/// last, the first two swapped where it points down that, so that the winding of triangles is kept
/// (Woop et al. 2013).
#[inline(always)]
pub(crate) fn shear_axes(longest: usize, negative: bool) -> [usize; 3] {
    const NEXT: [usize; 3] = [1, 2, 0];
    const LAST: [usize; 3] = [2, 0, 1];
    // Known to be below 3, no axis is checked again.
    let longest = longest % 3;
    let (next, last) = (NEXT[longest], LAST[longest]);
    if negative { [last, next, longest] } else { [next, last, longest] }
}
