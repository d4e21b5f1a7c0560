//! The kernel `single`, which traces each ray through a wide tree on its own. The rays of a vector
//! descend the first levels together and then continue one by one, or they take turns from the root
//! on.

use super::descent::Descent;
use super::enter::next_block;
use super::frames::{Frame, Frames};
use super::job::Job;
use super::meshes::MeshTrees;
use crate::accel::batch::HitBatch;
use crate::accel::counters::Count;
use crate::accel::leaf::{BlockRef, Meshes, NoMeshes};
use crate::accel::ray::best::BestLanes;
use crate::accel::ray::one_ray::{OneRay, Table};
use crate::accel::ray::packet::Packet;
use crate::accel::tree::wide::WideTree;
use crate::simd::{Bits, LANES};

/// Traces rays through the tree, one by one or taking turns. Returns the indices of the wild rays
/// (see [`Rays::load`](crate::accel::ray::rays::Rays::load)), which are left to the scalar
/// reference.
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
    let mut above = Above::new(tree, meshes);
    job.trace::<ANY, INSTANCES, 1, C>(hits, count, |packet, count| {
        trace_each::<ANY, 1>(tree, packet, &mut above, count);
    })
}

/// The state of the traversal of single rays.
pub(crate) struct Above<M> {
    /// Stacks of frames: one for each ray of a vector if rays take turns, else a single one.
    stacks: Vec<Frames>,
    meshes: M,
}

impl<M> Above<M> {
    pub(crate) fn new(tree: &WideTree, meshes: M) -> Self {
        let stacks = vec![Frames::with_depth(tree.depth); if tree.in_turn { LANES } else { 1 }];
        Self { stacks, meshes }
    }

    /// Returns the stack for a ray or a beam that is traced alone, and the meshes.
    pub(crate) fn first(&mut self) -> (&mut Frames, &mut M) {
        (&mut self.stacks[0], &mut self.meshes)
    }
}

/// Traces the rays of `packet` through the tree.
#[inline(always)]
pub(crate) fn trace_each<const ANY: bool, const V: usize>(
    tree: &WideTree,
    packet: &mut Packet<V>,
    above: &mut Above<impl Meshes>,
    count: &mut impl Count,
) {
    if tree.nodes.is_empty() {
        return;
    }
    for rays in &mut packet.vectors {
        let mut best = rays.best();
        above.meshes.load(rays);
        let table = Table::new(&rays.setup);
        let lanes = Bits(rays.looking());
        if tree.in_turn {
            trace_in_turn::<ANY>(tree, &table, lanes, &mut best, above, count);
        } else {
            trace_one_by_one::<ANY>(tree, &table, lanes, &mut best, above, count);
        }
        rays.set_best::<ANY>(&best);
        above.meshes.store(rays);
    }
}

#[inline(always)]
fn trace_one_by_one<const ANY: bool>(
    tree: &WideTree,
    table: &Table,
    lanes: Bits,
    best: &mut BestLanes,
    above: &mut Above<impl Meshes>,
    count: &mut impl Count,
) {
    let (above, meshes) = above.first();
    let mut descent = Descent::NONE;
    descent.descend(tree, table, lanes, &best.t, count);
    for lane in lanes {
        let one = OneRay::new(table, lane);
        let mut closest = best.lane(lane);
        let mut frame = descent.resume(tree, lane, above);
        while let Some(block) =
            next_block(&mut frame, tree, &one, closest.t, above, tree.is_large, count)
        {
            tree.blocks.test_one::<ANY>(block, &one, &mut closest, meshes, count);
            if ANY && closest.found() {
                break;
            }
        }
        best.set(lane, closest);
    }
}

/// Traces rays that take turns: while one waits for a block from slow memory, the others continue
/// (Kocberber, Falsafi, Grot 2015, "Asynchronous Memory Access Chaining").
///
/// Departure from the paper: rays wait only for blocks. Waiting for nodes as well gains nothing
/// (`profiling/`).
#[inline(always)]
fn trace_in_turn<const ANY: bool>(
    tree: &WideTree,
    table: &Table,
    lanes: Bits,
    best: &mut BestLanes,
    above: &mut Above<impl Meshes>,
    count: &mut impl Count,
) {
    let Above { stacks, meshes } = above;
    let mut waiting = [Waiting::NONE; LANES];
    let mut rays = 0;
    for lane in lanes {
        let one = OneRay::new(table, lane);
        let (t, above) = (best.t[lane], &mut stacks[lane]);
        above.clear();
        let mut frame = one.enter(tree, 0, t, count);
        if let Some(block) = next_block(&mut frame, tree, &one, t, above, false, count) {
            tree.blocks.prefetch(block);
            waiting[rays] = Waiting { lane, frame, block };
            rays += 1;
        }
    }
    while rays > 0 {
        let mut left = 0;
        for i in 0..rays {
            let Waiting { lane, mut frame, block } = waiting[i];
            let one = OneRay::new(table, lane);
            let (mut closest, above) = (best.lane(lane), &mut stacks[lane]);
            tree.blocks.test_one::<ANY>(block, &one, &mut closest, meshes, count);
            best.set(lane, closest);
            if ANY && closest.found() {
                continue;
            }
            let t = closest.t;
            if let Some(block) = next_block(&mut frame, tree, &one, t, above, false, count) {
                tree.blocks.prefetch(block);
                waiting[left] = Waiting { lane, frame, block };
                left += 1;
            }
        }
        rays = left;
    }
}

/// A ray that waits for a block.
#[derive(Clone, Copy)]
struct Waiting {
    lane: usize,
    /// The remaining children of the ray's current node.
    frame: Frame,
    block: BlockRef,
}

impl Waiting {
    const NONE: Self = Self { lane: 0, frame: Frame::NONE, block: BlockRef::NONE };
}
