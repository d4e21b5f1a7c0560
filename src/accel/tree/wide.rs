//! Wide trees for beams and streams, collapsed from the binary tree: a node has up to [`LANES`](crate::simd::LANES)
//! children.

use std::sync::{Arc, Mutex};

use super::assembly::{Assembly, Cluster};
use super::binary::{BinaryTree, LeafContent};
use super::binned;
use super::collapse::Collapse;
use super::partition::{MAX_CLUSTER, clusters};
use super::subtree::Subtree;
pub(crate) use super::subtree::WideNode;
use crate::accel::threads::{for_each, map};
use crate::accel::{LeafBlocks, LeafRef, TreeQuality};
use crate::geometry::{Bounds, Geometry};
use crate::huge_pages::settle;
use crate::simd::prefetch;

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

/// Largest number of primitives in a cluster of a tree that is built fast.
const FAST_CLUSTER: usize = 1 << 16;

/// Size in bytes above which a tree is larger than the fast caches.
const LARGE: usize = 1 << 20;

impl WideTree {
    /// Builds the tree over `elements`, whose boxes are `boxes[element]`.
    pub(crate) fn over(
        geometry: &Geometry,
        boxes: &[Bounds],
        elements: Vec<u32>,
        quality: TreeQuality,
        threads: usize,
    ) -> Self {
        if elements.len() <= MAX_CLUSTER && quality == TreeQuality::Best {
            return Self::new(geometry, &BinaryTree::new(boxes, &elements, threads));
        }
        Self::of_clusters(geometry, boxes, elements, quality, threads)
    }

    /// Builds the trees of the meshes that instances of `geometry` place.
    pub(crate) fn with_meshes(
        mut self,
        geometry: &Arc<Geometry>,
        quality: TreeQuality,
        threads: usize,
    ) -> Self {
        self.holes = geometry.may_have_holes().then(|| Arc::clone(geometry));
        let instances = &geometry.instances;
        let triangles = instances.triangles();
        let boxes = triangles.boxes();
        let build = |mesh: usize, threads: usize| {
            let elements = instances.range(mesh).collect();
            (mesh, Self::over(triangles, &boxes, elements, quality, threads))
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
        quality: TreeQuality,
        threads: usize,
    ) -> Self {
        if primitives.is_empty() {
            return Self::of(Subtree::default());
        }
        let most = match quality {
            TreeQuality::Fast => FAST_CLUSTER,
            TreeQuality::Best => MAX_CLUSTER,
        };
        let assembly = Mutex::new(Assembly::new(primitives.len()));
        let clusters = clusters(boxes, primitives, most, threads);
        for_each(threads, clusters.iter().enumerate().collect(), |(number, primitives)| {
            let cluster = match quality {
                TreeQuality::Fast => binned::cluster(geometry, boxes, primitives),
                TreeQuality::Best => {
                    Cluster::new(geometry, &BinaryTree::of_cluster(boxes, primitives))
                }
            };
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
    use crate::math::Stream;
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
        let build = |quality, threads| {
            WideTree::of_clusters(&geometry, &boxes, all.clone(), quality, threads)
        };
        for quality in TreeQuality::ALL {
            let (one, many) = (build(quality, 1), build(quality, 3));
            assert!(one.depth > 2 && one.nodes.len() > 1000);
            assert_eq!((one.depth, one.nodes.len()), (many.depth, many.nodes.len()));
            for (a, b) in one.nodes.iter().zip(&many.nodes) {
                assert_eq!((a.planes, a.children), (b.planes, b.children));
            }
            assert_eq!(format!("{:?}", one.blocks), format!("{:?}", many.blocks));
        }
    }
}
