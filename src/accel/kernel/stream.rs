//! The kernel `stream`, in which the rays of a packet visit a node together. Each ray is tested on
//! its own, against all boxes of the node at once, and those that enter a box continue together
//! (Barringer, Akenine-Möller 2014, "Dynamic Ray Stream Traversal").
//!
//! The rays share the loads of nodes and blocks, and the tests of different rays overlap in the CPU.
//!
//! Differences from the paper:
//! 1. A stream has at most 32 rays, so a set of them is a mask in a register instead of a list in
//!    memory. Which rays enter which child is computed without a branch.
//! 2. The children are visited in the order of their least entry distances over all rays. Rays that
//!    only ask whether there is a hit take the oldest first, so that memory has the most time to deliver
//!    their data.

use super::job::TraceJob;
use super::meshes::MeshTrees;
use super::search::search;
use super::visits::Visits;
use crate::accel::ray::{RayGroup, Rays, VECTORS};
use crate::accel::tree::wide::WideTree;
use crate::accel::{Count, HitBatch, Meshes, NoMeshes};

/// Traces rays through the tree. Returns the indices of the wild rays (see
/// [`Rays::load`](crate::accel::ray::Rays::load)), which are left to the scalar reference.
#[inline(never)] // so that profilers find it
pub(crate) fn trace<const ANY: bool, C: Count>(
    tree: &WideTree,
    job: &TraceJob<'_>,
    hits: &mut HitBatch,
    count: &mut C,
) -> Vec<usize> {
    if tree.is_plain() {
        trace_with::<ANY, false, C>(tree, NoMeshes, job, hits, count)
    } else {
        trace_with::<ANY, true, C>(tree, MeshTrees::new(tree), job, hits, count)
    }
}

fn trace_with<const ANY: bool, const INSTANCES: bool, C: Count>(
    tree: &WideTree,
    meshes: impl Meshes,
    job: &TraceJob<'_>,
    hits: &mut HitBatch,
    count: &mut C,
) -> Vec<usize> {
    let mut tracer = Tracer::new(tree, meshes);
    job.trace::<ANY, INSTANCES, VECTORS, C>(hits, count, |packet, count| {
        tracer.trace::<ANY>(tree, &mut packet.vectors, count);
    })
}

/// Traces packets as streams, and lends its memory to beams.
pub(super) struct Tracer<M> {
    group: RayGroup<VECTORS>,
    pub(super) visits: Visits,
    pub(super) meshes: M,
}

impl<M: Meshes> Tracer<M> {
    pub(super) fn new(tree: &WideTree, meshes: M) -> Self {
        Self { group: RayGroup::NONE, visits: Visits::for_tree(tree), meshes }
    }

    /// Traces rays through the tree.
    #[inline(always)]
    pub(super) fn trace<const ANY: bool>(
        &mut self,
        tree: &WideTree,
        vectors: &mut [Rays],
        count: &mut impl Count,
    ) {
        let Self { group, visits, meshes } = self;
        for vectors in vectors.chunks_mut(VECTORS) {
            let looking = group.load(vectors);
            visits.start(looking);
            search::<ANY, VECTORS>(tree, group, looking, visits, meshes, count);
            group.store::<ANY>(vectors);
        }
    }

    /// Continues the search of a beam with its rays. `factor` turns the beam's distances into lower
    /// bounds of theirs.
    #[inline(always)]
    pub(super) fn finish<const ANY: bool>(
        &mut self,
        tree: &WideTree,
        vectors: &mut [Rays],
        factor: f32,
        count: &mut impl Count,
    ) {
        let Self { group, visits, meshes } = self;
        let looking = group.load(vectors);
        visits.hand_over(looking, factor);
        search::<ANY, VECTORS>(tree, group, looking, visits, meshes, count);
        group.store::<ANY>(vectors);
    }
}
