//! The traversal of a wide tree by a group of rays.

use super::visits::{Child, Visits};
use crate::accel::ray::{Members, OneRay, RayGroup};
use crate::accel::tree::wide::{WideNode, WideTree};
use crate::accel::{Count, Meshes};
use crate::math::{Real, Word};
use crate::simd::{Float, Int, LANES, Mask, axes};

/// Makes all `visits`, and searches there for hits of those rays of `group` that are in the set `rays`.
#[inline(always)]
pub(super) fn search<const ANY: bool, const V: usize>(
    tree: &WideTree,
    group: &mut RayGroup<V>,
    rays: u32,
    visits: &mut Visits,
    meshes: &mut impl Meshes,
    count: &mut impl Count,
) {
    if tree.nodes.is_empty() || rays == 0 {
        return;
    }
    let mut looking = rays;
    while let Some(visit) = visits.next::<ANY>() {
        let rays = if ANY { visit.rays & looking } else { visit.rays };
        match visit.child() {
            Child::Node(index) => {
                let node = &tree.nodes[index as usize];
                let mut entering = Int::ZERO;
                // Without an order, 0 is a lower bound.
                let mut nearest = if ANY { Float::ZERO } else { Float::INFINITY };
                for ray in Members(rays) {
                    let (entry, entered) = boxes(node, &group.ray(ray), group.best(ray).t);
                    count.node(LANES as u32, entered.bits().count_ones());
                    entering = entering | entered.select(Int::splat(1 << ray), Int::ZERO);
                    if !ANY {
                        nearest = entered.select(nearest.min(entry), nearest);
                    }
                }
                visits.push::<ANY>(tree, node, entering, nearest);
            }
            Child::LeafBlock(block) => {
                let least = visit.distance;
                looking &=
                    !tree.blocks.test_group::<ANY, V>(block, group, rays, least, meshes, count);
                if ANY && looking == 0 {
                    return;
                }
            }
        }
    }
}

/// Tests a ray against the boxes of a node. Returns the distances at which it enters them, and the
/// boxes that it enters at a distance of at most `limit`.
#[inline(always)]
fn boxes(node: &WideNode, one: &OneRay<'_>, limit: f32) -> (Float, Mask) {
    let table = one.table;
    let meet = |axis: usize, high: bool, offset: Float| {
        let plane = Float::new(node.planes[axis][usize::from(high)]);
        plane.free_mul_sub(one.splat(&table.inverse[axis]), offset)
    };
    let [x, y, z] = axes(|axis| meet(axis, one.is_down(axis), one.splat(&table.near_offset[axis])));
    let entry = x.max(y).max(z.max(one.splat(&table.t_min)));
    let [x, y, z] = axes(|axis| meet(axis, !one.is_down(axis), one.splat(&table.far_offset[axis])));
    let exit = x.min(y).min(z.min(Float::splat(limit)));
    (entry, entry.le(exit))
}
