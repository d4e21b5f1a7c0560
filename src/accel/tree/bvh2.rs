//! The binary bounding volume hierarchy of the scalar engine.

use std::ops::Range;

use super::binary::{Below, BinaryTree};
use crate::accel::slab::{Planes, planes};
use crate::geometry::{Bounds, Geometry};

/// A binary tree of boxes over the elements of a scene, built by obvhs.
#[derive(Clone, Debug)]
pub struct Bvh2 {
    /// The root is first, and the two children of an inner node are adjacent.
    pub(in crate::accel) nodes: Vec<Node>,
    /// Elements in the order of the leaves.
    pub(in crate::accel) elements: Vec<u32>,
    /// A box around all elements and the origins of the object spaces of instances.
    pub(in crate::accel) bounds: Bounds,
    /// Number of inner nodes on the longest path from the root, which is the stack size required.
    pub(in crate::accel) depth: usize,
    /// The largest [`Geometry::condition`].
    pub(in crate::accel) condition: f32,
    /// The trees of the meshes that instances place.
    pub(in crate::accel) meshes: Vec<Self>,
}

/// 32 bytes, so that two children share a cache line.
#[derive(Clone, Copy, Debug)]
pub(in crate::accel) struct Node {
    pub(in crate::accel) planes: Planes,
    /// Index of the first child, or of the first element in `Bvh2::elements`.
    pub(in crate::accel) first: u32,
    /// Number of elements; 0 for an inner node.
    pub(in crate::accel) count: u32,
}

impl Node {
    const UNKNOWN: Self = Self { planes: [0.0; 6], first: 0, count: 0 };
}

/// Largest number of elements in a leaf.
const LEAF: u32 = 4;

/// Returns the number of inner nodes on the longest path from the root.
fn depth(nodes: &[Node]) -> usize {
    let mut deepest = 0;
    let mut open = vec![(0, 0)];
    while let Some((index, above)) = open.pop() {
        let node = &nodes[index as usize];
        if node.count == 0 {
            open.extend([(node.first, above + 1), (node.first + 1, above + 1)]);
        }
        deepest = deepest.max(above);
    }
    deepest
}

impl Bvh2 {
    /// Builds a tree whose boxes contain every element at all times, on `threads` threads.
    pub fn new(geometry: &Geometry, threads: usize) -> Self {
        let boxes = geometry.boxes();
        let over = |geometry: &Geometry, boxes: &[Bounds], elements: Range<u32>| {
            let elements: Vec<u32> = elements.collect();
            Self::of(geometry, &BinaryTree::new(boxes, &elements, threads))
        };
        let mut tree = over(geometry, &boxes, 0..boxes.len() as u32);
        let instances = &geometry.instances;
        let triangles = instances.triangles();
        let boxes = triangles.boxes();
        let mesh = |mesh: usize| over(triangles, &boxes, instances.range(mesh));
        tree.meshes = (0..instances.meshes()).map(mesh).collect();
        tree.bounds = tree.bounds.union(instances.centers());
        tree
    }

    /// Lays out `tree`, assuming that visiting a node costs as much as testing a primitive.
    pub(crate) fn of(geometry: &Geometry, tree: &BinaryTree) -> Self {
        let bounds = tree.nodes.first().map_or(Bounds::EMPTY, |root| root.bounds);
        let leaf = tree.leaves(1.0, LEAF, |_| ());
        let mut layout = Self {
            nodes: Vec::new(),
            elements: Vec::new(),
            bounds,
            depth: 0,
            condition: geometry.condition(),
            meshes: Vec::new(),
        };
        if tree.nodes.is_empty() {
            return layout;
        }
        layout.nodes.push(Node::UNKNOWN);
        let mut open = vec![(0, 0)];
        while let Some((slot, index)) = open.pop() {
            let node = &tree.nodes[index as usize];
            let (first, count) = match node.below {
                Below::Children(first) if !leaf[index as usize] => {
                    let slot = layout.nodes.len();
                    layout.nodes.extend([Node::UNKNOWN; 2]);
                    open.extend([(slot + 1, first + 1), (slot, first)]);
                    (slot as u32, 0)
                }
                _ => {
                    let members = tree.primitives(index);
                    let first = layout.elements.len() as u32;
                    layout.elements.extend_from_slice(&members);
                    (first, members.len() as u32)
                }
            };
            layout.nodes[slot] = Node { planes: planes(&node.bounds), first, count };
        }
        layout.depth = depth(&layout.nodes);
        layout
    }

    /// Size in memory.
    pub(crate) fn bytes(&self) -> usize {
        let meshes: usize = self.meshes.iter().map(Self::bytes).sum();
        size_of_val(&*self.nodes) + size_of_val(&*self.elements) + meshes
    }
}
