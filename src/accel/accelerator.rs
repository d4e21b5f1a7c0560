//! The acceleration structures of a scene, one layout for each kind of kernel.

use std::ops::Range;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Instant;

use super::kernel::Kernel;
use super::kernel::beam;
use super::kernel::flat::Flat;
use super::kernel::job::TraceJob;
use super::kernel::packet;
use super::kernel::stream;
use super::tree::binary::BinaryTree;
use super::tree::bvh2::Bvh2;
use super::tree::pair::PairTree;
use super::tree::partition::MAX_CLUSTER;
use super::tree::wide::WideTree;
use super::{Count, Counters, Extent, HitBatch, LeafBlocks, LeafRef, RayBatch, TreeQuality};
use crate::geometry::{Bounds, Geometry, Hit};
use crate::simd::LANES;

/// The acceleration structures of a scene's geometry, each built when it is first needed.
#[derive(Debug)]
pub struct Accelerator {
    pub(super) geometry: Arc<Geometry>,
    /// That of wide trees.
    quality: OnceLock<TreeQuality>,
    base: Lazy<Base>,
    tree: Lazy<BinaryTree>,
    scalar: Lazy<Bvh2>,
    wide: Lazy<WideTree>,
    pair: Lazy<PairTree>,
    flat: Lazy<Flat>,
}

/// The data from which the layouts of all vector kernels are built.
#[derive(Debug)]
pub(super) struct Base {
    /// The boxes of all primitives, until a tree over them is built.
    boxes: Mutex<Option<Vec<Bounds>>>,
    /// Bounding box of all primitives.
    all: Bounds,
    /// The primitives that do not span the scene, which are in the trees, and their bounding box.
    others: Vec<u32>,
    bounds: Bounds,
    /// The primitives that span the scene. Nearly every ray would enter their boxes, so rays are
    /// tested against them directly.
    pub(super) spanning: (LeafBlocks, Vec<LeafRef>),
    pub(super) extent: Extent,
}

/// Size and build time of the structures that a kernel needs.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Size in memory.
    pub bytes: usize,
    /// Build time. Structures that several kernels need are built once, but count for each.
    pub seconds: f64,
}

/// A layout that is built on first use, with its build time.
#[derive(Debug)]
struct Lazy<T>(OnceLock<(T, f64)>);

impl<T> Default for Lazy<T> {
    fn default() -> Self {
        Self(OnceLock::new())
    }
}

impl<T> Lazy<T> {
    fn get(&self, make: impl FnOnce() -> T) -> &T {
        let (layout, _) = self.0.get_or_init(|| {
            let start = Instant::now();
            (make(), start.elapsed().as_secs_f64())
        });
        layout
    }

    fn seconds(&self) -> f64 {
        self.0.get().map_or(0.0, |(_, seconds)| *seconds)
    }
}

/// Above this number of primitives, beams and rays on their own, which streams have replaced, were
/// faster than packets on every ray set.
const MOST_IN_PACKET_TREE: usize = 1 << 14;
/// Above this number of primitives, some kernel with a tree was faster than [`Kernel::Flat`] on
/// every ray set; with 256 spheres, [`Kernel::Flat`] is still faster on bounces.
const MOST_WITHOUT_TREE: usize = 512;

/// A primitive spans the scene if its box has at least this share of the surface area of the
/// scene's box.
const SPANNING_SHARE: f32 = 0.25;

impl Base {
    fn new(geometry: &Geometry) -> Self {
        let boxes = geometry.boxes();
        let all = boxes.iter().fold(Bounds::EMPTY, |union, b| union.union(*b));
        let (spanning, others) =
            spanning(&boxes, geometry.first_triangle() as u32, all.half_area());
        let union = |bounds: Bounds, &primitive: &u32| bounds.union(boxes[primitive as usize]);
        let bounds = others.iter().fold(Bounds::EMPTY, union).without_subnormals();
        let mut blocks = LeafBlocks::default();
        let references = blocks.push_all(geometry, &spanning);
        let extent = Extent::new(geometry, all, bounds);
        let boxes = Mutex::new(Some(boxes));
        Self { boxes, all, others, bounds, spanning: (blocks, references), extent }
    }
}

impl Accelerator {
    /// Creates the accelerator of `geometry`, without building a layout yet. The boxes of its trees
    /// contain each primitive over all times in `[0, 1]`.
    pub fn new(geometry: impl Into<Arc<Geometry>>) -> Self {
        Self {
            geometry: geometry.into(),
            quality: OnceLock::new(),
            base: Lazy::default(),
            tree: Lazy::default(),
            scalar: Lazy::default(),
            wide: Lazy::default(),
            pair: Lazy::default(),
            flat: Lazy::default(),
        }
    }

    pub(super) fn base(&self) -> &Base {
        self.base.get(|| Base::new(&self.geometry))
    }

    /// Sets the quality of wide trees, unless it is set or used already.
    pub fn set_quality(&self, quality: TreeQuality) {
        // It may have been set.
        let _ = self.quality.set(quality);
    }

    fn quality(&self) -> TreeQuality {
        *self.quality.get_or_init(TreeQuality::default)
    }

    /// Builds the layout that `kernel` needs, unless it exists already. For large scenes, `threads`
    /// threads build it.
    pub fn prepare(&self, kernel: Kernel, threads: usize) -> Layout {
        let base = self.base().spanning.0.bytes();
        let kernel = self.chosen(kernel);
        let (layout, seconds) = match kernel {
            Kernel::Packet => (self.pair(threads).bytes(), self.pair.seconds()),
            Kernel::Beam | Kernel::Stream => (self.wide(threads).bytes(), self.wide.seconds()),
            Kernel::Flat => {
                return Layout { bytes: self.flat().bytes(), seconds: self.flat.seconds() };
            }
            Kernel::Scalar => (self.scalar_by(threads).bytes(), self.scalar.seconds()),
        };
        let shares_tree = kernel == Kernel::Packet || kernel != Kernel::Scalar && !self.is_large();
        let (tree, tree_seconds) =
            if shares_tree { (self.tree(threads).bytes(), self.tree.seconds()) } else { (0, 0.0) };
        let seconds = self.base.seconds() + tree_seconds + seconds;
        Layout { bytes: base + tree + layout, seconds }
    }

    /// `kernel`, or what stands in for it in scenes with instances or holes.
    fn chosen(&self, kernel: Kernel) -> Kernel {
        match kernel {
            Kernel::Packet | Kernel::Flat
                if self.has_instances() || self.geometry.may_have_holes() =>
            {
                Kernel::Stream
            }
            other => other,
        }
    }

    /// Whether the wide tree is built from clusters instead of the binary tree.
    fn is_large(&self) -> bool {
        self.quality() == TreeQuality::Fast || self.base().others.len() > MAX_CLUSTER
    }

    /// Whether hits name instances.
    pub(crate) fn has_instances(&self) -> bool {
        !self.geometry.instances.is_empty()
    }

    /// Bounding box of the primitives that do not span the scene, or of all primitives if all of
    /// them span it.
    pub(crate) fn bounds(&self) -> Bounds {
        let Base { all, others, bounds, .. } = self.base();
        if others.is_empty() { *all } else { *bounds }
    }

    /// The boxes of all primitives.
    fn primitive_boxes(&self) -> Vec<Bounds> {
        let known = self.base().boxes.lock().unwrap_or_else(PoisonError::into_inner).take();
        known.unwrap_or_else(|| self.geometry.boxes())
    }

    /// The tree over all primitives except those that span the scene.
    fn tree(&self, threads: usize) -> &BinaryTree {
        let base = self.base();
        self.tree.get(|| BinaryTree::new(&self.primitive_boxes(), &base.others, threads))
    }

    /// Whether `kernel` may be the fastest for the number of primitives in this scene.
    pub fn may_win(&self, kernel: Kernel) -> bool {
        match kernel {
            _ if self.chosen(kernel) != kernel => false,
            Kernel::Packet => self.geometry.len() <= MOST_IN_PACKET_TREE,
            Kernel::Flat => self.geometry.len() <= MOST_WITHOUT_TREE,
            Kernel::Beam | Kernel::Stream => true,
            Kernel::Scalar => false,
        }
    }

    /// The tree of the scalar engine.
    pub fn scalar(&self) -> &Bvh2 {
        self.scalar_by(1)
    }

    /// The tree of the scalar engine, built by `threads` threads unless it exists already.
    fn scalar_by(&self, threads: usize) -> &Bvh2 {
        self.scalar.get(|| Bvh2::new(&self.geometry, threads))
    }

    pub(super) fn pair(&self, threads: usize) -> &PairTree {
        let (tree, extent) = (self.tree(threads), &self.base().extent);
        self.pair.get(|| PairTree::new(&self.geometry, tree, extent))
    }

    fn flat(&self) -> &Flat {
        let all = self.base().all;
        self.flat.get(|| Flat::new(&self.geometry, all))
    }

    fn wide(&self, threads: usize) -> &WideTree {
        let (geometry, quality) = (&self.geometry, self.quality());
        if !self.is_large() {
            let tree = self.tree(threads);
            return self
                .wide
                .get(|| WideTree::new(geometry, tree).with_meshes(geometry, quality, threads));
        }
        let others = &self.base().others;
        self.wide.get(|| {
            let boxes = self.primitive_boxes();
            let tree = WideTree::of_clusters(geometry, &boxes, others.clone(), quality, threads);
            tree.with_meshes(geometry, quality, threads)
        })
    }

    /// Finds the closest hit of each ray in `range`; ties go to the lowest index. Entries of `hits`
    /// for rays that hit nothing, and for rays outside `range`, are left unchanged.
    pub fn closest(
        &self,
        kernel: Kernel,
        rays: &RayBatch,
        range: Range<usize>,
        hits: &mut HitBatch,
    ) {
        self.trace::<false, ()>(kernel, rays, range, hits, &mut ());
    }

    /// Finds whether each ray in `range` hits anything, and if so sets its entry of `hits` to
    /// distance 0 and primitive 0. Other entries are left unchanged.
    pub fn occluded(
        &self,
        kernel: Kernel,
        rays: &RayBatch,
        range: Range<usize>,
        hits: &mut HitBatch,
    ) {
        self.trace::<true, ()>(kernel, rays, range, hits, &mut ());
    }

    /// Does the same as [`Accelerator::closest`], or as [`Accelerator::occluded`] if `any` is set,
    /// and returns counts of the work done.
    pub fn count(
        &self,
        kernel: Kernel,
        any: bool,
        rays: &RayBatch,
        range: Range<usize>,
        hits: &mut HitBatch,
    ) -> Counters {
        let mut counters = Counters::default();
        if any {
            self.trace::<true, _>(kernel, rays, range, hits, &mut counters);
        } else {
            self.trace::<false, _>(kernel, rays, range, hits, &mut counters);
        }
        counters
    }

    fn trace<const ANY: bool, C: Count>(
        &self,
        kernel: Kernel,
        rays: &RayBatch,
        range: Range<usize>,
        hits: &mut HitBatch,
        count: &mut C,
    ) {
        assert!(
            range.end <= rays.len() && range.end <= hits.len(),
            "range {range:?} must lie within the {} rays and their hits",
            rays.len()
        );
        let ends = (range.start, range.end);
        let Base { spanning: (blocks, spanning), extent, .. } = self.base();
        let meshes = self.geometry.len() as u32;
        let job = TraceJob { rays, ends, extent, blocks, spanning, meshes };
        let wild = match self.chosen(kernel) {
            Kernel::Packet => packet::trace::<ANY, C>(self.pair(1), &job, hits, count),
            Kernel::Beam => beam::trace::<ANY, C>(self.wide(1), &job, hits, count),
            Kernel::Stream => stream::trace::<ANY, C>(self.wide(1), &job, hits, count),
            Kernel::Flat => self.flat().trace::<ANY, C>(&job, hits, count),
            Kernel::Scalar => range.collect(),
        };
        count.left(wild.len());
        for index in wild {
            self.trace_scalar::<ANY>(rays, index, hits, count);
        }
    }

    fn trace_scalar<const ANY: bool>(
        &self,
        rays: &RayBatch,
        index: usize,
        hits: &mut HitBatch,
        count: &mut impl Count,
    ) {
        let (tree, geometry) = (self.scalar(), &*self.geometry);
        let (ray, t_min, t_max) = rays.get(index);
        if ANY {
            if tree.any_occluded(geometry, 0, &ray, (t_min, t_max), count) {
                hits.set(index, Hit::of(0, 0.0));
            }
        } else if let Some(hit) = tree.count_closest(geometry, &ray, t_min, t_max, count) {
            hits.set(index, hit);
        }
    }
}

/// Splits the elements into primitives that span the scene and the others. If more primitives span
/// it than fit into a block, they all count as others. Elements from `end` on are triangles and
/// instances, which never span it: in a tree, a ray is tested against a whole block of triangles at
/// once. `scene` is half the surface area of the scene's box.
fn spanning(boxes: &[Bounds], end: u32, scene: f32) -> (Vec<u32>, Vec<u32>) {
    let share = |primitive: &u32| boxes[*primitive as usize].half_area() / scene;
    let (mut spanning, mut others): (Vec<u32>, Vec<u32>) =
        (0..boxes.len() as u32).partition(|p| *p < end && share(p) >= SPANNING_SHARE);
    if spanning.len() > LANES {
        others.append(&mut spanning);
        others.sort_unstable();
    }
    (spanning, others)
}
