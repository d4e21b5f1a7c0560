//! Wide trees for beams and single rays, collapsed from the binary tree: a node has up to [`LANES`]
//! children.

use std::collections::BTreeMap;
use std::mem::take;
use std::sync::Mutex;

use super::binary::{Below, BinaryTree};
use super::collapse::Collapse;
use super::partition::{MAX_CLUSTER, Partition};
use crate::accel::leaf::{BlockRef, Blocks};
use crate::accel::threads::{for_each, map};
use crate::geometry::{Bounds, Geometry, Shape};
use crate::huge_pages::{reserve, settle};
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
#[derive(Clone, Debug, Default)]
pub(crate) struct WideTree {
    /// The root is first. Empty if the tree has no primitives.
    pub(crate) nodes: Vec<WideNode>,
    pub(crate) blocks: Blocks,
    /// Upper bound of the number of nodes on a path from the root.
    pub(crate) depth: usize,
    /// Whether the tree is larger than the fast caches.
    pub(crate) is_large: bool,
    /// Whether single rays take turns while they wait for their blocks. This pays for triangles,
    /// whose blocks are long and of which a ray meets only few, but not for spheres (`profiling/`).
    pub(crate) in_turn: bool,
    /// The trees of the meshes that instances place. Their blocks count primitives from the first
    /// triangle of all meshes.
    pub(crate) meshes: Vec<WideTree>,
    /// The number of that triangle among all primitives.
    pub(crate) first: u32,
}

/// Size in bytes above which a tree is larger than the fast caches.
const LARGE: usize = 1 << 20;

/// A part of a wide tree, whose references count from its own first node and block.
#[derive(Debug, Default)]
struct Part {
    nodes: Vec<WideNode>,
    blocks: Blocks,
    /// Number of nodes on the longest path from its root.
    depth: usize,
    /// For each subtree that stands for another part: the node and the lane that refer to it, and
    /// the number of the part.
    parts: Vec<(usize, usize, u32)>,
}

impl Part {
    /// Lays out `tree`, which is not empty.
    ///
    /// Neighbouring leaves of one shape share a block if they fit. Each leaf has its own
    /// box, and a visit of one of them visits them all. Sharing blocks halves the memory for a
    /// million spheres (`profiling/`).
    fn new(geometry: &Geometry, tree: &BinaryTree, collapse: &Collapse<'_>) -> Self {
        let mut part = Self::default();
        part.nodes.push(WideNode::EMPTY);
        let mut open = vec![(0, 0, 1)];
        let mut children = Vec::new();
        while let Some((slot, index, depth)) = open.pop() {
            part.depth = part.depth.max(depth);
            children.clear();
            collapse.children(index, &mut children);
            let mut lane = 0;
            for run in collapse.runs(&children) {
                let child = match tree.nodes[run[0] as usize].below {
                    _ if collapse.is_leaf(run[0]) => {
                        let leaves = run.iter().flat_map(|&leaf| tree.primitives(leaf));
                        let mut primitives: Vec<u32> = leaves.collect();
                        part.blocks.push(geometry, &mut primitives).bits()
                    }
                    Below::Primitive(number) => {
                        part.parts.push((slot, lane, number));
                        0
                    }
                    Below::Children(_) => {
                        let below = part.nodes.len();
                        part.nodes.push(WideNode::EMPTY);
                        open.push((below, run[0], depth + 1));
                        below as u32
                    }
                };
                for &index in run {
                    let bounds = &tree.nodes[index as usize].bounds;
                    part.nodes[slot].set(lane, bounds, child);
                    lane += 1;
                }
            }
        }
        part
    }

    /// Appends a part. Returns the index of its root.
    fn append(&mut self, mut part: Self) -> u32 {
        let (first, blocks) = (self.nodes.len() as u32, self.blocks.counts());
        reserve(&mut self.nodes, part.nodes.len());
        self.nodes.extend(part.nodes.drain(..).map(|node| {
            let children = node.children.map(|child| match child & BlockRef::LEAF {
                0 => child + first,
                _ => BlockRef::from_bits(child).moved(&blocks).bits(),
            });
            WideNode { children, ..node }
        }));
        self.blocks.append(part.blocks);
        first
    }
}

/// The parts of a wide tree, which are appended in order, whatever the order in which they are
/// finished.
struct Assembly {
    tree: Part,
    /// Finished parts that come after unfinished ones.
    waiting: BTreeMap<usize, Part>,
    /// The root and the depth of each appended part.
    roots: Vec<(u32, usize)>,
}

impl Assembly {
    fn add(&mut self, number: usize, part: Part) {
        self.waiting.insert(number, part);
        while let Some(part) = self.waiting.remove(&self.roots.len()) {
            let depth = part.depth;
            self.roots.push((self.tree.append(part), depth));
        }
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
        let partition = Partition::new(boxes, elements, threads);
        Self::of_clusters(geometry, boxes, &partition, threads)
    }

    /// Builds the trees of the meshes that instances of `geometry` place.
    pub(crate) fn with_meshes(mut self, geometry: &Geometry, threads: usize) -> Self {
        let instances = &geometry.instances;
        let triangles = instances.triangles();
        let boxes = triangles.boxes();
        // Many meshes are built at once, and few by all threads each.
        let meshes: Vec<usize> = (0..instances.meshes()).collect();
        let (at_once, each) = if meshes.len() < 4 * threads { (1, threads) } else { (threads, 1) };
        let build =
            |mesh: usize| Self::over(triangles, &boxes, instances.range(mesh).collect(), each);
        self.first = geometry.len() as u32;
        self.meshes = map(at_once, meshes, build);
        self
    }

    /// Lays out `tree`.
    pub(crate) fn new(geometry: &Geometry, tree: &BinaryTree) -> Self {
        let mut all = Part::default();
        if !tree.nodes.is_empty() {
            all = Part::new(geometry, tree, &Collapse::new(geometry, tree));
            all.nodes = settle(all.nodes);
            all.blocks.settle();
        }
        Self::of(all)
    }

    /// Builds the tree over the clusters of a large scene. The binary tree of the scene is never in
    /// memory as a whole. `boxes` has the box of each primitive.
    pub(crate) fn of_clusters(
        geometry: &Geometry,
        boxes: &[Bounds],
        partition: &Partition,
        threads: usize,
    ) -> Self {
        let clusters = &partition.clusters;
        let top = BinaryTree::top(partition, |cluster| {
            let boxes = clusters[cluster].iter().map(|&primitive| boxes[primitive as usize]);
            boxes.fold(Bounds::EMPTY, Bounds::union).without_subnormals()
        });
        let mut tree = Part::new(geometry, &top, &Collapse::of_roots(&top));
        let parts = take(&mut tree.parts);
        let assembly = Mutex::new(Assembly { tree, waiting: BTreeMap::new(), roots: Vec::new() });
        for_each(threads, clusters.iter().enumerate().collect(), |(number, primitives)| {
            let tree = BinaryTree::of_cluster(boxes, primitives);
            let part = Part::new(geometry, &tree, &Collapse::new(geometry, &tree));
            assembly.lock().expect("no thread panicked").add(number, part);
        });
        let Assembly { mut tree, roots, .. } = assembly.into_inner().expect("no thread panicked");
        let mut below = 0;
        for (slot, lane, number) in parts {
            let (root, depth) = roots[number as usize];
            tree.nodes[slot].children[lane] = root;
            below = below.max(depth);
        }
        tree.depth += below;
        Self::of(tree)
    }

    fn of(Part { nodes, blocks, depth, .. }: Part) -> Self {
        let bytes = size_of_val(&*nodes) + blocks.bytes();
        let is_large = bytes > LARGE;
        let in_turn = is_large && 2 * blocks.count(Shape::Triangle) > blocks.len();
        Self { nodes, blocks, depth, is_large, in_turn, meshes: Vec::new(), first: 0 }
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
        let build = |threads| {
            let partition = Partition::new(&boxes, all.clone(), threads);
            WideTree::of_clusters(&geometry, &boxes, &partition, threads)
        };
        let (one, many) = (build(1), build(3));
        assert!(one.depth > 2 && one.nodes.len() > 1000);
        assert_eq!((one.depth, one.nodes.len()), (many.depth, many.nodes.len()));
        for (a, b) in one.nodes.iter().zip(&many.nodes) {
            assert_eq!((a.planes, a.children), (b.planes, b.children));
        }
        assert_eq!(format!("{:?}", one.blocks), format!("{:?}", many.blocks));
    }
}
