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
use crate::accel::ray::group::{Group, Members};
use crate::accel::ray::one_ray::OneRay;
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
    group: Group<VECTORS>,
    open: Vec<Visit>,
    pub(crate) meshes: M,
}

impl<M: Meshes> Stream<M> {
    pub(crate) fn new(tree: &WideTree, meshes: M) -> Self {
        Self { group: Group::NONE, open: visits(tree), meshes }
    }

    /// Traces rays through the tree.
    #[inline(always)]
    pub(crate) fn trace<const ANY: bool>(
        &mut self,
        tree: &WideTree,
        vectors: &mut [Rays],
        count: &mut impl Count,
    ) {
        let Self { group, open, meshes } = self;
        for vectors in vectors.chunks_mut(VECTORS) {
            let looking = group.load(vectors);
            search::<ANY, VECTORS>(tree, group, looking, open, meshes, count);
            group.store::<ANY>(vectors);
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

/// Searches the tree for hits of those rays of `group` that are in the set `rays`.
#[inline(always)]
pub(super) fn search<const ANY: bool, const V: usize>(
    tree: &WideTree,
    group: &mut Group<V>,
    rays: u32,
    open: &mut Vec<Visit>,
    meshes: &mut impl Meshes,
    count: &mut impl Count,
) {
    if tree.nodes.is_empty() {
        return;
    }
    let mut looking = rays;
    open.clear();
    open.push(Visit { distance: 0.0, child: 0, rays });
    while let Some(Visit { distance, child, mut rays }) = open.pop() {
        if ANY {
            rays &= looking;
        }
        if child & BlockRef::LEAF != 0 {
            let block = BlockRef::from_bits(child);
            let found =
                tree.blocks.test_group::<ANY, V>(block, group, rays, distance, meshes, count);
            looking &= !found;
            continue;
        }
        let node = &tree.nodes[child as usize];
        let (mut entering, mut nearest) = (Int::ZERO, Float::INFINITY);
        for ray in Members(rays) {
            let (entry, entered) = boxes(node, &group.ray(ray), group.best(ray).t);
            count.node(LANES as u32, entered.bits().count_ones());
            entering = entering | entered.select(Int::splat(1 << ray), Int::ZERO);
            if !ANY {
                nearest = entered.select(nearest.min(entry), nearest);
            }
        }
        push::<ANY>(open, tree, node, entering, nearest);
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

/// Pushes the children that rays enter, the nearest last. Each lane of `entering` has the set of rays
/// that enter its child.
#[inline(always)]
fn push<const ANY: bool>(
    open: &mut Vec<Visit>,
    tree: &WideTree,
    node: &WideNode,
    entering: Int,
    nearest: Float,
) {
    let entered = !entering.eq(Int::ZERO).bits();
    let (rays, distance) = (entering.to_array(), nearest.to_array());
    let first = open.len();
    for lane in Bits(entered) {
        let child = node.children[lane];
        if tree.is_large {
            tree.prefetch(child);
        }
        let visit = Visit { distance: distance[lane], child, rays: rays[lane] };
        if ANY {
            // Leaves that share a block are next to each other.
            match open[first..].last_mut() {
                Some(before) if before.child == child => before.rays |= visit.rays,
                _ => open.push(visit),
            }
            continue;
        }
        let mut at = open.len();
        open.push(visit);
        while at > first && open[at - 1].distance < visit.distance {
            open[at] = open[at - 1];
            at -= 1;
        }
        open[at] = visit;
    }
}
