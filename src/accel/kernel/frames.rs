//! Visits the children of wide nodes in order, nearest first.
//!
//! The keys of the entered children stay in the lanes of a vector, and each visit removes the least
//! key. Nothing is sorted, and there is no branch on the number of children, which would be
//! unpredictable. A key holds the bits of the child's entry distance, which order like integers
//! because the distance is not negative, and the child's lane in the lowest bits. Leaves that share
//! a block are removed together.

use crate::accel::leaf::BlockRef;
use crate::accel::tree::wide::WideTree;
use crate::simd::{Float, Int, LANES, Mask};

/// The bits of a key that hold the lane.
const LANE: u32 = LANES as u32 - 1;
/// The bits of a key that hold the distance: all except the bits of the lane and the sign bit,
/// which is set for −0.
const DISTANCE: u32 = !(1 << 31) & !LANE;
/// A value above every key, for lanes without a child.
const NONE: u32 = u32::MAX >> 1;

/// The children of a node that are still to be visited.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    keys: Int,
    /// The least key.
    least: u32,
    /// Index of the node.
    node: u32,
}

impl Frame {
    /// A placeholder without children.
    pub(crate) const NONE: Self = Self { keys: Int::ZERO, least: NONE, node: 0 };

    /// Creates a frame with the children of `node` in the lanes of `entered`. The distances `entry`
    /// are not negative, since no ray has a negative `t_min`
    /// ([`RayBatch`](crate::accel::RayBatch)).
    #[inline(always)]
    pub(crate) fn new(node: u32, entry: Float, entered: Mask) -> Self {
        let keys = (entry.to_bits() & Int::splat(DISTANCE)) | Int::LANE;
        let keys = entered.select(keys, Int::splat(NONE));
        Self { keys, least: keys.least_lane(), node }
    }

    /// Removes and returns the nearest child, a node or a block of `tree`, if the ray enters it up
    /// to `limit`. Leaves that share the block are removed with it.
    #[inline(always)]
    fn take(&mut self, tree: &WideTree, limit: f32) -> Option<u32> {
        // Compared as signed integers, so that a negative limit is below every key.
        if self.least as i32 > (limit.to_bits() | LANE) as i32 {
            return None;
        }
        let child = self.nearest(tree);
        let children = Int::new(tree.nodes[self.node as usize].children);
        let taken = children.eq(Int::splat(child));
        self.keys = taken.select(Int::splat(NONE), self.keys);
        self.least = self.keys.least_lane();
        Some(child)
    }

    /// Removes and returns the nearest child, if it is a node that the ray enters up to `limit`.
    #[inline(always)]
    pub(crate) fn take_node(&mut self, tree: &WideTree, limit: f32) -> Option<u32> {
        let is_node = self.nearest(tree) & BlockRef::LEAF == 0;
        if is_node { self.take(tree, limit) } else { None }
    }

    /// Returns the nearest child, or an arbitrary one if no child is left.
    #[inline(always)]
    pub(crate) fn nearest(&self, tree: &WideTree) -> u32 {
        tree.nodes[self.node as usize].children[(self.least & LANE) as usize]
    }
}

/// A stack of frames, one for each node above the current one that has children left.
#[derive(Clone, Debug)]
pub(crate) struct Frames {
    keys: Vec<Int>,
    /// The least key and the node of each frame.
    rest: Vec<(u32, u32)>,
    top: usize,
}

impl Frames {
    /// Creates an empty stack with room for a path of `depth` nodes.
    pub(crate) fn with_depth(depth: usize) -> Self {
        Self { keys: vec![Int::ZERO; depth], rest: vec![(0, 0); depth], top: 0 }
    }

    #[inline(always)]
    pub(crate) fn clear(&mut self) {
        self.top = 0;
    }

    /// Pushes `frame`, unless it has no children left. Call this before visiting the child that was
    /// taken from `frame`. With `prefetch`, prefetches the next child of `frame`.
    #[inline(always)]
    pub(crate) fn push(&mut self, frame: &Frame, tree: &WideTree, prefetch: bool) {
        self.keys[self.top] = frame.keys;
        self.rest[self.top] = (frame.least, frame.node);
        self.top += usize::from(frame.least != NONE);
        // If no child is left, the prefetch is useless, but a branch to avoid it costs more.
        if prefetch {
            tree.prefetch(frame.nearest(tree));
        }
    }

    /// Removes and returns the nearest child in `frame`, or else in the closest frame above it with
    /// a child that the ray enters up to `limit`. That frame becomes `frame`.
    #[inline(always)]
    pub(crate) fn next(&mut self, frame: &mut Frame, tree: &WideTree, limit: f32) -> Option<u32> {
        loop {
            if let Some(child) = frame.take(tree, limit) {
                return Some(child);
            }
            *frame = self.pop()?;
        }
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<Frame> {
        self.top = self.top.checked_sub(1)?;
        let (least, node) = self.rest[self.top];
        Some(Frame { keys: self.keys[self.top], least, node })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::leaf::Blocks;
    use crate::accel::tree::wide::WideNode;
    use crate::math::random::Stream;
    use crate::simd::{Lanes, first_bits};

    /// A tree of nodes whose children are numbered from 100, 200 and so on.
    fn tree(nodes: u32) -> WideTree {
        let children = |node: u32| std::array::from_fn(|lane| 100 * node + lane as u32);
        let node = |node| WideNode { planes: [[[0.0; LANES]; 2]; 3], children: children(node) };
        let (nodes, blocks) = ((1..=nodes).map(node).collect(), Blocks::default());
        WideTree { nodes, blocks, depth: 3, ..WideTree::default() }
    }

    /// Takes all children of one node, and returns their lanes in order.
    fn order(entry: Lanes, entered: u32, limit: f32) -> Vec<usize> {
        let tree = tree(1);
        let mut frame = Frame::new(0, Float::new(entry), Mask::from_bits(entered));
        let mut frames = Frames::with_depth(tree.depth);
        std::iter::from_fn(|| frames.next(&mut frame, &tree, limit))
            .map(|child| child as usize - 100)
            .collect()
    }

    #[test]
    fn children_come_nearest_first_up_to_the_limit() {
        let mut random = Stream::new(6);
        for _ in 0..2000 {
            let entry: Lanes = std::array::from_fn(|_| match random.bits() % 8 {
                0 => 0.0,
                1 => -0.0,
                2 => f32::INFINITY,
                3 => 1e-30,
                // Equal distances, or ones that differ too little for a key to distinguish.
                4 => 1.0,
                5 => 1.0f32.next_up(),
                _ => random.uniform() * 1e6,
            });
            let entered = random.bits() as u32 & first_bits(LANES);
            for limit in [0.0, 1.0, 1000.0, f32::INFINITY] {
                let visited = order(entry, entered, limit);
                let coarse = |lane: usize| entry[lane].abs().to_bits() & !LANE;
                assert!(visited.is_sorted_by_key(|&lane| coarse(lane)), "{entry:?} {visited:?}");
                for lane in 0..LANES {
                    // Every child that is entered up to the limit must be visited. A child
                    // slightly beyond the limit may be visited, too.
                    let is_in = entered >> lane & 1 == 1;
                    let count = visited.iter().filter(|&&other| other == lane).count();
                    assert!(count <= usize::from(is_in), "{visited:?}");
                    assert!(count == 1 || !is_in || entry[lane] > limit, "{limit} {entry:?}");
                    assert!(count == 0 || coarse(lane) <= limit.to_bits() | LANE);
                }
            }
            // A finished ray visits nothing.
            assert!(order(entry, entered, f32::NEG_INFINITY).is_empty());
        }
    }

    #[test]
    fn traversal_resumes_at_frames_above() {
        let tree = tree(3);
        let frame = |node: u32, entry: fn(f32) -> f32, entered: u32| {
            let entry = Float::new(std::array::from_fn(|lane| entry(lane as f32)));
            Frame::new(node, entry, Mask::from_bits(entered))
        };
        let (up, down) = (|lane: f32| lane, |lane: f32| 9.0 - lane);
        let mut frames = Frames::with_depth(tree.depth);
        let mut here = frame(0, up, 0b101);
        assert_eq!(frames.next(&mut here, &tree, 9.0), Some(100));
        frames.push(&here, &tree, false);
        here = frame(1, up, 0b1);
        assert_eq!(frames.next(&mut here, &tree, 9.0), Some(200));
        // The frame has no children left, so it is not kept.
        frames.push(&here, &tree, false);
        assert_eq!(frames.top, 1);
        here = frame(2, down, 0b11);
        assert_eq!(frames.next(&mut here, &tree, 9.0), Some(301), "first the current node");
        assert_eq!(frames.next(&mut here, &tree, 5.0), Some(102), "then the node above");
        assert_eq!(frames.next(&mut here, &tree, 9.0), None);

        here = frame(1, up, 0b11);
        frames.push(&here, &tree, false);
        frames.clear();
        here = frame(2, up, 0);
        assert_eq!(frames.next(&mut here, &tree, 9.0), None, "the previous ray left no frame");
    }

    #[test]
    fn leaves_that_share_a_block_are_taken_together() {
        let mut tree = tree(1);
        tree.nodes[0].children[2] = 100;
        tree.nodes[0].children[5] = 100;
        let entry = Float::new(std::array::from_fn(|lane| lane as f32));
        let mut frame = Frame::new(0, entry, Mask::from_bits(0b11_1110));
        let mut frames = Frames::with_depth(tree.depth);
        let visits: Vec<u32> = std::iter::from_fn(|| frames.next(&mut frame, &tree, 9.0)).collect();
        assert_eq!(visits, [101, 100, 103, 104]);
    }
}
