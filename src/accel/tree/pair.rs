//! Binary trees for packets, whose nodes hold the boxes of both children in one cache line.

use super::binary::{Below, BinaryTree};
use crate::accel::slab::{Planes, planes};
use crate::accel::{Extent, LeafBlocks, LeafRef};
use crate::geometry::{Bounds, Geometry};
use crate::simd::LANES;

/// A node: the boxes of its two children, in one of two forms, and references to the children.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct PairNode {
    pub(crate) boxes: [[f32; 6]; 2],
    /// Indices of nodes, or bits of [`LeafRef`]s.
    pub(crate) children: [u32; 2],
    /// The axis on which the centres of the children's boxes differ most. The first child is lower
    /// on it.
    pub(crate) axis: u32,
}

impl PairNode {
    const EMPTY: Self = Self { boxes: [[0.0; 6]; 2], children: [0; 2], axis: 0 };
}

/// A tree of pair nodes over blocks.
#[derive(Clone, Debug)]
pub(crate) struct PairTree {
    /// Nodes with boxes as [`Planes`], for packets whose rays agree in the signs of their
    /// directions or begin far away.
    pub(crate) nodes: Vec<PairNode>,
    /// The same nodes with boxes as centres and half edges, for other packets.
    pub(crate) middles: Vec<PairNode>,
    /// Distance by which the boxes' planes have been moved outward.
    pub(crate) slack: f32,
    pub(crate) blocks: LeafBlocks,
    /// A node or a block; `None` if the tree has no primitives.
    pub(crate) root: Option<u32>,
    /// Stack size that a traversal requires.
    pub(crate) stack: usize,
}

/// Cost of visiting a node, relative to testing one primitive.
const NODE_COST: f32 = 6.0;
/// Largest number of primitives in a leaf.
const LEAF: u32 = if LANES < 12 { LANES as u32 } else { 12 };

impl PairTree {
    /// Lays out `tree`. Subtrees of one shape become leaves if that is cheaper than their nodes.
    pub(crate) fn new(geometry: &Geometry, tree: &BinaryTree, extent: &Extent) -> Self {
        let leaf = tree.leaves(NODE_COST, LEAF, |primitive| geometry.shape(primitive));
        let mut layout = Self {
            nodes: Vec::new(),
            middles: Vec::new(),
            slack: extent.slack_within(REACH),
            blocks: LeafBlocks::default(),
            root: None,
            stack: 1,
        };
        if tree.nodes.is_empty() {
            return layout;
        }
        // Each entry has the node and side that will hold the reference to the subtree, the
        // subtree, and its depth.
        let mut open = vec![(None, 0u32, 1)];
        while let Some((parent, index, depth)) = open.pop() {
            layout.stack = layout.stack.max(depth);
            let reference = match tree.nodes[index as usize].below {
                Below::Children(first) if !leaf[index as usize] => {
                    let slot = layout.nodes.len();
                    let bounds = |child: u32| tree.nodes[child as usize].bounds;
                    let (axis, swapped) = order(&bounds(first), &bounds(first + 1));
                    let sides = if swapped { [first + 1, first] } else { [first, first + 1] };
                    let mut node = PairNode { axis, ..PairNode::EMPTY };
                    for side in [1, 0] {
                        node.boxes[side] = wider(&bounds(sides[side]), layout.slack);
                        open.push((Some((slot, side)), sides[side], depth + 1));
                    }
                    layout.nodes.push(node);
                    slot as u32
                }
                _ => layout.blocks.push(geometry, &mut tree.primitives(index)).bits(),
            };
            match parent {
                Some((slot, side)) => layout.nodes[slot].children[side] = reference,
                None => layout.root = Some(reference),
            }
        }
        let middles = |node: &PairNode| PairNode { boxes: node.boxes.map(middle), ..*node };
        layout.middles = layout.nodes.iter().map(middles).collect();
        layout
    }

    /// Size in memory.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.nodes) + size_of_val(&*self.middles) + self.blocks.bytes()
    }

    /// Returns the block that `reference` refers to, or `None` if it refers to a node.
    #[inline(always)]
    pub(crate) fn block(reference: u32) -> Option<LeafRef> {
        (reference & LeafRef::LEAF != 0).then(|| LeafRef::from_bits(reference))
    }
}

/// Rays that begin within this distance of the boxes need no more slack than the boxes contain. The
/// unit is the sum of the three edges of the bounding box of all boxes.
const REACH: f32 = 4.0;

/// Returns the planes of a box, moved outward by `slack`.
fn wider(bounds: &Bounds, slack: f32) -> Planes {
    let mut planes = planes(bounds);
    for axis in 0..3 {
        planes[axis] = (planes[axis] - slack).next_down();
        planes[axis + 3] = (planes[axis + 3] + slack).next_up();
    }
    planes
}

/// Returns the centre and the half edges of a box that contains the box with these planes.
fn middle(planes: Planes) -> [f32; 6] {
    let mut sides = [0.0; 6];
    for axis in 0..3 {
        let (low, high) = (f64::from(planes[axis]), f64::from(planes[axis + 3]));
        let middle = (0.5 * (low + high)) as f32;
        let half = (high - f64::from(middle)).max(f64::from(middle) - low);
        (sides[axis], sides[axis + 3]) = (middle, (half as f32).next_up());
    }
    sides
}

/// Returns the axis on which the centres of two boxes differ most, and whether the second is lower.
fn order(a: &Bounds, b: &Bounds) -> (u32, bool) {
    let apart = (b.min + b.max) - (a.min + a.max);
    let size = apart.abs();
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    (axis, apart[axis as usize] < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;
    use glam::Vec3;

    #[test]
    fn boxes_grow_by_the_slack_in_both_forms() {
        let mut random = Stream::new(8);
        for round in 0..10_000 {
            let size = [1e-6, 1.0, 1e6][round % 3];
            let mut point = || Vec3::from_array([(); 3].map(|()| random.between(-size, size)));
            let (a, b) = (point(), point());
            let bounds = Bounds { min: a.min(b), max: a.max(b) };
            let slack = [0.0, 1e-5, 3.0][round / 3 % 3];
            let wide = wider(&bounds, slack);
            let sides = middle(wide);
            for axis in 0..3 {
                let exact = |value: f32| f64::from(value);
                let low = exact(bounds.min[axis]) - exact(slack);
                let high = exact(bounds.max[axis]) + exact(slack);
                assert!(exact(wide[axis]) <= low && exact(wide[axis + 3]) >= high);
                let (middle, half) = (exact(sides[axis]), exact(sides[axis + 3]));
                assert!(middle - half <= low && middle + half >= high, "{bounds:?} {slack}");
                // The boxes are only slightly larger than necessary.
                let more = 1e-6 * (exact(size) + exact(slack));
                assert!(middle - half >= low - more && middle + half <= high + more);
            }
        }
    }
}
