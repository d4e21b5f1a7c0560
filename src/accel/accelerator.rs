//! A scene's geometry laid out for every kernel.

use std::ops::Range;
use std::sync::OnceLock;
use std::time::Instant;

use super::batch::{HitBatch, RayBatch};
use super::beam;
use super::binary::BinaryTree;
use super::blocks::{BlockRef, Blocks};
use super::bvh2::Bvh2;
use super::counters::{Count, Counters};
use super::flat::Flat;
use super::job::Job;
use super::kernel::Kernel;
use super::pair::PairTree;
use super::pair_traversal::{self, Order};
use super::setup::Extent;
use super::single;
use super::wide::WideTree;
use crate::geometry::{Bounds, Geometry};
use crate::simd::LANES;

/// The layouts of a scene's geometry, each made when it is first needed.
#[derive(Debug)]
pub struct Accelerator<'a> {
    pub(super) geometry: &'a Geometry,
    shutter: (f32, f32),
    /// Box around all primitives.
    all: Bounds,
    /// The tree over all but the primitives that span the scene.
    tree: BinaryTree,
    /// The primitives that span the scene, which every ray would meet the boxes of.
    pub(super) spanning: (Blocks, Vec<BlockRef>),
    pub(super) extent: Extent,
    scalar: Lazy<Bvh2>,
    wide: Lazy<WideTree>,
    pair: Lazy<PairTree>,
    flat: Lazy<Flat>,
}

/// What a layout took.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Size in memory.
    pub bytes: usize,
    /// Time that making it took, that of the tree which all but [`Kernel::Scalar`] and
    /// [`Kernel::Flat`] share not included.
    pub seconds: f64,
}

/// A layout that is made when it is first asked for, and the time that took.
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

/// A primitive spans the scene where its box has this share of the surface of the scene's.
const SPANNING_SHARE: f32 = 0.25;

impl<'a> Accelerator<'a> {
    /// Builds the tree that the layouts are made from. Its boxes hold every primitive over all
    /// times of `shutter`.
    pub fn new(geometry: &'a Geometry, shutter: (f32, f32)) -> Self {
        let boxes = geometry.boxes(shutter);
        let all = boxes.iter().fold(Bounds::EMPTY, |union, b| union.union(*b));
        let (spanning, others) = spanning(&boxes, all.half_area());
        let tree = BinaryTree::new(&boxes, &others);
        let bounds = tree.nodes.first().map_or(Bounds::EMPTY, |root| root.bounds);
        let mut blocks = Blocks::default();
        let references = blocks.push_all(geometry, &spanning);
        Self {
            geometry,
            shutter,
            tree,
            spanning: (blocks, references),
            extent: Extent::new(geometry, all, bounds),
            all,
            scalar: Lazy::default(),
            wide: Lazy::default(),
            pair: Lazy::default(),
            flat: Lazy::default(),
        }
    }

    /// Makes the layout that `kernel` needs, if it is not there yet.
    pub fn prepare(&self, kernel: Kernel) -> Layout {
        let spanning = self.spanning.0.bytes();
        let (bytes, seconds) = match kernel {
            Kernel::Packet | Kernel::Octant => {
                (self.pair().bytes() + spanning, self.pair.seconds())
            }
            Kernel::Beam | Kernel::Single => (self.wide().bytes() + spanning, self.wide.seconds()),
            Kernel::Flat => (self.flat().bytes(), self.flat.seconds()),
            Kernel::Scalar => (self.scalar().bytes(), self.scalar.seconds()),
        };
        Layout { bytes, seconds }
    }

    /// A box around the primitives, but for those that span the scene unless they all do.
    pub(crate) fn bounds(&self) -> Bounds {
        self.tree.nodes.first().map_or(self.all, |root| root.bounds)
    }

    /// Size of what layouts are made from, which is kept.
    pub fn tree_bytes(&self) -> usize {
        self.tree.bytes()
    }

    fn scalar(&self) -> &Bvh2 {
        self.scalar.get(|| Bvh2::new(self.geometry, self.shutter))
    }

    pub(super) fn pair(&self) -> &PairTree {
        self.pair.get(|| PairTree::new(self.geometry, &self.tree, &self.extent))
    }

    fn flat(&self) -> &Flat {
        self.flat.get(|| Flat::new(self.geometry, self.all))
    }

    fn wide(&self) -> &WideTree {
        self.wide.get(|| WideTree::new(self.geometry, &self.tree))
    }

    /// The closest hit of each ray of `range`; ties go to the lowest index. `hits` of rays
    /// that hit nothing, and of other rays, are left as they are.
    pub fn closest(
        &self,
        kernel: Kernel,
        rays: &RayBatch,
        range: Range<usize>,
        hits: &mut HitBatch,
    ) {
        self.trace::<false, ()>(kernel, rays, range, hits, &mut ());
    }

    /// Whether each ray of `range` hits anything: distance 0 and primitive 0 where it does.
    /// Other `hits` are left as they are.
    pub fn occluded(
        &self,
        kernel: Kernel,
        rays: &RayBatch,
        range: Range<usize>,
        hits: &mut HitBatch,
    ) {
        self.trace::<true, ()>(kernel, rays, range, hits, &mut ());
    }

    /// As [`Accelerator::closest`], or [`Accelerator::occluded`] where `any`, and the work done.
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
        assert!(range.end <= rays.len() && range.end <= hits.len(), "{range:?} of {}", rays.len());
        let ends = (range.start, range.end);
        let (blocks, spanning) = (&self.spanning.0, &*self.spanning.1);
        let job = Job { rays, ends, extent: &self.extent, blocks, spanning };
        let packets = pair_traversal::trace::<ANY, C>;
        let wild = match kernel {
            Kernel::Packet => packets(self.pair(), Order::Given, &job, hits, count),
            Kernel::Octant => packets(self.pair(), Order::Octants, &job, hits, count),
            Kernel::Beam => beam::trace::<ANY, C>(self.wide(), &job, hits, count),
            Kernel::Single => single::trace::<ANY, C>(self.wide(), &job, hits, count),
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
        let (tree, geometry) = (self.scalar(), self.geometry);
        let (ray, t_min, t_max) = rays.get(index);
        if ANY {
            if tree.count_occluded(geometry, &ray, t_min, t_max, count) {
                (hits.t[index], hits.primitive[index]) = (0.0, 0);
            }
        } else if let Some(hit) = tree.count_closest(geometry, &ray, t_min, t_max, count) {
            (hits.t[index], hits.primitive[index]) = (hit.t, hit.primitive);
        }
    }
}

/// The primitives that span the scene, at most a block, and the others. `scene` is half the area of
/// its box.
fn spanning(boxes: &[Bounds], scene: f32) -> (Vec<u32>, Vec<u32>) {
    let share = |primitive: &u32| boxes[*primitive as usize].half_area() / scene;
    let (mut spanning, mut others): (Vec<u32>, Vec<u32>) =
        (0..boxes.len() as u32).partition(|p| share(p) >= SPANNING_SHARE);
    if spanning.len() > LANES {
        others.append(&mut spanning);
        others.sort_unstable();
    }
    (spanning, others)
}
