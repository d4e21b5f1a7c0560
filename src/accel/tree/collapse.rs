//! Chooses the subtrees of the binary tree that become children of a wide node, and those that
//! become leaves.
//!
//! Both are chosen together by dynamic programming over the surface area cost (Ylitie, Karras,
//! Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs",
//! section 3). A leaf holds primitives of one shape, at most a block of them.

use super::binary::{Below, BinaryTree, LeafContent};
use crate::geometry::{Geometry, Shape};
use crate::math::min;
use crate::simd::LANES;

/// Largest number of a node's child slots that one subtree can take. Its sibling takes at least
/// one.
const SHARES: usize = LANES - 1;

/// The cheapest division of a tree into wide nodes.
pub(crate) struct Collapse<'a> {
    tree: &'a BinaryTree,
    subtrees: Vec<Subtree>,
}

/// The cheapest division of a subtree.
#[derive(Clone, Copy)]
struct Subtree {
    /// `costs[i]` is the least cost if the subtree takes up to i + 1 child slots of a node above
    /// it.
    costs: [f32; SHARES],
    /// Number of primitives.
    count: u32,
    /// Shape of the primitives, if they share one.
    kind: Option<Shape>,
    is_leaf: bool,
}

impl<'a> Collapse<'a> {
    /// Finds the division of a tree over `geometry`. `element` returns what a leaf stands for.
    pub(crate) fn new(
        geometry: &Geometry,
        tree: &'a BinaryTree,
        element: impl Fn(u32) -> LeafContent,
    ) -> Self {
        let leaf = |number: u32, costs: [f32; SHARES]| match element(number) {
            LeafContent::Primitive(primitive) => {
                let kind = Some(geometry.shape(primitive));
                Subtree { costs, count: 1, kind, is_leaf: true }
            }
            LeafContent::Node(_) => {
                Subtree { costs, count: LANES as u32 + 1, kind: None, is_leaf: false }
            }
        };
        let unknown = Subtree { costs: [0.0; SHARES], count: 0, kind: None, is_leaf: false };
        let mut collapse = Self { tree, subtrees: vec![unknown; tree.nodes.len()] };
        for (index, node) in tree.nodes.iter().enumerate().rev() {
            let area = node.bounds.half_area();
            collapse.subtrees[index] = match node.below {
                Below::Primitive(primitive) => leaf(primitive, [area; SHARES]),
                Below::Children(first) => collapse.join(first, area),
            };
        }
        // The root always becomes a node. If it has a single primitive, it is also its own only
        // child and a leaf.
        if let Some(root) = collapse.subtrees.first_mut() {
            root.is_leaf = root.count == 1;
        }
        collapse
    }

    /// Finds the cheapest division of a subtree from the divisions of its two children. `area` is
    /// half the surface area of its box.
    fn join(&self, first: u32, area: f32) -> Subtree {
        let [left, right] = self.siblings(first);
        let count = left.count + right.count;
        let kind = left.kind.filter(|_| left.kind == right.kind);
        let is_leaf = kind.is_some() && count <= LANES as u32;
        // A visit costs the same for a node and for a leaf, whether or not the leaf shares its
        // block. Other costs brought no speedup (`profiling/lost.md`).
        let mut costs = [area + if is_leaf { 0.0 } else { self.split(first, LANES).0 }; SHARES];
        for shares in 2..=SHARES {
            let least = costs[shares - 2];
            let splits = shares <= count as usize;
            costs[shares - 1] =
                if splits { min(least, self.split(first, shares).0) } else { least };
        }
        Subtree { costs, count, kind, is_leaf }
    }

    fn siblings(&self, first: u32) -> [&Subtree; 2] {
        [&self.subtrees[first as usize], &self.subtrees[first as usize + 1]]
    }

    pub(crate) fn tree(&self) -> &'a BinaryTree {
        self.tree
    }

    pub(crate) fn is_leaf(&self, index: u32) -> bool {
        self.subtrees[index as usize].is_leaf
    }

    /// Returns the least cost of two siblings that together take up to `shares` child slots, and
    /// the number of slots that the first takes.
    fn split(&self, first: u32, shares: usize) -> (f32, usize) {
        let [left, right] = self.siblings(first);
        let most = (left.count as usize).min(shares - 1);
        let fewest = shares.saturating_sub(right.count as usize).clamp(1, most);
        (fewest..=most).map(|l| (left.costs[l - 1] + right.costs[shares - l - 1], l)).fold(
            (f32::INFINITY, fewest),
            |best, split| if split.0 < best.0 { split } else { best },
        )
    }

    /// Appends the subtrees that are the children of node `index`, in the order of the tree, so
    /// that neighbours in space are adjacent.
    pub(crate) fn children(&self, index: u32, children: &mut Vec<u32>) {
        match self.tree.nodes[index as usize].below {
            Below::Children(first) => self.share(first, LANES, children),
            Below::Primitive(_) => children.push(index),
        }
    }

    fn share(&self, first: u32, shares: usize, children: &mut Vec<u32>) {
        let (_, left) = self.split(first, shares);
        self.take(first, left, children);
        self.take(first + 1, shares - left, children);
    }

    /// Appends the subtrees that replace `index` if it takes up to `shares` child slots.
    fn take(&self, index: u32, shares: usize, children: &mut Vec<u32>) {
        let costs = &self.subtrees[index as usize].costs;
        // Take the fewest slots that give the same cost.
        let shares = (1..=shares).find(|s| costs[s - 1] == costs[shares - 1]).unwrap_or(shares);
        match self.tree.nodes[index as usize].below {
            Below::Children(first) if shares > 1 => self.share(first, shares, children),
            _ => children.push(index),
        }
    }

    /// Splits a node's children into runs. An inner node is a run of its own; a run of leaves
    /// contains as many adjacent ones of the same shape as fit into a block.
    pub(crate) fn runs<'c>(&'c self, children: &'c [u32]) -> impl Iterator<Item = &'c [u32]> {
        let subtree = |child: u32| &self.subtrees[child as usize];
        // Number of primitives in the current run. `chunk_by` compares neighbours in order.
        let mut filled = children.first().map_or(0, |&child| subtree(child).count);
        children.chunk_by(move |&before, &child| {
            let (before, child) = (subtree(before), subtree(child));
            let both_leaves = before.is_leaf && child.is_leaf;
            let together = filled.saturating_add(child.count) <= LANES as u32;
            let same = both_leaves && before.kind == child.kind && together;
            filled = child.count + if same { filled } else { 0 };
            same
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Quad, Shape, Sphere};
    use crate::math::Stream;
    use glam::Vec3;

    /// Quads, still spheres and moving spheres, close together.
    fn mixture(spheres: usize, quads: usize) -> Geometry {
        let mut random = Stream::new(14);
        let mut point = || Vec3::from_array([(); 3].map(|()| random.between(-1.0, 1.0)));
        let quad = |q: Vec3| Quad::new(q, Vec3::X * 0.1, Vec3::Y * 0.1).expect("a quad");
        let sphere = |i: usize, center: Vec3| Sphere {
            center1: center + Vec3::X * if i.is_multiple_of(3) { 0.1 } else { 0.0 },
            ..Sphere::still(center, 0.05)
        };
        let spheres = (0..spheres).map(|i| sphere(i, point())).collect();
        let quads = (0..quads).map(|_| quad(point())).collect();
        Geometry { spheres, quads, ..Geometry::default() }
    }

    #[test]
    fn children_hold_all_and_leaves_share_blocks() {
        for (spheres, quads) in [(1, 0), (2, 0), (0, 40), (500, 100), (3, 3)] {
            let geometry = mixture(spheres, quads);
            let all: Vec<u32> = (0..geometry.len() as u32).collect();
            let boxes: Vec<_> = all.iter().map(|&p| geometry.get(p).bounds()).collect();
            let tree = BinaryTree::new(&boxes, &all, 1);
            let collapse = Collapse::new(&geometry, &tree, LeafContent::Primitive);
            let kind_of = |leaf: u32| {
                let mut kinds: Vec<Shape> =
                    tree.primitives(leaf).iter().map(|&p| geometry.get(p).shape()).collect();
                kinds.dedup();
                assert_eq!(kinds.len(), 1);
                kinds[0]
            };
            let size_of = |run: &[u32]| -> usize {
                run.iter().map(|&child| tree.primitives(child).len()).sum()
            };

            let (mut open, mut held, mut children) = (vec![0], Vec::new(), Vec::new());
            while let Some(node) = open.pop() {
                children.clear();
                collapse.children(node, &mut children);
                assert!((1..=LANES).contains(&children.len()));
                let runs: Vec<&[u32]> = collapse.runs(&children).collect();
                assert_eq!(runs.concat(), children);
                for run in &runs {
                    if !collapse.is_leaf(run[0]) {
                        assert_eq!(run.len(), 1);
                        open.push(run[0]);
                        continue;
                    }
                    assert!(size_of(run) <= LANES);
                    for &leaf in *run {
                        assert!(collapse.is_leaf(leaf) && kind_of(leaf) == kind_of(run[0]));
                        held.extend(tree.primitives(leaf));
                    }
                }
                for pair in runs.windows(2) {
                    let [run, next] = [pair[0], pair[1]];
                    let both = collapse.is_leaf(run[0]) && collapse.is_leaf(next[0]);
                    let fits = size_of(run) + size_of(&next[..1]) <= LANES;
                    assert!(!(both && fits && kind_of(run[0]) == kind_of(next[0])));
                }
            }
            held.sort_unstable();
            assert_eq!(held, all);
        }
    }
}
