//! The extent of a scene, and the limits within which rays are safe from overflow.

use std::ops::Range;

use glam::Vec3;

use super::slab::SLACK;
use crate::geometry::{Bounds, Geometry, Instance};
use crate::math::{Real, UNIT_ROUNDOFF, max, max_element, min};
use crate::simd::{Float, Vec3x, axes};

/// Largest coordinate of a box or an origin. Within this limit and the next two, no product of the
/// slab test overflows, or underflows in a way that matters.
const TAME_COORDINATE: f32 = 1e10;
/// Lower limit on half the sum of the edges of the boxes' bounding box.
const TAME_EDGES: f32 = 1e-20;
/// Range of the sum of the magnitudes of a direction's components.
const TAME_DIRECTION: Range<f32> = 1e-15..1e15;

/// Scene bounds and error constants that the ray setup needs.
#[derive(Clone, Debug)]
pub(super) struct Extent {
    /// Centre of the bounding box of all primitives that are in a tree.
    middle: Vec3,
    /// Half the sum of the three edges of the bounding box around `middle`.
    half_edges: f32,
    /// The largest [`Geometry::condition`].
    condition: f32,
    /// Limit on |x| + |y| + |z| of a ray's origin, up to which no product in a box or primitive
    /// test can overflow; negative if no ray is safe.
    pub(super) tame_reach: f32,
    /// Range of the sum of the magnitudes of a direction's components in which no product can
    /// overflow.
    pub(super) tame_speed: Range<f32>,
    /// Whether the scene has boxes to test.
    pub(super) boxes: bool,
    /// Whether the scene has triangles to test.
    pub(super) triangles: bool,
}

impl Extent {
    /// Computes the extent of a scene. `all` bounds all primitives, `bounds` only those in a tree.
    pub(super) fn new(geometry: &Geometry, all: Bounds, bounds: Bounds) -> Self {
        let condition = geometry.condition();
        let triangles = !geometry.triangles.is_empty();
        let boxes = bounds != Bounds::EMPTY;
        // Without boxes, no box test can overflow.
        let bounds = if boxes { bounds } else { Bounds { min: Vec3::ZERO, max: Vec3::ZERO } };
        // See `SLACK`.
        let bounds = bounds.union(geometry.instances.centers());
        let middle = 0.5 * (bounds.min + bounds.max);
        let half_edges = (bounds.max - middle).max(middle - bounds.min).element_sum();
        let is_tame = all == Bounds::EMPTY
            || max_element(all.min.abs()) <= TAME_COORDINATE
                && max_element(all.max.abs()) <= TAME_COORDINATE
                && (!boxes || half_edges >= TAME_EDGES);
        let tame_reach = if is_tame { TAME_COORDINATE } else { -1.0 };
        let tame_speed = TAME_DIRECTION;
        let mut extent =
            Self { middle, half_edges, condition, tame_reach, tame_speed, boxes, triangles };
        geometry.instances.list().iter().for_each(|instance| extent.include(geometry, instance));
        extent
    }

    /// Narrows the limits so that rays within them also stay within the usual limits in the object
    /// space of `instance`.
    fn include(&mut self, geometry: &Geometry, instance: &Instance) {
        let [to_object, to_world] = instance.scales();
        let center = instance.world_to_object().center.abs().element_sum();
        let mesh = geometry.instances.mesh_bounds(instance.mesh());
        let is_tame = (mesh.max - mesh.min).element_sum() >= 2.0 * TAME_EDGES
            && max_element(mesh.min.abs()) <= TAME_COORDINATE
            && max_element(mesh.max.abs()) <= TAME_COORDINATE;
        let reach = if is_tame { TAME_COORDINATE / to_object - center } else { -1.0 };
        self.tame_reach = min(self.tame_reach, reach);
        let Range { start, end } = self.tame_speed;
        self.tame_speed =
            max(start, TAME_DIRECTION.start * to_world)..min(end, TAME_DIRECTION.end / to_object);
    }

    #[inline(always)]
    pub(super) fn lanes(&self) -> ExtentLanes {
        ExtentLanes {
            middle: Vec3x(axes(|axis| Float::splat(self.middle[axis]))),
            half_edges: Float::splat(self.half_edges),
            condition: Float::splat(self.condition),
        }
    }

    /// Returns a slack that suffices for all rays whose distance from the boxes' bounding box is at
    /// most `reach` times the sum of that box's edges.
    pub(super) fn slack_within(&self, reach: f32) -> f32 {
        let edges = 2.0 * self.half_edges;
        let coordinates = self.middle.abs().element_sum() + self.half_edges;
        (1.0 + 3.0 * reach) * edges * (SLACK * self.condition)
            + (coordinates + 3.0 * reach * edges) * (4.0 * UNIT_ROUNDOFF)
    }
}

/// The values of an [`Extent`] that set the slack, one per lane.
pub(super) struct ExtentLanes {
    pub(super) middle: Vec3x,
    pub(super) half_edges: Float,
    pub(super) condition: Float,
}
