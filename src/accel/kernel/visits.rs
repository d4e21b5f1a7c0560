//! The nodes and blocks that rays are still to visit.

use crate::accel::LeafRef;
use crate::accel::tree::wide::{WideNode, WideTree};
use crate::math::Word;
use crate::math::min;
use crate::simd::{Bits, Float, Int, LANES};

/// A node or a block that rays are still to visit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Visit {
    /// A lower bound of the distances at which the rays enter its box.
    pub(super) distance: f32,
    child: u32,
    /// The set of rays.
    pub(super) rays: u32,
}

/// The target of a visit.
pub(super) enum Child {
    /// The index of a node.
    Node(u32),
    LeafBlock(LeafRef),
}

impl Visit {
    #[inline(always)]
    pub(super) fn child(&self) -> Child {
        match self.child & LeafRef::LEAF {
            0 => Child::Node(self.child),
            _ => Child::LeafBlock(LeafRef::from_bits(self.child)),
        }
    }
}

/// The visits to come: a queue of rays for which any hit suffices, a stack of other rays. A queue keeps
/// at most one visit for each node and each block of the tree.
#[derive(Debug, Default)]
pub(super) struct Visits {
    list: Vec<Visit>,
    /// Number of visits that the queue has let go.
    gone: usize,
}

impl Visits {
    /// Creates an empty list whose capacity suffices for any stack.
    pub(super) fn for_tree(tree: &WideTree) -> Self {
        Self { list: Vec::with_capacity(1 + tree.depth * LANES), gone: 0 }
    }

    /// Replaces all visits by one of the root.
    #[inline(always)]
    pub(super) fn start(&mut self, rays: u32) {
        self.list.clear();
        self.list.push(Visit { distance: 0.0, child: 0, rays });
        self.gone = 0;
    }

    /// Whether a stack is empty.
    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Turns the visits of a beam, which are on a stack, into visits of `rays`. Multiplies their distances
    /// by `factor`, which must keep them lower bounds.
    #[inline(always)]
    pub(super) fn hand_over(&mut self, rays: u32, factor: f32) {
        for visit in &mut self.list {
            (visit.distance, visit.rays) = (visit.distance * factor, rays);
        }
    }

    /// Takes the newest visit. If `ANY` is set, takes the oldest instead, whose data has had the most time
    /// to arrive from memory.
    #[inline(always)]
    pub(super) fn next<const ANY: bool>(&mut self) -> Option<Visit> {
        if !ANY {
            return self.list.pop();
        }
        let visit = self.list.get(self.gone).copied();
        self.gone += 1;
        visit
    }

    /// Pushes the children of `node` that rays enter. In the lane of each child, `entering` has the
    /// set of rays that enter it, and `nearest` their least distance. The nearest child is visited
    /// next, unless `ANY` is set.
    #[inline(always)]
    pub(super) fn push<const ANY: bool>(
        &mut self,
        tree: &WideTree,
        node: &WideNode,
        entering: Int,
        nearest: Float,
    ) {
        let visits = &mut self.list;
        let entered = (!entering.eq(Int::ZERO)).bits();
        let (rays, distance) = (entering.to_array(), nearest.to_array());
        let first = visits.len();
        for lane in Bits(entered) {
            let visit =
                Visit { distance: distance[lane], child: node.children[lane], rays: rays[lane] };
            match visits[first..].last_mut() {
                // Leaves that share a block are next to each other.
                Some(before) if before.child == visit.child => {
                    before.distance = min(before.distance, visit.distance);
                    before.rays |= visit.rays;
                }
                _ => {
                    if tree.is_large {
                        tree.prefetch(visit.child);
                    }
                    visits.push(visit);
                }
            }
        }
        if !ANY {
            sort(&mut visits[first..]);
        }
    }
}

/// Sorts a few visits by insertion, the nearest last.
#[inline(always)]
fn sort(visits: &mut [Visit]) {
    for next in 1..visits.len() {
        let visit = visits[next];
        let mut at = next;
        while at > 0 && visits[at - 1].distance < visit.distance {
            visits[at] = visits[at - 1];
            at -= 1;
        }
        visits[at] = visit;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::LeafBlocks;
    use crate::math::Stream;
    use crate::simd::Lanes;

    /// A node whose children are numbered from 100, except that the blocks of lanes 2 to 4 are one.
    fn node() -> WideNode {
        let child = |lane| if (2..5).contains(&lane) { LeafRef::LEAF } else { 100 + lane as u32 };
        WideNode { planes: [[[0.0; LANES]; 2]; 3], children: std::array::from_fn(child) }
    }

    /// Pushes the children of [`node`] onto a visit of the root, and returns them as they are taken.
    fn order<const ANY: bool>(entering: Lanes<u32>, nearest: Lanes) -> Vec<(u32, f32, u32)> {
        let tree = WideTree { blocks: LeafBlocks::default(), depth: 1, ..WideTree::default() };
        let mut visits = Visits::for_tree(&tree);
        visits.start(9);
        visits.push::<ANY>(&tree, &node(), Int::new(entering), Float::new(nearest));
        let mut taken = Vec::new();
        while let Some(visit) = visits.next::<ANY>() {
            taken.push((visit.child, visit.distance, visit.rays));
        }
        let root = taken.remove(if ANY { 0 } else { taken.len() - 1 });
        assert_eq!(root, (0, 0.0, 9));
        taken
    }

    #[test]
    fn children_come_nearest_first_and_shared_blocks_once() {
        let mut entering = [0; LANES];
        let mut nearest = [f32::INFINITY; LANES];
        let entered =
            [(0, 1, 5.0), (1, 2, 1.0), (2, 4, 3.0), (4, 8, 0.5), (5, 3, 2.0), (7, 1, 7.0)];
        for (lane, rays, distance) in entered {
            (entering[lane], nearest[lane]) = (rays, distance);
        }
        let block = (LeafRef::LEAF, 0.5, 4 | 8);
        let in_order = [block, (101, 1.0, 2), (105, 2.0, 3), (100, 5.0, 1), (107, 7.0, 1)];
        assert_eq!(order::<false>(entering, nearest), in_order);
        let by_lane = [(100, 5.0, 1), (101, 1.0, 2), block, (105, 2.0, 3), (107, 7.0, 1)];
        assert_eq!(order::<true>(entering, nearest), by_lane);
        assert!(order::<false>([0; LANES], nearest).is_empty());
    }

    #[test]
    fn visits_are_handed_over() {
        let tree = WideTree { depth: 1, ..WideTree::default() };
        let mut visits = Visits::for_tree(&tree);
        visits.start(1);
        visits.next::<false>();
        assert!(visits.is_empty());
        let lanes = |value: f32| std::array::from_fn(|lane| if lane < 2 { value } else { 0.0 });
        let entering = Int::new(std::array::from_fn(|lane| u32::from(lane == 1 || lane == 6)));
        visits.push::<false>(&tree, &node(), entering, Float::new(lanes(4.0)));
        assert!(!visits.is_empty());
        visits.hand_over(0b101, 0.5);
        let taken = [(); 2].map(|()| visits.next::<false>().expect("two visits"));
        let taken = taken.map(|visit| (visit.child, visit.distance, visit.rays));
        assert_eq!(taken, [(106, 0.0, 0b101), (101, 2.0, 0b101)]);
    }

    #[test]
    fn any_children_come_sorted() {
        let mut random = Stream::new(6);
        let tree = WideTree { depth: 1, ..WideTree::default() };
        let mut visits = Visits::for_tree(&tree);
        for _ in 0..2000 {
            let nearest: Lanes = std::array::from_fn(|_| match random.bits() % 6 {
                0 => 0.0,
                1 => -0.0,
                2 => f32::INFINITY,
                3 => 1.0,
                _ => random.uniform() * 1e6,
            });
            let mut node = node();
            // Children are nodes, so that none are merged.
            node.children = std::array::from_fn(|lane| 100 + lane as u32);
            let entering: Lanes<u32> = std::array::from_fn(|_| random.bits() as u32 % 3);
            visits.start(1);
            visits.push::<false>(&tree, &node, Int::new(entering), Float::new(nearest));
            let mut popped = Vec::new();
            while let Some(visit) = visits.next::<false>() {
                popped.push(visit);
            }
            assert_eq!(popped.pop().map(|root| root.child), Some(0));
            assert!(popped.is_sorted_by_key(|visit| visit.distance));
            let entered = entering.iter().filter(|&&rays| rays != 0).count();
            assert_eq!(popped.len(), entered);
            for visit in popped {
                let lane = visit.child as usize - 100;
                assert_eq!((visit.distance, visit.rays), (nearest[lane], entering[lane]));
            }
        }
    }
}
