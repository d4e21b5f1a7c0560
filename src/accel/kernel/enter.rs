//! The test of one ray against all boxes of a wide node.

use super::frames::Frame;
use crate::accel::counters::Count;
use crate::accel::ray::one_ray::OneRay;
use crate::accel::tree::wide::WideTree;
use crate::simd::{Float, LANES, Lanes, axes};

impl OneRay<'_> {
    /// Returns those children of a node that the ray enters at a distance of at most `limit`.
    #[inline(always)]
    pub(crate) fn enter(
        &self,
        tree: &WideTree,
        index: u32,
        limit: f32,
        count: &mut impl Count,
    ) -> Frame {
        let (table, node) = (self.table, &tree.nodes[index as usize]);
        let meet = |planes: [usize; 3], offset: &[Lanes; 3]| {
            axes(|axis| {
                let plane = Float::new(node.planes[planes[axis]]);
                plane.free_mul_sub(self.splat(&table.inverse[axis]), self.splat(&offset[axis]))
            })
        };
        let [x, y, z] = meet(self.near, &table.near_offset);
        let entry = x.max(y).max(z.max(self.splat(&table.t_min)));
        let [x, y, z] = meet(self.far, &table.far_offset);
        let exit = x.min(y).min(z.min(Float::splat(limit)));
        let entered = entry.le(exit);
        count.node(LANES as u32, entered.bits().count_ones());
        Frame::new(index, entry, entered)
    }
}
