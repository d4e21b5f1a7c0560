//! Rays, primitives and their contract intersections.
//!
//! A primitive's `intersect` is the definition of a hit: over all primitives the closest
//! hit has the least distance in the open interval, ties go to the lowest index. No
//! acceleration structure enters the definition.

mod bounds;
mod primitive;
pub(crate) mod quad;
mod ray;
pub(crate) mod ray_lanes;
pub(crate) mod sphere;
mod surfaces;
pub(crate) mod triangle;
mod volume;

pub use bounds::Bounds;
pub use primitive::*;
pub(crate) use ray::PreparedRay;
pub(crate) use ray::shear_axes;
pub use ray::{Hit, Ray};
pub(crate) use sphere::distance as sphere_distance;
pub(crate) use surfaces::Surfaces;
pub(crate) use volume::Volume;

use crate::math::Real;

/// A point of a surface, as found by a ray, or one a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface<R: Real = f32> {
    /// The point, moved onto the primitive where that is more exact than `o + t d`.
    pub point: R::Vec3,
    /// Unit geometric normal on the primitive's front: outward of a sphere, `u × v` of a
    /// quad, counter-clockwise of a triangle.
    pub normal: R::Vec3,
    /// How far along the normal a ray must start to be surely off the surface.
    pub offset: R,
}

impl<R: Real> Surface<R> {
    /// Origin of a ray that leaves on the side of `side`, ±`normal`.
    ///
    /// The distance bounds the rounding errors of the point and of the primitive's own
    /// test (Pharr et al., section 6.8), so that no ray meets the surface that it leaves.
    #[inline(always)]
    pub(crate) fn spawn(&self, side: R::Vec3) -> R::Vec3 {
        self.point + side * self.offset
    }
}
