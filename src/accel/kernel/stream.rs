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
use super::visits::{Child, Visits};
use crate::accel::batch::HitBatch;
use crate::accel::counters::Count;
use crate::accel::leaf::{Meshes, NoMeshes};
use crate::accel::ray::group::{Group, Members};
use crate::accel::ray::one_ray::OneRay;
use crate::accel::ray::packet::VECTORS;
use crate::accel::ray::rays::Rays;
use crate::accel::tree::wide::{WideNode, WideTree};
use crate::simd::{Float, Int, LANES, Mask, axes};

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
    visits: Visits,
    pub(crate) meshes: M,
}

impl<M: Meshes> Stream<M> {
    pub(crate) fn new(tree: &WideTree, meshes: M) -> Self {
        Self { group: Group::NONE, visits: Visits::for_tree(tree), meshes }
    }

    /// Traces rays through the tree.
    #[inline(always)]
    pub(crate) fn trace<const ANY: bool>(
        &mut self,
        tree: &WideTree,
        vectors: &mut [Rays],
        count: &mut impl Count,
    ) {
        let Self { group, visits, meshes } = self;
        for vectors in vectors.chunks_mut(VECTORS) {
            let looking = group.load(vectors);
            search::<ANY, VECTORS>(tree, group, looking, visits, meshes, count);
            group.store::<ANY>(vectors);
        }
    }
}

/// Searches the tree for hits of those rays of `group` that are in the set `rays`.
#[inline(always)]
pub(super) fn search<const ANY: bool, const V: usize>(
    tree: &WideTree,
    group: &mut Group<V>,
    rays: u32,
    visits: &mut Visits,
    meshes: &mut impl Meshes,
    count: &mut impl Count,
) {
    if tree.nodes.is_empty() {
        return;
    }
    let mut looking = rays;
    visits.start(rays);
    while let Some(visit) = visits.pop() {
        let rays = if ANY { visit.rays & looking } else { visit.rays };
        match visit.child() {
            Child::Node(index) => {
                let node = &tree.nodes[index as usize];
                let (mut entering, mut nearest) = (Int::ZERO, Float::INFINITY);
                for ray in Members(rays) {
                    let (entry, entered) = boxes(node, &group.ray(ray), group.best(ray).t);
                    count.node(LANES as u32, entered.bits().count_ones());
                    entering = entering | entered.select(Int::splat(1 << ray), Int::ZERO);
                    if !ANY {
                        nearest = entered.select(nearest.min(entry), nearest);
                    }
                }
                if ANY {
                    visits.push::<false>(tree, node, entering, nearest);
                } else {
                    visits.push::<true>(tree, node, entering, nearest);
                }
            }
            Child::Block(block) => {
                let found = tree.blocks.test_group::<ANY, V>(
                    block,
                    group,
                    rays,
                    visit.distance,
                    meshes,
                    count,
                );
                looking &= !found;
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
