//! The binary tree from which every layout is built, itself built by obvhs.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::time::Duration;

use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

use super::concentric::Concentric;
use super::partition::{MAX_CLUSTER, clusters};
use crate::accel::threads::map;
use crate::geometry::Bounds;
use crate::math::Stream;

/// A binary tree of boxes with one primitive in each leaf. A node precedes its children, which are
/// adjacent; node 0 is the root.
#[derive(Clone, Debug, Default)]
pub(crate) struct BinaryTree {
    pub(crate) nodes: Vec<BinaryNode>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct BinaryNode {
    pub(crate) bounds: Bounds,
    pub(crate) below: Below,
}

/// The contents of a node.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Below {
    /// Index of the first of two children.
    Children(u32),
    /// The primitive of a leaf.
    Primitive(u32),
}

/// What a leaf of a tree stands for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LeafContent {
    Primitive(u32),
    /// A node of the wide tree that is built from this one.
    Node(u32),
}

/// Parameters of obvhs. Leaves hold one primitive, since each layout chooses its own leaves.
const BUILD: BvhBuildParams = BvhBuildParams {
    pre_split: false,
    max_prims_per_leaf: 1,
    post_collapse_reinsertion_batch_ratio_multiplier: 0.0,
    ..BvhBuildParams::very_slow_build()
};

/// Above this number of boxes, the build tries to reinsert only one node in ten. Trees of a million
/// spheres and of a million triangles were built 4 times faster and traced as fast (`profiling/`).
const MANY: usize = 1 << 15;

/// Number of subtrees of each cluster over which the tree of a large scene is built. They, and not the
/// clusters, because the box of a cluster can be large on account of a few primitives. With 16 times
/// as many, rays visited as many nodes (`profiling/`).
const LARGEST: usize = 256;

impl BinaryTree {
    /// Size in memory.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.nodes)
    }

    /// Builds the tree over `primitives`, whose boxes are `boxes[primitive]`. The tree does not
    /// depend on the number of `threads` that build it.
    pub(crate) fn new(boxes: &[Bounds], primitives: &[u32], threads: usize) -> Self {
        if primitives.len() <= MAX_CLUSTER {
            return Self::of_cluster(boxes, primitives);
        }
        let clusters = clusters(boxes, primitives.to_vec(), MAX_CLUSTER, threads);
        let trees = map(threads, clusters, |primitives| Self::of_cluster(boxes, &primitives));
        // The tree over the largest subtrees of all clusters, each of which then takes the place of
        // the leaf that stands for it.
        let roots: Vec<(&Self, u32)> = trees
            .iter()
            .flat_map(|tree| tree.largest().into_iter().map(move |at| (tree, at)))
            .collect();
        let root_boxes: Vec<Bounds> =
            roots.iter().map(|(tree, at)| tree.nodes[*at as usize].bounds).collect();
        let all: Vec<u32> = (0..roots.len() as u32).collect();
        let mut tree = Self::of_cluster(&root_boxes, &all);
        tree.nodes.reserve_exact(2 * primitives.len() - 1 - tree.nodes.len());
        for slot in 0..tree.nodes.len() {
            if let Below::Primitive(root) = tree.nodes[slot].below {
                let (of, at) = roots[root as usize];
                tree.copy(slot, of, at);
            }
        }
        tree
    }

    /// Replaces the node `slot` by the subtree of `of` from node `at` on.
    fn copy(&mut self, slot: usize, of: &Self, at: u32) {
        let mut open = vec![(slot, at)];
        while let Some((slot, at)) = open.pop() {
            self.nodes[slot] = of.nodes[at as usize];
            if let Below::Children(first) = of.nodes[at as usize].below {
                let children = self.nodes.len();
                self.nodes[slot].below = Below::Children(children as u32);
                self.nodes.extend([BinaryNode::UNKNOWN; 2]);
                open.extend([(children + 1, first + 1), (children, first)]);
            }
        }
    }

    /// The [`LARGEST`] subtrees with the largest boxes, which together have all primitives. Those of
    /// one primitive count as well.
    pub(super) fn largest(&self) -> Vec<u32> {
        let largest_first = |node: u32| {
            // The bits of numbers that are not negative order like the numbers.
            (self.nodes[node as usize].bounds.half_area().to_bits(), Reverse(node))
        };
        let (mut open, mut done) = (BinaryHeap::from([largest_first(0)]), Vec::new());
        while open.len() + done.len() < LARGEST
            && let Some((_, Reverse(node))) = open.pop()
        {
            match self.nodes[node as usize].below {
                Below::Primitive(_) => done.push(node),
                Below::Children(first) => open.extend([first, first + 1].map(largest_first)),
            }
        }
        done.extend(open.into_iter().map(|(_, Reverse(node))| node));
        done.sort_unstable();
        done
    }

    /// Builds a tree without dividing the primitives into clusters first.
    pub(super) fn of_cluster(boxes: &[Bounds], primitives: &[u32]) -> Self {
        if primitives.is_empty() {
            return Self::default();
        }
        let groups = Concentric::new(boxes, primitives);
        let union_of = |members: &[u32]| {
            members.iter().fold(Bounds::EMPTY, |union, &p| union.union(boxes[p as usize]))
        };
        let group_boxes: Vec<Aabb> = (0..groups.len())
            .map(|group| unequal(group, union_of(groups.members(group))))
            .collect();
        let many = group_boxes.len() > MANY;
        let reinsertion_batch_ratio = if many { 0.1 } else { BUILD.reinsertion_batch_ratio };
        let build = BvhBuildParams { reinsertion_batch_ratio, ..BUILD };
        let built = build_bvh2(&group_boxes, build, &mut Duration::default());

        let mut nodes = Vec::with_capacity(2 * primitives.len() - 1);
        nodes.push(BinaryNode::UNKNOWN);
        let mut open = vec![(0, Subtree::Built(0))];
        while let Some((slot, subtree)) = open.pop() {
            let (left, right) = match subtree.resolve(&built, &groups) {
                Subtree::Crowd(&[primitive]) => {
                    let bounds = boxes[primitive as usize].without_subnormals();
                    nodes[slot] = BinaryNode { bounds, below: Below::Primitive(primitive) };
                    continue;
                }
                Subtree::Crowd(members) => {
                    let (left, right) = members.split_at(members.len() / 2);
                    (Subtree::Crowd(left), Subtree::Crowd(right))
                }
                Subtree::Built(index) => {
                    let first = built.nodes[index as usize].first_index;
                    (Subtree::Built(first), Subtree::Built(first + 1))
                }
            };
            let children = nodes.len();
            nodes[slot].below = Below::Children(children as u32);
            nodes.extend([BinaryNode::UNKNOWN; 2]);
            open.push((children + 1, right));
            open.push((children, left));
        }
        for index in (0..nodes.len()).rev() {
            if let Below::Children(first) = nodes[index].below {
                let [left, right] = [first, first + 1].map(|child| nodes[child as usize].bounds);
                nodes[index].bounds = left.union(right);
            }
        }
        Self { nodes }
    }

    /// Decides for each subtree whether it should be a leaf. It should if it holds at most `most`
    /// primitives, all of one kind, and testing them is expected to cost no more than visiting its
    /// nodes. A visit of a node costs as much as `node_cost` tests.
    pub(crate) fn leaves<K: Copy + PartialEq>(
        &self,
        node_cost: f32,
        most: u32,
        kind_of: impl Fn(u32) -> K,
    ) -> Vec<bool> {
        let mut leaf = vec![true; self.nodes.len()];
        // Cost, number of primitives, and their kind if they share one.
        let mut subtrees: Vec<(f32, u32, Option<K>)> = vec![(0.0, 0, None); self.nodes.len()];
        for (index, node) in self.nodes.iter().enumerate().rev() {
            let area = node.bounds.half_area();
            subtrees[index] = match node.below {
                Below::Primitive(primitive) => (area, 1, Some(kind_of(primitive))),
                Below::Children(first) => {
                    let [left, right] = [first, first + 1].map(|child| subtrees[child as usize]);
                    let count = left.1 + right.1;
                    let kind = left.2.filter(|_| left.2 == right.2);
                    let as_node = area * node_cost + left.0 + right.0;
                    let as_leaf = area * count as f32;
                    leaf[index] = kind.is_some() && count <= most && as_leaf <= as_node;
                    (if leaf[index] { as_leaf } else { as_node }, count, kind)
                }
            };
        }
        leaf
    }

    /// Returns the primitives below node `index`.
    pub(crate) fn primitives(&self, index: u32) -> Vec<u32> {
        let (mut primitives, mut open) = (Vec::new(), vec![index]);
        while let Some(index) = open.pop() {
            match self.nodes[index as usize].below {
                Below::Primitive(primitive) => primitives.push(primitive),
                Below::Children(first) => open.extend([first + 1, first]),
            }
        }
        primitives
    }
}

impl BinaryNode {
    const UNKNOWN: Self = Self { bounds: Bounds::EMPTY, below: Below::Primitive(u32::MAX) };
}

/// A part of the tree yet to be copied: a node of the builder, or some members of a group.
#[derive(Clone, Copy)]
enum Subtree<'a> {
    Built(u32),
    Crowd(&'a [u32]),
}

impl<'a> Subtree<'a> {
    /// Replaces a leaf of the builder with the members of its group, usually a single primitive.
    fn resolve(self, built: &Bvh2, groups: &'a Concentric) -> Self {
        match self {
            Self::Built(index) if built.nodes[index as usize].prim_count > 0 => {
                let first = built.nodes[index as usize].first_index;
                let group = built.primitive_indices[first as usize];
                Self::Crowd(groups.members(group as usize))
            }
            other => other,
        }
    }
}

/// Returns a box slightly larger than `b`, by an amount that depends on `index`.
///
/// obvhs merges boxes that are each other's nearest (PLOC). Among equally near boxes, as in a row
/// of equal spheres, it finds only few pairs in each round and takes quadratic time: rows of 4000,
/// 8000 and 16 000 spheres took 0.2, 0.6 and 1.7 s.
fn unequal(index: usize, b: Bounds) -> Aabb {
    let random = Stream::new(index as u64).uniform();
    let margin = (b.max - b.min) * (1e-4 * random);
    let b = Bounds { min: b.min - margin, max: b.max + margin }.widened((random * 8.0) as u32);
    Aabb { min: b.min.into(), max: b.max.into() }
}
