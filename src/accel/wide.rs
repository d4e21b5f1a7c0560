//! Wide nodes for beams and single rays: as many children as there are lanes, collapsed from the
//! binary tree.

use super::binary::{Below, BinaryTree};
use super::blocks::{BlockRef, Blocks, Kind};
use super::huge_pages::settle;
use crate::geometry::{Bounds, Geometry};
use crate::math::min;
use crate::simd::{LANES, Lanes, prefetch};

/// A node: the boxes of its children, and what they are.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct WideNode {
    /// Lower x, y, z, upper x, y, z. Lanes without a child hold a box that no ray enters.
    pub(super) planes: [Lanes; 6],
    /// Places of nodes, or bits of [`BlockRef`](super::blocks::BlockRef)s.
    pub(super) children: Lanes<u32>,
}

impl WideNode {
    const EMPTY: Self = Self {
        planes: {
            let (low, high) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
            [low, low, low, high, high, high]
        },
        children: [0; LANES],
    };

    fn set(&mut self, lane: usize, bounds: &Bounds, child: u32) {
        for axis in 0..3 {
            self.planes[axis][lane] = bounds.min[axis];
            self.planes[axis + 3][lane] = bounds.max[axis];
        }
        self.children[lane] = child;
    }
}

/// A tree of wide nodes over blocks.
#[derive(Clone, Debug)]
pub(super) struct WideTree {
    /// The root first; none where there is no primitive.
    pub(super) nodes: Vec<WideNode>,
    pub(super) blocks: Blocks,
    /// Nodes on the longest way from the root.
    pub(super) depth: usize,
    /// Whether it is larger than caches that are fast.
    pub(super) is_large: bool,
    /// Whether single rays take turns, each waiting for its block: worth it for blocks of
    /// triangles, which are long and few on a ray's way, and not for spheres (`profiling/`).
    pub(super) in_turn: bool,
}

/// Size from which a tree is larger than the caches that are fast.
const LARGE: usize = 1 << 20;

/// Cost of a node's visit over that of a block's test.
const NODE_COST: f32 = 1.0;

impl WideTree {
    /// The layout of `tree`.
    ///
    /// Children and leaves are chosen together by dynamic programming over the surface area
    /// cost (Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through
    /// Compressed Wide BVHs", section 3), with leaves of one kind and up to a block.
    pub(super) fn new(geometry: &Geometry, tree: &BinaryTree) -> Self {
        let mut layout = Self {
            nodes: Vec::new(),
            blocks: Blocks::default(),
            depth: 0,
            is_large: false,
            in_turn: false,
        };
        if tree.nodes.is_empty() {
            return layout;
        }
        let plan = Plan::new(geometry, tree);
        layout.nodes.push(WideNode::EMPTY);
        let mut open = vec![(0, 0, 1)];
        let mut children = Vec::new();
        while let Some((place, index, depth)) = open.pop() {
            layout.depth = layout.depth.max(depth);
            children.clear();
            plan.children(index, &mut children);
            for (lane, &child) in children.iter().enumerate() {
                let reference = if plan.is_block(child) {
                    layout.blocks.push(geometry, &mut tree.primitives(child)).bits()
                } else {
                    layout.nodes.push(WideNode::EMPTY);
                    let place = layout.nodes.len() - 1;
                    open.push((place, child, depth + 1));
                    place as u32
                };
                let bounds = &tree.nodes[child as usize].bounds;
                layout.nodes[place].set(lane, bounds, reference);
            }
        }
        layout.nodes = settle(layout.nodes);
        layout.blocks.settle();
        layout.is_large = layout.bytes() > LARGE;
        let blocks = &layout.blocks;
        let others = blocks.spheres.len() + blocks.moving_spheres.len() + blocks.quads.len();
        layout.in_turn = layout.is_large && blocks.triangles.len() > others;
        layout
    }

    /// Asks for the memory of a node or block.
    #[inline(always)]
    pub(super) fn prefetch(&self, next: u32) {
        if next & BlockRef::LEAF == 0 {
            prefetch(&self.nodes[next as usize]);
        } else {
            self.blocks.prefetch(BlockRef::from_bits(next));
        }
    }

    /// Size in memory.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + self.blocks.bytes()
    }
}

/// Children that a node can have at most while its parent has another.
const SHARES: usize = LANES - 1;

/// The cheapest way to cut every subtree.
struct Plan<'a> {
    tree: &'a BinaryTree,
    /// Least cost of a subtree that takes up to i + 1 children of a node above it.
    costs: Vec<[f32; SHARES]>,
    /// Primitives below.
    counts: Vec<u32>,
    /// Whether the subtree is best a block.
    blocks: Vec<bool>,
}

impl<'a> Plan<'a> {
    fn new(geometry: &Geometry, tree: &'a BinaryTree) -> Self {
        let count = tree.nodes.len();
        let mut plan = Self {
            tree,
            costs: vec![[0.0; SHARES]; count],
            counts: vec![1; count],
            blocks: vec![false; count],
        };
        // The kind of all primitives below, if there is but one.
        let mut kinds: Vec<Option<Kind>> = vec![None; count];
        for index in (0..count).rev() {
            let node = &tree.nodes[index];
            let area = node.bounds.half_area();
            match node.below {
                Below::Primitive(primitive) => {
                    kinds[index] = Some(Kind::of(geometry.get(primitive)));
                    plan.costs[index] = [area; SHARES];
                    plan.blocks[index] = true;
                }
                Below::Children(first) => {
                    let (left, right) = (first as usize, first as usize + 1);
                    plan.counts[index] = plan.counts[left] + plan.counts[right];
                    kinds[index] = kinds[left].filter(|_| kinds[left] == kinds[right]);
                    let fits = kinds[index].is_some() && plan.counts[index] <= LANES as u32;
                    let as_node = area * NODE_COST + plan.split(first, LANES).0;
                    plan.blocks[index] = fits && area <= as_node;
                    let mut best = if plan.blocks[index] { area } else { as_node };
                    let most = (plan.counts[index] as usize).min(SHARES);
                    for shares in 1..=SHARES {
                        if (2..=most).contains(&shares) {
                            best = min(best, plan.split(first, shares).0);
                        }
                        plan.costs[index][shares - 1] = best;
                    }
                }
            }
        }
        // The root is a node, whatever it costs; a single primitive is its own child.
        plan.blocks[0] = plan.counts[0] == 1;
        plan
    }

    fn is_block(&self, index: u32) -> bool {
        self.blocks[index as usize]
    }

    /// Least cost of two siblings that take up to `shares` children together, and the shares
    /// of the first.
    fn split(&self, first: u32, shares: usize) -> (f32, usize) {
        let (left, right) = (first as usize, first as usize + 1);
        let most = (self.counts[left] as usize).min(shares - 1);
        let rest = self.counts[right] as usize;
        let fewest = shares.saturating_sub(rest).clamp(1, most);
        (fewest..=most)
            .map(|l| (self.costs[left][l - 1] + self.costs[right][shares - l - 1], l))
            .fold(
                (f32::INFINITY, fewest),
                |best, split| if split.0 < best.0 { split } else { best },
            )
    }

    /// The subtrees that are the children of node `index`.
    fn children(&self, index: u32, children: &mut Vec<u32>) {
        let Below::Children(first) = self.tree.nodes[index as usize].below else {
            children.push(index);
            return;
        };
        self.share(first, LANES, children);
    }

    fn share(&self, first: u32, shares: usize, children: &mut Vec<u32>) {
        let (_, left) = self.split(first, shares);
        self.take(first, left, children);
        self.take(first + 1, shares - left, children);
    }

    /// The subtrees that stand for `index` where it takes up to `shares` children.
    fn take(&self, index: u32, shares: usize, children: &mut Vec<u32>) {
        let costs = &self.costs[index as usize];
        // The fewest shares of the same cost.
        let shares = (1..=shares).find(|s| costs[s - 1] == costs[shares - 1]).unwrap_or(shares);
        match self.tree.nodes[index as usize].below {
            Below::Children(first) if shares > 1 => self.share(first, shares, children),
            _ => children.push(index),
        }
    }
}
