//! Builds wide trees fast: top down, by splits between bins.
//!
//! Of the planes between bins along the three axes, each split takes the one of least surface area cost (Wald 2007, "On
//! Fast Construction of SAH-based Bounding Volume Hierarchies"). No binary tree is stored: a node takes splits until it
//! has as many children as lanes.

use std::ops::Range;

use glam::Vec3;

use super::assembly::Cluster;
use super::subtree::Subtree;
use crate::geometry::{Bounds, Geometry};
use crate::math;
use crate::simd::LANES;

/// Number of bins per axis, for many and for few primitives.
const BINS: usize = 16;
const FEW_BINS: usize = 8;
/// Largest number of primitives for few bins.
const FEW: usize = 64;

/// Three coordinates and 0, so that an operation on all of them is one instruction.
type Row = [f32; 4];

#[inline(always)]
fn each(a: Row, b: Row, f: impl Fn(f32, f32) -> f32) -> Row {
    [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])]
}

/// A primitive and its box.
#[derive(Clone, Copy)]
struct Item {
    min: Row,
    max: Row,
    primitive: u32,
}

impl Item {
    fn new(primitive: u32, bounds: &Bounds) -> Self {
        let Bounds { min, max } = bounds.without_subnormals();
        let row = |v: Vec3| [v.x, v.y, v.z, 0.0];
        Self { min: row(min), max: row(max), primitive }
    }

    /// Twice the centre of the box.
    #[inline(always)]
    fn center(&self) -> Row {
        each(self.min, self.max, |a, b| a + b)
    }
}

/// A box and the number of primitives in it.
#[derive(Clone, Copy)]
struct Bin {
    min: Row,
    max: Row,
    count: u32,
}

impl Bin {
    const EMPTY: Self = Self { min: [f32::INFINITY; 4], max: [f32::NEG_INFINITY; 4], count: 0 };

    #[inline(always)]
    fn add(&mut self, min: Row, max: Row, count: u32) {
        (self.min, self.max) = (each(self.min, min, math::min), each(self.max, max, math::max));
        self.count += count;
    }

    fn of(items: &[Item]) -> Self {
        let mut bin = Self::EMPTY;
        items.iter().for_each(|item| bin.add(item.min, item.max, 1));
        bin
    }

    #[inline(always)]
    fn union(mut self, other: &Self) -> Self {
        self.add(other.min, other.max, other.count);
        self
    }

    /// Half the surface area of the box, which must not be empty.
    #[inline(always)]
    fn half_area(&self) -> f32 {
        let [x, y, z, _] = each(self.max, self.min, |a, b| a - b);
        x * y + y * z + z * x
    }

    /// The share of this side in the cost of a split.
    #[inline(always)]
    fn cost(&self) -> f32 {
        if self.count == 0 { 0.0 } else { self.half_area() * self.count as f32 }
    }

    fn bounds(&self) -> Bounds {
        let corner = |[x, y, z, _]: Row| Vec3::new(x, y, z);
        Bounds { min: corner(self.min), max: corner(self.max) }
    }
}

/// A child of a node: neighbouring items, and their box.
#[derive(Clone)]
struct Child {
    items: Range<usize>,
    bin: Bin,
    /// Whether a block has room for the items.
    is_leaf: bool,
}

/// Lays out the cluster of `primitives`, whose boxes are `boxes[primitive]`.
pub(super) fn cluster(geometry: &Geometry, boxes: &[Bounds], primitives: &[u32]) -> Cluster {
    let mut items: Vec<Item> =
        primitives.iter().map(|&p| Item::new(p, &boxes[p as usize])).collect();
    let mut tree = Subtree::default();
    let root = child(geometry, &items, 0..items.len(), Bin::of(&items));
    let bounds = root.bin.bounds();
    let mut open = vec![(tree.push(), root, 1)];
    let mut block = Vec::with_capacity(LANES);
    while let Some((slot, node, depth)) = open.pop() {
        tree.depth = tree.depth.max(depth);
        let children = children(geometry, &mut items, node);
        let mut lane = 0;
        for run in runs(geometry, &items, &children) {
            let reference = if run[0].is_leaf {
                let (first, last) = (&run[0].items, &run[run.len() - 1].items);
                block.clear();
                block.extend(items[first.start..last.end].iter().map(|item| item.primitive));
                tree.blocks.push(geometry, &mut block).bits()
            } else {
                let below = tree.push();
                open.push((below, run[0].clone(), depth + 1));
                below as u32
            };
            for child in run {
                tree.nodes[slot].set(lane, &child.bin.bounds(), reference);
                lane += 1;
            }
        }
    }
    Cluster::whole(tree, primitives.len(), bounds)
}

fn child(geometry: &Geometry, all: &[Item], items: Range<usize>, bin: Bin) -> Child {
    let shape = |item: &Item| geometry.shape(item.primitive);
    let inside = &all[items.clone()];
    let is_leaf = inside.len() <= LANES && inside.iter().all(|i| shape(i) == shape(&inside[0]));
    Child { items, bin, is_leaf }
}

/// Splits `node` until it has as many children as lanes, or all of them fit into blocks. Neighbours in space are
/// adjacent.
fn children(geometry: &Geometry, all: &mut [Item], node: Child) -> Vec<Child> {
    let mut children = Vec::with_capacity(LANES);
    children.push(node);
    while children.len() < LANES {
        let inner = children.iter().enumerate().filter(|(_, child)| !child.is_leaf);
        let largest =
            inner.max_by(|(_, a), (_, b)| a.bin.half_area().total_cmp(&b.bin.half_area()));
        let Some((index, _)) = largest else { break };
        let items = children[index].items.clone();
        let (count, left, right) = split(&mut all[items.clone()]);
        let middle = items.start + count;
        children[index] = child(geometry, all, items.start..middle, left);
        children.insert(index + 1, child(geometry, all, middle..items.end, right));
    }
    children
}

/// Splits children into runs: an inner node is a run of its own, and a run of leaves fits into a block.
fn runs<'c>(
    geometry: &Geometry,
    all: &[Item],
    children: &'c [Child],
) -> impl Iterator<Item = &'c [Child]> {
    let shape = |child: &Child| geometry.shape(all[child.items.start].primitive);
    let mut filled = children[0].items.len();
    children.chunk_by(move |before, child| {
        let together = filled.saturating_add(child.items.len()) <= LANES;
        let leaves = before.is_leaf && child.is_leaf && shape(before) == shape(child);
        let same = leaves && together;
        filled = child.items.len() + if same { filled } else { 0 };
        same
    })
}

/// Moves two or more items into two parts. Returns the number of items in the first part, and the boxes of both.
fn split(items: &mut [Item]) -> (usize, Bin, Bin) {
    let mut centers = Bin::EMPTY;
    for item in &*items {
        let center = item.center();
        centers.add(center, center, 1);
    }
    let few = items.len() <= FEW;
    let binning = Binning::new(&centers, if few { FEW_BINS } else { BINS });
    let best = match few {
        true => best_plane::<FEW_BINS>(items, &binning),
        false => best_plane::<BINS>(items, &binning),
    };
    let Some((axis, last, left, right)) = best else {
        let (first, second) = items.split_at(items.len() / 2);
        return (first.len(), Bin::of(first), Bin::of(second));
    };
    let (mut low, mut high) = (0, items.len());
    while low < high {
        if binning.bins_of(&items[low])[axis] <= last {
            low += 1;
        } else {
            high -= 1;
            items.swap(low, high);
        }
    }
    (low, left, right)
}

/// Divides the box of centres into bins along each axis.
struct Binning {
    low: Row,
    scale: Row,
    last: f32,
}

impl Binning {
    fn new(centers: &Bin, bins: usize) -> Self {
        let scale = each(centers.max, centers.min, |high, low| bins as f32 / (high - low));
        Self { low: centers.min, scale, last: (bins - 1) as f32 }
    }

    /// The bin of `item` on each axis. Along an axis without extent, all items are in one bin: 0 times infinity is NaN,
    /// for which `min` is the last one.
    #[inline(always)]
    fn bins_of(&self, item: &Item) -> [usize; 3] {
        let place = each(each(item.center(), self.low, |a, b| a - b), self.scale, |a, b| a * b);
        [0, 1, 2].map(|axis| math::min(place[axis], self.last) as usize)
    }
}

/// The axis and the last bin before the plane of least cost, and the boxes on both sides; `None` if all items are in one
/// bin on each axis.
fn best_plane<const BINS: usize>(
    items: &[Item],
    binning: &Binning,
) -> Option<(usize, usize, Bin, Bin)> {
    let mut bins = [[Bin::EMPTY; BINS]; 3];
    for item in items {
        let places = binning.bins_of(item);
        for (bins, place) in bins.iter_mut().zip(places) {
            bins[place].add(item.min, item.max, 1);
        }
    }
    let (mut least, mut best) = (f32::INFINITY, None);
    for (axis, bins) in bins.iter().enumerate() {
        let mut right = [Bin::EMPTY; BINS];
        for bin in (1..BINS).rev() {
            right[bin - 1] = right[bin].union(&bins[bin]);
        }
        let mut left = Bin::EMPTY;
        for bin in 0..BINS - 1 {
            left = left.union(&bins[bin]);
            let cost = left.cost() + right[bin].cost();
            if left.count > 0 && right[bin].count > 0 && cost < least {
                (least, best) = (cost, Some((axis, bin, left, right[bin])));
            }
        }
    }
    best
}
