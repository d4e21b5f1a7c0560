//! Assembles the wide tree of a large scene from clusters.

use std::collections::BTreeMap;
use std::mem::take;

use super::binary::{Below, BinaryNode, BinaryTree, LeafContent};
use super::collapse::Collapse;
use super::subtree::Subtree;
use crate::geometry::{Bounds, Geometry};

/// The layout of a cluster: its largest subtrees and its primitives outside them, with their boxes.
/// Each subtree begins with a node of its own.
pub(super) struct Cluster {
    part: Subtree,
    /// Number of primitives.
    primitives: usize,
    elements: Vec<(LeafContent, Bounds)>,
}

impl Cluster {
    /// A cluster of so many primitives, with these bounds, whose nodes and blocks are those of `part`.
    pub(super) fn whole(part: Subtree, primitives: usize, bounds: Bounds) -> Self {
        Self { part, primitives, elements: vec![(LeafContent::Node(0), bounds)] }
    }

    /// The largest subtrees of `tree`.
    pub(super) fn new(geometry: &Geometry, tree: &BinaryTree) -> Self {
        let collapse = Collapse::new(geometry, tree, LeafContent::Primitive);
        let (mut part, mut elements) = (Subtree::default(), Vec::new());
        for root in tree.largest() {
            // Subtrees that fit into a block are left to the tree over all clusters.
            let mut open = vec![root];
            while let Some(node) = open.pop() {
                let BinaryNode { bounds, below } = tree.nodes[node as usize];
                match below {
                    Below::Primitive(primitive) => {
                        elements.push((LeafContent::Primitive(primitive), bounds));
                    }
                    Below::Children(first) if collapse.is_leaf(node) => {
                        open.extend([first + 1, first]);
                    }
                    Below::Children(_) => {
                        let slot = part.push();
                        part.lay_out(geometry, &collapse, slot, node, LeafContent::Primitive);
                        elements.push((LeafContent::Node(slot as u32), bounds));
                    }
                }
            }
        }
        // A binary tree has one node less above its leaves than leaves.
        let primitives = tree.nodes.len().div_ceil(2);
        Self { part, primitives, elements }
    }
}

/// A wide tree of clusters, which are appended in order, whatever the order in which they are finished.
pub(super) struct Assembly {
    /// Its first node is the root, which is empty until all clusters are there.
    tree: Subtree,
    elements: Vec<(LeafContent, Bounds)>,
    /// Number of appended clusters, of the primitives in them, and of all primitives.
    appended: usize,
    primitives: usize,
    total: usize,
    /// Finished clusters that come after unfinished ones.
    waiting: BTreeMap<usize, Cluster>,
}

impl Assembly {
    pub(super) fn new(total: usize) -> Self {
        let mut tree = Subtree::default();
        tree.push();
        let (elements, waiting) = (Vec::new(), BTreeMap::new());
        Self { tree, elements, appended: 0, primitives: 0, total, waiting }
    }

    pub(super) fn add(&mut self, number: usize, cluster: Cluster) {
        self.waiting.insert(number, cluster);
        while let Some(cluster) = self.waiting.remove(&self.appended) {
            let Cluster { part, primitives, elements } = cluster;
            self.primitives += primitives;
            // Clusters differ a little in their numbers of nodes and blocks.
            let growth = 1.05 * self.total as f64 / self.primitives as f64;
            let first = self.tree.append(part, growth);
            self.elements.extend(elements.into_iter().map(|(element, bounds)| match element {
                LeafContent::Node(node) => (LeafContent::Node(node + first), bounds),
                primitive => (primitive, bounds),
            }));
            self.appended += 1;
        }
    }

    /// Builds the tree over the elements of all clusters.
    pub(super) fn finish(self, geometry: &Geometry) -> Subtree {
        let Self { mut tree, elements, .. } = self;
        let boxes: Vec<Bounds> = elements.iter().map(|(_, bounds)| *bounds).collect();
        let all: Vec<u32> = (0..elements.len() as u32).collect();
        let top = BinaryTree::of_cluster(&boxes, &all);
        let element = |number: u32| elements[number as usize].0;
        let collapse = Collapse::new(geometry, &top, element);
        let below = take(&mut tree.depth);
        tree.lay_out(geometry, &collapse, 0, 0, element);
        tree.depth += below;
        tree
    }
}
