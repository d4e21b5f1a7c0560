//! The descent of one ray: tests against all boxes of a wide node, up to the next block.

use super::frames::{Frame, Frames};
use crate::accel::counters::Count;
use crate::accel::leaf::BlockRef;
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

/// Returns the next block with a box that the ray enters at a distance of at most `limit`. Nearer
/// boxes come first. `frame` has the remaining children of the ray's current node.
#[inline(always)]
pub(super) fn next_block(
    frame: &mut Frame,
    tree: &WideTree,
    one: &OneRay<'_>,
    limit: f32,
    above: &mut Frames,
    prefetch: bool,
    count: &mut impl Count,
) -> Option<BlockRef> {
    loop {
        let child = above.next(frame, tree, limit)?;
        if child & BlockRef::LEAF != 0 {
            return Some(BlockRef::from_bits(child));
        }
        above.push(frame, tree, prefetch);
        *frame = one.enter(tree, child, limit, count);
    }
}
