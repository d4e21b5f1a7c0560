//! The kernel `stream`, in which the rays of a packet visit a node together. Each ray is tested on its
//! own, against all boxes of the node at once, and those that enter a box continue together.
//! (Barringer, Akenine-Möller 2014, "Dynamic Ray Stream Traversal".)
//!
//! The rays share the loads of nodes and blocks, and the tests of different rays overlap in the CPU.
//!
//! Differences from the paper:
//! 1. A stream has at most 32 rays, so a set of them is a mask in a register instead of a list in
//!    memory. Which rays enter which child is computed without a branch.
//! 2. The children are visited in the order of their least entry distances over all rays. Rays that
//!    only ask whether there is a hit take them in any order.

use super::job::Job;
use super::meshes::MeshTrees;
use crate::accel::batch::HitBatch;
use crate::accel::counters::Count;
use crate::accel::leaf::{BlockRef, Meshes, NoMeshes};
use crate::accel::ray::best::BestLanes;
use crate::accel::ray::one_ray::{OneRay, Table};
use crate::accel::ray::packet::VECTORS;
use crate::accel::ray::rays::Rays;
use crate::accel::tree::wide::{WideNode, WideTree};
use crate::simd::{Bits, Float, Int, LANES, Mask, axes};

/// Traces rays through the tree. Returns the indices of the wild rays (see
/// [`Rays::load`](crate::accel::ray::rays::Rays::load)), which are left to the scalar reference.
#[inline(never)] // so that profilers find it
pub(crate) fn trace<const ANY: bool, C: Count>(
    tree: &WideTree,
    job: &Job<'_>,
    hits: &mut HitBatch,
    count: &mut C,
) -> Vec<usize> {
    if tree.meshes.is_empty() {
        trace_with::<ANY, false, C>(tree, NoMeshes, job, hits, count)
    } else {
        trace_with::<ANY, true, C>(tree, MeshTrees::new(tree), job, hits, count)
    }
}

fn trace_with<const ANY: bool, const INSTANCES: bool, C: Count>(
    tree: &WideTree,
    meshes: impl Meshes,
    job: &Job<'_>,
    hits: &mut HitBatch,
    count: &mut C,
) -> Vec<usize> {
    let mut stream = Stream::new(tree, meshes);
    job.trace::<ANY, INSTANCES, VECTORS, C>(hits, count, |packet, count| {
        stream.trace::<ANY>(tree, &mut packet.vectors, count);
    })
}

/// Rays that are traced together, and room for their traversal.
pub(crate) struct Stream<M> {
    tables: [Table; VECTORS],
    best: [BestLanes; VECTORS],
    open: Vec<Visit>,
    pub(crate) meshes: M,
}

impl<M: Meshes> Stream<M> {
    pub(crate) fn new(tree: &WideTree, meshes: M) -> Self {
        let (tables, best) = ([Table::NONE; VECTORS], [BestLanes::NONE; VECTORS]);
        Self { tables, best, open: visits(tree), meshes }
    }

    /// Traces rays through the tree.
    #[inline(always)]
    pub(crate) fn trace<const ANY: bool>(
        &mut self,
        tree: &WideTree,
        vectors: &mut [Rays],
        count: &mut impl Count,
    ) {
        let Self { tables, best, open, meshes } = self;
        for vectors in vectors.chunks_mut(VECTORS) {
            let mut looking = 0;
            for (vector, rays) in vectors.iter().enumerate() {
                tables[vector].set(&rays.setup);
                best[vector] = rays.best();
                looking |= rays.looking() << (vector * LANES);
            }
            search::<ANY, VECTORS>(tree, tables, best, looking, open, meshes, count);
            for (rays, best) in vectors.iter_mut().zip(&*best) {
                rays.set_best::<ANY>(best);
            }
        }
    }
}

/// A node or a block that rays are still to visit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Visit {
    /// The least distance at which one of the rays enters its box. 0 if the order does not matter.
    distance: f32,
    /// Index of a node, or bits of a [`BlockRef`].
    child: u32,
    /// Bits of the rays.
    rays: u32,
}

/// Room for the visits that are left at any time during the traversal of `tree`.
pub(super) fn visits(tree: &WideTree) -> Vec<Visit> {
    Vec::with_capacity(1 + tree.depth * LANES)
}

/// Searches the tree for hits of `rays`, whose numbers count through the lanes of all vectors.
#[inline(always)]
pub(super) fn search<const ANY: bool, const V: usize>(
    tree: &WideTree,
    tables: &[Table; V],
    best: &mut [BestLanes; V],
    mut rays: u32,
    open: &mut Vec<Visit>,
    meshes: &mut impl Meshes,
    count: &mut impl Count,
) {
    if tree.nodes.is_empty() {
        return;
    }
    open.clear();
    open.push(Visit { distance: 0.0, child: 0, rays });
    while let Some(visit) = open.pop() {
        if visit.child & BlockRef::LEAF == 0 {
            let node = &tree.nodes[visit.child as usize];
            let looking = if ANY { visit.rays & rays } else { visit.rays };
            let (mut entering, mut nearest) = (Int::ZERO, Float::INFINITY);
            for (vector, lane) in Members::<V>(looking) {
                let one = OneRay::new(&tables[vector], lane);
                let (entry, entered) = boxes(node, &one, best[vector].t[lane]);
                count.node(LANES as u32, entered.bits().count_ones());
                let bit = Int::splat(1 << (vector * LANES + lane));
                entering = entering | entered.select(bit, Int::ZERO);
                if !ANY {
                    nearest = entered.select(nearest.min(entry), nearest);
                }
            }
            if ANY {
                push(open, node, entering);
            } else {
                push_in_order(open, node, entering, nearest);
            }
        } else {
            let block = BlockRef::from_bits(visit.child);
            let looking = if ANY { visit.rays & rays } else { visit.rays };
            for (vector, lane) in Members::<V>(looking) {
                let mut closest = best[vector].lane(lane);
                if !ANY && visit.distance > closest.t {
                    continue;
                }
                let one = OneRay::new(&tables[vector], lane);
                tree.blocks.test_one::<ANY>(block, &one, &mut closest, meshes, count);
                best[vector].set(lane, closest);
                if ANY && closest.found() {
                    rays &= !(1 << (vector * LANES + lane));
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
    let [x, y, z] =
        axes(|axis| meet(axis, one.is_down(axis), one.splat(&table.near_offset[axis])));
    let entry = x.max(y).max(z.max(one.splat(&table.t_min)));
    let [x, y, z] =
        axes(|axis| meet(axis, !one.is_down(axis), one.splat(&table.far_offset[axis])));
    let exit = x.min(y).min(z.min(Float::splat(limit)));
    (entry, entry.le(exit))
}

/// Pushes the children that rays enter. Each lane of `entering` has the rays that enter its child.
/// Leaves that share a block are next to each other, and their block is visited once.
#[inline(always)]
fn push(open: &mut Vec<Visit>, node: &WideNode, entering: Int) {
    let entered = !entering.eq(Int::ZERO).bits();
    let rays = entering.to_array();
    let mut last = 0;
    for lane in Bits(entered) {
        let visit = Visit { distance: 0.0, child: node.children[lane], rays: rays[lane] };
        match open.last_mut() {
            Some(before) if visit.child == last => before.rays |= visit.rays,
            _ => open.push(visit),
        }
        last = visit.child;
    }
}

/// Pushes the children that rays enter, so that the nearest is visited next.
#[inline(always)]
fn push_in_order(open: &mut Vec<Visit>, node: &WideNode, entering: Int, nearest: Float) {
    let entered = !entering.eq(Int::ZERO).bits();
    let (rays, distance) = (entering.to_array(), nearest.to_array());
    let first = open.len();
    for lane in Bits(entered) {
        let visit =
            Visit { distance: distance[lane], child: node.children[lane], rays: rays[lane] };
        let mut at = open.len();
        open.push(visit);
        while at > first && open[at - 1].distance < visit.distance {
            open[at] = open[at - 1];
            at -= 1;
        }
        open[at] = visit;
    }
}

/// Iterator over the vectors and lanes of a set of rays in `V` vectors.
struct Members<const V: usize>(u32);

impl<const V: usize> Iterator for Members<V> {
    type Item = (usize, usize);

    #[inline(always)]
    fn next(&mut self) -> Option<(usize, usize)> {
        if self.0 == 0 {
            return None;
        }
        let ray = self.0.trailing_zeros() as usize;
        self.0 &= self.0 - 1;
        // The remainder shows the compiler that the vector is in range.
        Some((ray / LANES % V, ray % LANES))
    }
}
