//! Box tests without traversal, for benchmarks: every ray against every box.

use std::ops::Range;

use super::accelerator::Accelerator;
use super::kernel::job::TraceJob;
use super::kernel::packet;
use super::{HitBatch, RayBatch, SlabRay};

impl Accelerator {
    /// Number of boxes that each ray is tested against.
    #[doc(hidden)]
    pub fn boxes(&self) -> usize {
        2 * self.pair(1).nodes.len()
    }

    /// Counts how often rays in `range` enter a box of the packets' tree, testing whole packets.
    #[doc(hidden)]
    pub fn boxes_entered(&self, rays: &RayBatch, range: Range<usize>) -> u64 {
        let (ends, base) = ((range.start, range.end), self.base());
        let (extent, blocks) = (&base.extent, &base.spanning.0);
        let job = TraceJob { rays, ends, extent, blocks, spanning: &[], meshes: u32::MAX };
        packet::enter_all(self.pair(1), &job, &mut HitBatch::misses(rays.len()))
    }

    /// Counts the same entries ray by ray, with the reference's box test.
    #[doc(hidden)]
    pub fn boxes_entered_by_scalar(&self, rays: &RayBatch, range: Range<usize>) -> u64 {
        let bounds = self.bounds();
        let entered = |index: usize| {
            let (ray, t_min, t_max) = rays.get(index);
            let slab = SlabRay::new(&ray, &bounds, 1.0);
            let boxes = self.pair(1).nodes.iter().flat_map(|node| &node.boxes);
            boxes.filter(|planes| slab.enter(planes, t_min, t_max).is_some()).count() as u64
        };
        range.map(entered).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Geometry, Ray, Sphere};
    use crate::math::Stream;
    use glam::Vec3;

    #[test]
    fn packets_enter_the_boxes_that_single_rays_enter() {
        let mut random = Stream::new(8);
        let mut vector = |size: f32| Vec3::from_array([0; 3].map(|_| random.between(-size, size)));
        let spheres = (0..200).map(|_| Sphere::still(vector(10.0), 0.2)).collect();
        let geometry = Geometry { spheres, ..Geometry::default() };
        let mut rays = RayBatch::default();
        for _ in 0..1000 {
            let ray = Ray { origin: vector(12.0), direction: vector(1.0), time: 0.0 };
            rays.push(&ray, 0.0, f32::INFINITY);
        }
        let accelerator = Accelerator::new(geometry);
        let lanes = accelerator.boxes_entered(&rays, 0..rays.len());
        let scalar = accelerator.boxes_entered_by_scalar(&rays, 0..rays.len());
        // The two tests differ in their slack, by some millionths of the scene's size.
        assert!(scalar > 1000 && scalar.abs_diff(lanes) < 10, "{scalar} {lanes}");
    }
}
