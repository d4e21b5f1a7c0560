//! The kernel `packet`, which tests packets against one box of a pair node at a time.

use std::cell::Cell;

use super::job::TraceJob;
use super::octants::Octants;
use crate::accel::ray::{Packet, Rays, VECTORS};
use crate::accel::slab::near_and_far;
use crate::accel::tree::pair::PairTree;
use crate::accel::{Count, HitBatch, NoMeshes, SlabLanes};
use crate::math::Real;
use crate::simd::{Float, LANES};

/// The box test for packets whose rays agree in the signs of their directions.
const ALIKE: u8 = 0;
/// The box test for packets whose rays differ in the signs of their directions.
const MIXED: u8 = 1;
/// The box test for packets in which a ray begins so far away that it needs more slack than the
/// boxes contain.
const FAR: u8 = 2;

/// For [`FAR`] packets, the results of [`Setup::offsets`](crate::accel::setup::Setup::offsets).
type Offsets<const V: usize> = [[Float; 6]; V];

/// For [`ALIKE`] packets, the indices of the planes that the rays meet first and last on each axis.
type NearAndFar = ([usize; 3], [usize; 3]);

impl Rays {
    /// Returns the distances at which the rays enter a box, +∞ for rays that do not enter it up to
    /// their closest hit, and whether any ray enters it.
    #[inline(always)]
    fn enter<const WAY: u8>(
        &self,
        sides: &[f32; 6],
        planes: &NearAndFar,
        offsets: &[Float; 6],
    ) -> (Float, bool) {
        let SlabLanes { inverse, steepness, offset, .. } = &self.setup.slab;
        let (first, last) = planes;
        let (mut near, mut far) = ([Float::ZERO; 3], [Float::ZERO; 3]);
        for axis in 0..3 {
            let side = |i: usize| Float::splat(sides[i % 6]);
            (near[axis], far[axis]) = match WAY {
                ALIKE => {
                    let meet = |plane: usize| side(plane).free_mul_sub(inverse[axis], offset[axis]);
                    (meet(first[axis]), meet(last[axis]))
                }
                MIXED => {
                    let middle = side(axis).free_mul_sub(inverse[axis], offset[axis]);
                    let (half, steepness) = (side(axis + 3), steepness[axis]);
                    (half.free_mul_add(-steepness, middle), half.free_mul_add(steepness, middle))
                }
                FAR => {
                    let meet = |i: usize| side(i).free_mul_sub(inverse[axis], offsets[i]);
                    let (low, high) = (meet(axis), meet(axis + 3));
                    (low.min(high), low.max(high))
                }
                _ => unreachable!("WAY is ALIKE, MIXED or FAR"),
            };
        }
        let entry = near[0].max(near[1]).max(near[2].max(self.setup.ray.t_min));
        let exit = far[0].min(far[1]).min(far[2].min(self.t));
        let entered = entry.le(exit);
        (entered.select(entry, Float::INFINITY), entered.any())
    }
}

impl<const V: usize> Packet<V> {
    #[inline(always)]
    fn enter<const WAY: u8>(
        &self,
        sides: &[f32; 6],
        planes: &NearAndFar,
        offsets: &Offsets<V>,
    ) -> ([Float; V], bool) {
        let (mut entries, mut some) = ([Float::ZERO; V], false);
        for ((rays, entry), offsets) in self.vectors.iter().zip(&mut entries).zip(offsets) {
            let any;
            (*entry, any) = rays.enter::<WAY>(sides, planes, offsets);
            some |= any;
        }
        (entries, some)
    }

    /// Whether some active ray needs more slack than the boxes contain.
    #[inline(always)]
    fn is_far(&self, slack: f32) -> bool {
        let more = |rays: &Rays| rays.setup.slab.slack.gt(Float::splat(slack)).bits();
        self.vectors.iter().any(|rays| more(rays) & rays.setup.active != 0)
    }

    /// Visits the leaves in boxes that any ray enters, nearer boxes first.
    #[inline(always)]
    fn traverse<const ANY: bool, const WAY: u8>(
        &mut self,
        tree: &PairTree,
        root: u32,
        octants: &Octants,
        offsets: &Offsets<V>,
        stack: &mut [(u32, [Float; V])],
        count: &mut impl Count,
    ) {
        let planes = near_and_far(octants.negative);
        let (mut top, mut next) = (0, root);
        loop {
            if let Some(block) = PairTree::block(next) {
                // Shadow rays, and rays with similar directions, often all miss a primitive.
                if ANY || WAY == ALIKE {
                    tree.blocks.test_packet::<V, ANY, true, false>(
                        block,
                        block.valid(),
                        self,
                        &mut NoMeshes,
                        count,
                    );
                } else {
                    tree.blocks.test_packet::<V, ANY, false, false>(
                        block,
                        block.valid(),
                        self,
                        &mut NoMeshes,
                        count,
                    );
                }
            } else {
                let nodes = if WAY == MIXED { &tree.middles } else { &tree.nodes };
                let node = &nodes[next as usize];
                let (left, enter_left) = self.enter::<WAY>(&node.boxes[0], &planes, offsets);
                let (right, enter_right) = self.enter::<WAY>(&node.boxes[1], &planes, offsets);
                let entered = |entries: [Float; V]| {
                    let lanes = |entry: Float| entry.lt(Float::INFINITY).bits().count_ones();
                    entries.iter().map(|entry| lanes(*entry)).sum::<u32>()
                };
                count.node(2 * (V * LANES) as u32, entered(left) + entered(right));
                match (enter_left, enter_right) {
                    (true, true) => {
                        // A vote on the distances is up to 2% faster than using the direction
                        // sign that most rays have.
                        let right_first = if WAY == MIXED {
                            vote(&left, &right) < 0
                        } else {
                            octants.negative[node.axis as usize % 3]
                        };
                        let first = usize::from(right_first);
                        let far = if right_first { left } else { right };
                        stack[top] = (node.children[1 - first], far);
                        top += 1;
                        next = node.children[first];
                        continue;
                    }
                    (true, false) => {
                        next = node.children[0];
                        continue;
                    }
                    (false, true) => {
                        next = node.children[1];
                        continue;
                    }
                    (false, false) => {}
                }
            }
            loop {
                if top == 0 {
                    return;
                }
                top -= 1;
                let (reference, entries) = &stack[top];
                // A node is pruned only if every ray's entry is strictly beyond its closest hit.
                let ahead = |v: usize| entries[v].le(self.vectors[v].t).bits();
                if (0..V).fold(0, |bits, v| bits | ahead(v)) != 0 {
                    next = *reference;
                    break;
                }
            }
        }
    }
}

/// Returns the number of rays that enter the left child first minus the number that enter the right
/// child first.
#[inline(always)]
fn vote<const V: usize>(left: &[Float; V], right: &[Float; V]) -> i32 {
    let before = |a: Float, b: Float| a.lt(b).bits().count_ones() as i32;
    (0..V).map(|v| before(left[v], right[v]) - before(right[v], left[v])).sum()
}

/// Nodes that are still to be visited, and the distances at which the rays of a packet enter them.
type Stack = Vec<(u32, [Float; VECTORS])>;

/// Traces packets through the tree. Returns the indices of the wild rays (see `Setup::load`), which
/// are left to the scalar reference.
#[inline(never)] // so that profilers find it
pub(crate) fn trace<const ANY: bool, C: Count>(
    tree: &PairTree,
    job: &TraceJob<'_>,
    hits: &mut HitBatch,
    count: &mut C,
) -> Vec<usize> {
    // The stack is kept from call to call, since some calls trace only a few rays.
    let mut stack = STACK.take();
    stack.resize(tree.stack.max(stack.len()), (0, [Float::ZERO; VECTORS]));
    let search = |packet: &mut Packet<VECTORS>, count: &mut C| {
        let Some(root) = tree.root else { return };
        let octants = Octants::new(packet);
        let none = const { &[[Float::ZERO; 6]; VECTORS] };
        if packet.is_far(tree.slack) {
            let mut offsets = *none;
            for (offsets, rays) in offsets.iter_mut().zip(&packet.vectors) {
                *offsets = rays.setup.offsets();
            }
            packet.traverse::<ANY, FAR>(tree, root, &octants, &offsets, &mut stack, count);
        } else if octants.mixed {
            packet.traverse::<ANY, MIXED>(tree, root, &octants, none, &mut stack, count);
        } else {
            packet.traverse::<ANY, ALIKE>(tree, root, &octants, none, &mut stack, count);
        }
    };
    let left = job.trace::<ANY, false, VECTORS, C>(hits, count, search);
    STACK.set(stack);
    left
}

/// Tests all rays against the boxes of all nodes, and returns how often a ray enters a box.
pub(crate) fn enter_all(tree: &PairTree, job: &TraceJob<'_>, hits: &mut HitBatch) -> u64 {
    let mut entered = 0;
    let none = const { &[[Float::ZERO; 6]; VECTORS] };
    job.trace::<false, false, VECTORS, ()>(hits, &mut (), |packet, ()| {
        for sides in tree.middles.iter().flat_map(|node| &node.boxes) {
            let (entries, _) = packet.enter::<MIXED>(sides, &([0; 3], [0; 3]), none);
            for (entry, rays) in entries.iter().zip(&packet.vectors) {
                let bits = entry.lt(Float::INFINITY).bits() & rays.setup.active;
                entered += u64::from(bits.count_ones());
            }
        }
    });
    entered
}

thread_local! {
    static STACK: Cell<Stack> = const { Cell::new(Vec::new()) };
}
