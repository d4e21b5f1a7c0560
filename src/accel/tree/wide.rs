//! Wide trees for beams and single rays, collapsed from the binary tree: a node has up to [`LANES`]
//! children.

use super::binary::BinaryTree;
use super::collapse::Collapse;
use crate::accel::huge_pages::settle;
use crate::accel::leaf::{BlockRef, Blocks};
use crate::geometry::{Bounds, Geometry, Shape};
use crate::simd::{LANES, Lanes, prefetch};

/// A node: the boxes of its children, and references to the children.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct WideNode {
    /// Lower x, y, z, then upper x, y, z. Lanes without a child hold a box that no ray enters.
    pub(crate) planes: [Lanes; 6],
    /// Indices of nodes, or bits of [`BlockRef`]s, which are equal for leaves that share a block.
    pub(crate) children: Lanes<u32>,
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
pub(crate) struct WideTree {
    /// The root is first. Empty if the tree has no primitives.
    pub(crate) nodes: Vec<WideNode>,
    pub(crate) blocks: Blocks,
    /// Number of nodes on the longest path from the root.
    pub(crate) depth: usize,
    /// Whether the tree is larger than the fast caches.
    pub(crate) is_large: bool,
    /// Whether single rays take turns while they wait for their blocks. This pays for triangles,
    /// whose blocks are long and of which a ray meets only few, but not for spheres (`profiling/`).
    pub(crate) in_turn: bool,
}

/// Size in bytes above which a tree is larger than the fast caches.
const LARGE: usize = 1 << 20;

impl WideTree {
    /// Lays out `tree`.
    ///
    /// Neighbouring leaves of one shape share a block if they fit. Each leaf has its own
    /// box, and a visit of one of them visits them all. Sharing blocks halves the memory for a
    /// million spheres (`profiling/`).
    pub(crate) fn new(geometry: &Geometry, tree: &BinaryTree) -> Self {
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
        let collapse = Collapse::new(geometry, tree);
        layout.nodes.push(WideNode::EMPTY);
        let mut open = vec![(0, 0, 1)];
        let mut children = Vec::new();
        while let Some((slot, index, depth)) = open.pop() {
            layout.depth = layout.depth.max(depth);
            children.clear();
            collapse.children(index, &mut children);
            let mut lane = 0;
            for run in collapse.runs(&children) {
                let child = if collapse.is_leaf(run[0]) {
                    let leaves = run.iter().flat_map(|&leaf| tree.primitives(leaf));
                    let mut primitives: Vec<u32> = leaves.collect();
                    layout.blocks.push(geometry, &mut primitives).bits()
                } else {
                    let below = layout.nodes.len();
                    layout.nodes.push(WideNode::EMPTY);
                    open.push((below, run[0], depth + 1));
                    below as u32
                };
                for &index in run {
                    let bounds = &tree.nodes[index as usize].bounds;
                    layout.nodes[slot].set(lane, bounds, child);
                    lane += 1;
                }
            }
        }
        layout.nodes = settle(layout.nodes);
        layout.blocks.settle();
        layout.is_large = layout.bytes() > LARGE;
        let blocks = &layout.blocks;
        let triangles = blocks.count(Shape::Triangle);
        layout.in_turn = layout.is_large && 2 * triangles > blocks.len();
        layout
    }

    /// Prefetches a node or a block.
    #[inline(always)]
    pub(crate) fn prefetch(&self, next: u32) {
        if next & BlockRef::LEAF == 0 {
            prefetch(&self.nodes[next as usize]);
        } else {
            self.blocks.prefetch(BlockRef::from_bits(next));
        }
    }

    /// Size in memory.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + self.blocks.bytes()
    }
}
