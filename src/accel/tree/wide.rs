//! Wide trees for beams and streams, collapsed from the binary tree: a node has up to [`LANES`]
//! children.

use std::collections::BTreeMap;
use std::mem::take;
use std::sync::{Arc, Mutex};

use super::binary::{Below, BinaryNode, BinaryTree, LeafContent};
use super::collapse::Collapse;
use super::partition::{MAX_CLUSTER, clusters};
use crate::accel::leaf::{LeafBlocks, LeafRef};
use crate::accel::threads::{for_each, map};
use crate::geometry::{Bounds, Geometry};
use crate::huge_pages::{reserve, settle};
use crate::simd::{LANES, Lanes, prefetch};

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

    fn set(&mut self, lane: usize, bounds: &Bounds, child: u32) {
        for axis in 0..3 {
            let [low, high] = &mut self.planes[axis];
            (low[lane], high[lane]) = (bounds.min[axis], bounds.max[axis]);
        }
        self.children[lane] = child;
    }
}

/// A tree of wide nodes over blocks.
#[derive(Clone, Debug, Default)]
pub(crate) struct WideTree {
    /// The root is first. Empty if the tree has no primitives.
    pub(crate) nodes: Vec<WideNode>,
    pub(crate) blocks: LeafBlocks,
    /// Upper bound of the number of nodes on a path from the root.
    pub(crate) depth: usize,
    /// Whether the tree is larger than the fast caches.
    pub(crate) is_large: bool,
    /// The trees of the meshes that instances place. Their blocks count primitives from the first
    /// triangle of all meshes.
    pub(crate) meshes: Vec<WideTree>,
    /// The number of that triangle among all primitives.
    pub(crate) first: u32,
    /// The geometry, if its triangles or those of the meshes may have holes.
    pub(crate) holes: Option<Arc<Geometry>>,
}

/// Size in bytes above which a tree is larger than the fast caches.
const LARGE: usize = 1 << 20;

/// A part of a wide tree, whose references count from its own first node and block.
#[derive(Debug, Default)]
struct Subtree {
    nodes: Vec<WideNode>,
    blocks: LeafBlocks,
    /// Number of nodes on the longest path to a node.
    depth: usize,
}

impl Subtree {
    /// Lays out the subtree of `tree` from node `root` on. Its wide node becomes `slot`. `element`
    /// returns what a leaf stands for.
    ///
    /// Neighbouring leaves of one shape share a block if they fit. Each leaf has its own
    /// box, and a visit of one of them visits them all. Sharing blocks halves the memory for a
    /// million spheres (`profiling/`).
    fn lay_out(
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
    fn push(&mut self) -> usize {
        self.nodes.push(WideNode::EMPTY);
        self.nodes.len() - 1
    }

    /// Appends a part. `growth` estimates the ratio of the final size to the size after this call.
    /// Returns the index of the part's first node.
    fn append(&mut self, mut part: Self, growth: f64) -> u32 {
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

/// The layout of a cluster: its largest subtrees and its primitives outside them, with their boxes.
/// Each subtree begins with a node of its own.
struct Cluster {
    part: Subtree,
    /// Number of primitives.
    primitives: usize,
    elements: Vec<(LeafContent, Bounds)>,
}

impl Cluster {
    fn new(geometry: &Geometry, tree: &BinaryTree) -> Self {
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
struct Assembly {
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
    fn new(total: usize) -> Self {
        let mut tree = Subtree::default();
        tree.push();
        let (elements, waiting) = (Vec::new(), BTreeMap::new());
        Self { tree, elements, appended: 0, primitives: 0, total, waiting }
    }

    fn add(&mut self, number: usize, cluster: Cluster) {
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
    fn finish(self, geometry: &Geometry) -> Subtree {
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

impl WideTree {
    /// Builds the tree over `elements`, whose boxes are `boxes[element]`.
    pub(crate) fn over(
        geometry: &Geometry,
        boxes: &[Bounds],
        elements: Vec<u32>,
        threads: usize,
    ) -> Self {
        if elements.len() <= MAX_CLUSTER {
            return Self::new(geometry, &BinaryTree::new(boxes, &elements, threads));
        }
        Self::of_clusters(geometry, boxes, elements, threads)
    }

    /// Builds the trees of the meshes that instances of `geometry` place.
    pub(crate) fn with_meshes(mut self, geometry: &Arc<Geometry>, threads: usize) -> Self {
        self.holes = geometry.may_have_holes().then(|| Arc::clone(geometry));
        let instances = &geometry.instances;
        let triangles = instances.triangles();
        let boxes = triangles.boxes();
        let build = |mesh: usize, threads: usize| {
            (mesh, Self::over(triangles, &boxes, instances.range(mesh).collect(), threads))
        };
        // Large meshes use all threads each if they are few. All others are built at once.
        let is_small = |&mesh: &usize| instances.range(mesh).len() <= MAX_CLUSTER;
        let (small, large): (Vec<_>, Vec<_>) = (0..instances.meshes()).partition(is_small);
        let (at_once, each) = if large.len() < threads { (1, threads) } else { (threads, 1) };
        let mut trees = map(at_once, large, |mesh| build(mesh, each));
        trees.extend(map(threads, small, |mesh| build(mesh, 1)));
        trees.sort_unstable_by_key(|&(mesh, _)| mesh);
        self.first = geometry.len() as u32;
        self.meshes = trees.into_iter().map(|(_, tree)| tree).collect();
        self
    }

    /// Whether the tree has neither instances nor holes.
    pub(crate) fn is_plain(&self) -> bool {
        self.meshes.is_empty() && self.holes.is_none()
    }

    /// Lays out `tree`.
    pub(crate) fn new(geometry: &Geometry, tree: &BinaryTree) -> Self {
        let mut all = Subtree::default();
        if !tree.nodes.is_empty() {
            let collapse = Collapse::new(geometry, tree, LeafContent::Primitive);
            let root = all.push();
            all.lay_out(geometry, &collapse, root, 0, LeafContent::Primitive);
            all.nodes = settle(all.nodes);
            all.blocks.settle();
        }
        Self::of(all)
    }

    /// Builds the tree of a large scene cluster by cluster. The binary tree of the scene is never in
    /// memory as a whole. `boxes` has the box of each primitive.
    pub(crate) fn of_clusters(
        geometry: &Geometry,
        boxes: &[Bounds],
        primitives: Vec<u32>,
        threads: usize,
    ) -> Self {
        let assembly = Mutex::new(Assembly::new(primitives.len()));
        let clusters = clusters(boxes, primitives, threads);
        for_each(threads, clusters.iter().enumerate().collect(), |(number, primitives)| {
            let cluster = Cluster::new(geometry, &BinaryTree::of_cluster(boxes, primitives));
            assembly.lock().expect("no thread panicked").add(number, cluster);
        });
        Self::of(assembly.into_inner().expect("no thread panicked").finish(geometry))
    }

    fn of(Subtree { nodes, blocks, depth }: Subtree) -> Self {
        let bytes = size_of_val(&*nodes) + blocks.bytes();
        let is_large = bytes > LARGE;
        Self { nodes, blocks, depth, is_large, meshes: Vec::new(), first: 0, holes: None }
    }

    /// Prefetches a node or a block.
    #[inline(always)]
    pub(crate) fn prefetch(&self, next: u32) {
        if next & LeafRef::LEAF == 0 {
            prefetch(&self.nodes[next as usize]);
        } else {
            self.blocks.prefetch(LeafRef::from_bits(next));
        }
    }

    /// Size in memory.
    pub(crate) fn bytes(&self) -> usize {
        let meshes: usize = self.meshes.iter().map(Self::bytes).sum();
        size_of_val(&*self.nodes) + self.blocks.bytes() + meshes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Sphere;
    use crate::math::random::Stream;
    use glam::Vec3;

    #[test]
    fn any_number_of_threads_builds_the_same_tree() {
        let mut random = Stream::new(31);
        let mut sphere = || {
            let center = Vec3::from_array([(); 3].map(|()| random.between(-1.0, 1.0)));
            Sphere::still(center, 1e-3)
        };
        let spheres = (0..3 * MAX_CLUSTER).map(|_| sphere()).collect();
        let geometry = Geometry { spheres, ..Geometry::default() };
        let boxes = geometry.boxes();
        let all: Vec<u32> = (0..geometry.len() as u32).collect();
        let build = |threads| WideTree::of_clusters(&geometry, &boxes, all.clone(), threads);
        let (one, many) = (build(1), build(3));
        assert!(one.depth > 2 && one.nodes.len() > 1000);
        assert_eq!((one.depth, one.nodes.len()), (many.depth, many.nodes.len()));
        for (a, b) in one.nodes.iter().zip(&many.nodes) {
            assert_eq!((a.planes, a.children), (b.planes, b.children));
        }
        assert_eq!(format!("{:?}", one.blocks), format!("{:?}", many.blocks));
    }
}
