//! Parts of wide trees, laid out from binary trees.

use super::binary::{Below, LeafContent};
use super::collapse::Collapse;
use crate::accel::{LeafBlocks, LeafRef};
use crate::geometry::{Bounds, Geometry};
use crate::huge_pages::reserve;
use crate::simd::{LANES, Lanes};

/// A node: the boxes of its children, and references to the children.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct WideNode {
    /// The lower and the upper plane on each axis. Lanes without a child hold a box that no ray
    /// enters.
    pub(crate) planes: [[Lanes; 2]; 3],
    /// Indices of nodes, or bits of [`LeafRef`]s, which are equal for leaves that share a block.
    pub(crate) children: Lanes<u32>,
}

impl WideNode {
    const EMPTY: Self = Self {
        planes: [[[f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]]; 3],
        children: [0; LANES],
    };

    pub(super) fn set(&mut self, lane: usize, bounds: &Bounds, child: u32) {
        for axis in 0..3 {
            let [low, high] = &mut self.planes[axis];
            (low[lane], high[lane]) = (bounds.min[axis], bounds.max[axis]);
        }
        self.children[lane] = child;
    }
}

/// A part of a wide tree, whose references count from its own first node and block.
#[derive(Debug, Default)]
pub(super) struct Subtree {
    pub(super) nodes: Vec<WideNode>,
    pub(super) blocks: LeafBlocks,
    /// Number of nodes on the longest path to a node.
    pub(super) depth: usize,
}

impl Subtree {
    /// Lays out the subtree of `tree` from node `root` on. Its wide node becomes `slot`. `element`
    /// returns what a leaf stands for.
    ///
    /// Neighbouring leaves of one shape share a block if they fit. Each leaf has its own
    /// box, and a visit of one of them visits them all. Sharing blocks halves the memory for a
    /// million spheres (`profiling/`).
    pub(super) fn lay_out(
        &mut self,
        geometry: &Geometry,
        collapse: &Collapse<'_>,
        slot: usize,
        root: u32,
        element: impl Fn(u32) -> LeafContent,
    ) {
        let tree = collapse.tree();
        let mut open = vec![(slot, root, 1)];
        let mut children = Vec::new();
        while let Some((slot, index, depth)) = open.pop() {
            self.depth = self.depth.max(depth);
            children.clear();
            collapse.children(index, &mut children);
            let mut lane = 0;
            for run in collapse.runs(&children) {
                let child = match tree.nodes[run[0] as usize].below {
                    _ if collapse.is_leaf(run[0]) => {
                        let leaves = run.iter().flat_map(|&leaf| tree.primitives(leaf));
                        let primitive = |number: u32| match element(number) {
                            LeafContent::Primitive(primitive) => primitive,
                            LeafContent::Node(_) => unreachable!("a leaf has primitives"),
                        };
                        let mut primitives: Vec<u32> = leaves.map(primitive).collect();
                        self.blocks.push(geometry, &mut primitives).bits()
                    }
                    Below::Primitive(number) => match element(number) {
                        LeafContent::Node(node) => node,
                        LeafContent::Primitive(_) => unreachable!("a primitive is a leaf"),
                    },
                    Below::Children(_) => {
                        let below = self.push();
                        open.push((below, run[0], depth + 1));
                        below as u32
                    }
                };
                for &index in run {
                    let bounds = &tree.nodes[index as usize].bounds;
                    self.nodes[slot].set(lane, bounds, child);
                    lane += 1;
                }
            }
        }
    }

    /// Appends an empty node. Returns its index.
    pub(super) fn push(&mut self) -> usize {
        self.nodes.push(WideNode::EMPTY);
        self.nodes.len() - 1
    }

    /// Appends a part. `growth` estimates the ratio of the final size to the size after this call.
    /// Returns the index of the part's first node.
    pub(super) fn append(&mut self, mut part: Self, growth: f64) -> u32 {
        let (first, blocks) = (self.nodes.len() as u32, self.blocks.counts());
        reserve(&mut self.nodes, part.nodes.len(), growth);
        self.nodes.extend(part.nodes.drain(..).map(|node| {
            let children = node.children.map(|child| match child & LeafRef::LEAF {
                0 => child + first,
                _ => LeafRef::from_bits(child).moved(&blocks).bits(),
            });
            WideNode { children, ..node }
        }));
        self.blocks.append(part.blocks, growth);
        self.depth = self.depth.max(part.depth);
        first
    }
}
