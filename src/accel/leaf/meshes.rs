//! What leaf blocks need of the scene outside their layout: meshes of instances, and holes.

use crate::accel::Count;
use crate::accel::ray::RayGroup;
use crate::geometry::Ray;

/// The meshes that instances place, and the holes of triangles.
pub(in crate::accel) trait Meshes {
    /// Whether there can be instances. Kernels are compiled for both cases, because a call that
    /// gets a reference to a packet keeps all of it in memory.
    fn some(&self) -> bool;

    /// The number of the first triangle of a mesh among all primitives.
    fn first(&self) -> u32;

    /// Whether triangles may have holes.
    #[inline(always)]
    fn may_have_holes(&self) -> bool {
        false
    }

    /// Whether a hit of triangle `primitive` at distance `t` along `ray` is in a hole, and does not count.
    #[inline(always)]
    fn is_hole(&self, _primitive: u32, _ray: impl FnOnce() -> Ray, _t: f32) -> bool {
        false
    }

    /// Traces one of the rays of `group`, which are in the object spaces of instances, through the mesh
    /// and the instance of `place`. Primitives are counted from the first triangle of all meshes.
    fn trace<const ANY: bool>(
        &mut self,
        place: (u32, u32),
        group: &mut RayGroup<1>,
        ray: usize,
        count: &mut impl Count,
    );
}

/// The meshes of a layout without instances and holes.
pub(in crate::accel) struct NoMeshes;

impl Meshes for NoMeshes {
    fn some(&self) -> bool {
        false
    }

    fn first(&self) -> u32 {
        unreachable!("this layout has no instances")
    }

    fn trace<const ANY: bool>(
        &mut self,
        _: (u32, u32),
        _: &mut RayGroup<1>,
        _: usize,
        _: &mut impl Count,
    ) {
        unreachable!("this layout has no instances")
    }
}
