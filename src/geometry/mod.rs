//! Rays, primitives, and the intersection tests that define a hit.
//!
//! The primitives' `intersect` methods define the closest hit of a ray: the one with the least
//! distance in the open interval `(t_min, t_max)` over all primitives. Ties go to the lowest index.
//! The triangles of instances come last: for them, the ray is transformed to object space, and ties
//! go to the lowest instance, then to the lowest triangle. The definition does not depend on any
//! acceleration structure.

mod bounds;
mod collection;
mod holes;
mod instance;
mod primitive;
pub(crate) mod quad;
mod ray;
mod ray_lanes;
pub(crate) mod sphere;
mod surfaces;
pub(crate) mod triangle;
mod triangles;
mod vertices;
mod volume;

pub use bounds::Bounds;
pub(crate) use collection::Primitive;
pub use collection::{Geometry, Instances};
pub use holes::{HoleTest, Holes};
pub use instance::Instance;
pub(crate) use instance::ToObject;
pub(crate) use primitive::{PrimitiveModel, Shape, match_shape, primitives, shapes};
pub use quad::Quad;
pub(crate) use ray::PreparedRay;
pub(crate) use ray::shear_axes;
pub use ray::{Hit, Ray};
pub(crate) use ray_lanes::{HitLanes, RayLanes};
pub use sphere::Sphere;
pub(crate) use sphere::distance as sphere_distance;
pub(crate) use surfaces::{Partials, Surfaces};
pub use triangle::Triangle;
pub use triangles::Triangles;
pub use vertices::Vertices;
pub(crate) use volume::Volume;

use crate::math::{Mask, Real};

/// A point of a surface that a ray has hit, or one point per lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface<R: Real = f32> {
    /// The point, computed from the primitive since that is more exact than `o + t d`.
    pub point: R::Vec3,
    /// Unit geometric normal on the primitive's front. It points outward from a sphere, along
    /// `u × v` from a quad, and to the side from which a triangle's vertices appear in
    /// counter-clockwise order.
    pub normal: R::Vec3,
    /// Distance along the normal that is certain to move the origin of a new ray off the surface.
    pub offset: R,
    /// The normal that materials use.
    pub shading: ShadingNormal<R>,
}

/// The normal with which a surface is shaded.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShadingNormal<R: Real = f32> {
    /// Unit normal. Its side has no meaning.
    pub normal: R::Vec3,
    /// Whether it may differ from the geometric normal.
    pub smooth: R::Mask,
    /// Whether shadows fade out towards the terminator. Only smooth surfaces have this.
    pub soft: R::Mask,
}

impl<R: Real> ShadingNormal<R> {
    /// The shading of a flat surface.
    #[inline(always)]
    pub(crate) fn flat(normal: R::Vec3) -> Self {
        Self { normal, smooth: R::Mask::NONE, soft: R::Mask::NONE }
    }
}

impl<R: Real> Surface<R> {
    /// A surface that is shaded with its geometric normal.
    #[inline(always)]
    pub(crate) fn flat(point: R::Vec3, normal: R::Vec3, offset: R) -> Self {
        Self { point, normal, offset, shading: ShadingNormal::flat(normal) }
    }

    /// Origin of a ray that leaves the surface toward `side`, which is `normal` or `-normal`.
    ///
    /// The offset bounds the rounding errors of the point and of the primitive's own test (Pharr et
    /// al., section 6.8), so that no ray hits the surface that it leaves.
    #[inline(always)]
    pub(crate) fn spawn(&self, side: R::Vec3) -> R::Vec3 {
        self.point + side * self.offset
    }
}
