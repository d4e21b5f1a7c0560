//! One ray at a time: against N boxes of a node, against N primitives of a block.

use super::batch::HitBatch;
use super::blocks::{BlockRef, Blocks, Kind};
use super::counters::Count;
use super::frames::{Frame, Frames};
use super::packet::{Job, Packet};
use super::setup::Setup;
use super::shear_axes;
use super::wide::WideTree;
use crate::geometry::lanes::{self, HitLanes, RayLanes};
use crate::simd::{Bits, Float, Int, LANES, Lanes, Vec3x, axes};

/// Rays made ready, to be taken lane by lane.
struct Table {
    origin: [Lanes; 3],
    direction: [Lanes; 3],
    time: Lanes,
    t_min: Lanes,
    length2: Lanes,
    inv_length2: Lanes,
    inverse: [Lanes; 3],
    near_offset: [Lanes; 3],
    far_offset: [Lanes; 3],
    shear: [Lanes; 3],
    longest: [u32; 2],
    negative: u32,
}

impl Table {
    #[inline(always)]
    fn new(setup: &Setup) -> Self {
        let lanes = |v: Vec3x| axes(|axis| v[axis].to_array());
        let slab = &setup.slab;
        let by_sign = |axis: usize, negative: usize, positive: usize| {
            let down = slab.inverse[axis].lt(Float::ZERO);
            down.select(slab.offsets[negative], slab.offsets[positive]).to_array()
        };
        Self {
            origin: lanes(setup.ray.origin),
            direction: lanes(setup.ray.direction),
            time: setup.ray.time.to_array(),
            t_min: setup.ray.t_min.to_array(),
            length2: setup.ray.length2.to_array(),
            inv_length2: setup.ray.inv_length2.to_array(),
            inverse: lanes(setup.slab.inverse),
            near_offset: axes(|axis| by_sign(axis, axis + 3, axis)),
            far_offset: axes(|axis| by_sign(axis, axis, axis + 3)),
            shear: lanes(setup.shear.shear),
            longest: [setup.shear.longest[0].bits(), setup.shear.longest[1].bits()],
            negative: setup.shear.negative.bits(),
        }
    }
}

/// One ray, to be put into every lane where it is needed: a load from the table is as fast as
/// a register, and vectors that must be kept in memory are not.
struct OneRay<'a> {
    table: &'a Table,
    lane: usize,
    /// The planes of a node that the ray meets first on each axis, and last.
    near: [usize; 3],
    far: [usize; 3],
    /// The order of axes in which triangles are seen.
    axes: [usize; 3],
}

impl<'a> OneRay<'a> {
    #[inline(always)]
    fn new(table: &'a Table, lane: usize) -> Self {
        let negative = axes(|axis| table.inverse[axis][lane] < 0.0);
        let bit = |bits: u32| bits >> lane & 1 == 1;
        let longest = if bit(table.longest[0]) {
            0
        } else if bit(table.longest[1]) {
            1
        } else {
            2
        };
        Self {
            table,
            lane,
            near: axes(|axis| axis + 3 * usize::from(negative[axis])),
            far: axes(|axis| axis + 3 * usize::from(!negative[axis])),
            axes: shear_axes(longest, bit(table.negative)),
        }
    }

    #[inline(always)]
    fn splat(&self, lanes: &Lanes) -> Float {
        Float::splat(lanes[self.lane])
    }

    #[inline(always)]
    fn vector(&self, lanes: &[Lanes; 3]) -> Vec3x {
        Vec3x::splat_lane(lanes, self.lane)
    }

    #[inline(always)]
    fn ray(&self) -> RayLanes {
        RayLanes {
            origin: self.vector(&self.table.origin),
            direction: self.vector(&self.table.direction),
            time: self.splat(&self.table.time),
            length2: self.splat(&self.table.length2),
            inv_length2: self.splat(&self.table.inv_length2),
            t_min: self.splat(&self.table.t_min),
        }
    }

    /// The children of a node that the ray enters up to `limit`.
    #[inline(always)]
    fn enter(&self, tree: &WideTree, place: u32, limit: f32, count: &mut impl Count) -> Frame {
        let (table, node) = (self.table, &tree.nodes[place as usize]);
        let meet = |planes: [usize; 3], offset: &[Lanes; 3]| {
            axes(|axis| {
                let plane = Float::new(node.planes[planes[axis]]);
                plane.free_mul_sub(self.splat(&table.inverse[axis]), self.splat(&offset[axis]))
            })
        };
        let [x, y, z] = meet(self.near, &table.near_offset);
        let entry = x.max(y).max(z.max(self.splat(&table.t_min)));
        let [x, y, z] = meet(self.far, &table.far_offset);
        let exit = x.min(y).min(z.min(Float::splat(limit)));
        let entered = entry.le(exit);
        count.node(LANES as u32, entered.bits().count_ones());
        Frame::new(place, entry, entered)
    }
}

/// The closest hit so far. The interval is open: a hit at `t` counts only where one at `t` was
/// found before, and has a lower index.
#[derive(Clone, Copy)]
struct Best {
    t: f32,
    /// [`HitBatch::MISS`] before there is one.
    primitive: u32,
}

impl Best {
    #[inline(always)]
    fn found(&self) -> bool {
        self.primitive != HitBatch::MISS
    }

    #[inline(always)]
    fn offer(&mut self, t: f32, primitive: u32) {
        if t < self.t || (t == self.t && self.found() && primitive < self.primitive) {
            *self = Self { t, primitive };
        }
    }

    #[inline(always)]
    fn offer_lanes(&mut self, hits: Option<HitLanes>, primitive: &Lanes<u32>) {
        let Some(HitLanes { t, hit }) = hits else { return };
        let closer = (hit & t.le(Float::splat(self.t))).bits();
        if closer != 0 {
            let t = t.to_array();
            for lane in Bits(closer) {
                self.offer(t[lane], primitive[lane]);
            }
        }
    }
}

/// Tests the primitives of a block.
#[inline(always)]
fn test(
    blocks: &Blocks,
    block: BlockRef,
    one: &OneRay<'_>,
    best: &mut Best,
    count: &mut impl Count,
) {
    count.leaf(LANES as u32, block.count());
    match block.kind() {
        Kind::Sphere => {
            let block = &blocks.spheres[block.place()];
            let radius = Float::new(block.radius);
            let hits = lanes::sphere(&one.ray(), Vec3x::new(&block.center), radius);
            best.offer_lanes(hits, &block.primitive);
        }
        Kind::MovingSphere => {
            let block = &blocks.moving_spheres[block.place()];
            let (ray, radius) = (one.ray(), Float::new(block.still.radius));
            let hits = lanes::sphere(&ray, block.centers(ray.time), radius);
            best.offer_lanes(hits, &block.still.primitive);
        }
        Kind::Quad => {
            let block = &blocks.quads[block.place()];
            let hits = lanes::quad::<true>(&one.ray(), &block.lanes(), Float::splat(best.t));
            best.offer_lanes(hits, &block.primitive);
        }
        Kind::Triangle => {
            let valid = block.valid();
            let block = &blocks.triangles[block.place()];
            let origin = axes(|axis| one.splat(&one.table.origin[one.axes[axis]]));
            let vertices = axes(|i| axes(|axis| Float::new(block.vertices[i][one.axes[axis]])));
            let shear = one.vector(&one.table.shear);
            let sheared = lanes::shear_triangles(origin, shear, vertices);
            let candidates = sheared.candidates(valid);
            if candidates != 0 {
                let t_min = one.table.t_min[one.lane];
                sheared.decide(candidates, |lane, t| {
                    if t > t_min {
                        best.offer(t, block.primitive[lane]);
                    }
                });
            }
        }
    }
}

/// Takes rays through the tree one by one. Returns the rays that it leaves to others.
pub(super) fn trace<const ANY: bool, C: Count>(
    tree: &WideTree,
    job: &Job<'_>,
    hits: &mut HitBatch,
    count: &mut C,
) -> Vec<usize> {
    let mut above = Frames::new(tree);
    job.trace::<ANY, 1, C>(hits, count, |packet, count| {
        trace_each::<ANY, 1>(tree, packet, &mut above, count);
    })
}

/// Takes the rays of `packet` through the tree one by one.
#[inline(always)]
pub(super) fn trace_each<const ANY: bool, const V: usize>(
    tree: &WideTree,
    packet: &mut Packet<V>,
    above: &mut Frames,
    count: &mut impl Count,
) {
    if tree.nodes.is_empty() {
        return;
    }
    for rays in &mut packet.vectors {
        let table = Table::new(&rays.setup);
        let (mut t, mut primitive) = (rays.t.to_array(), rays.primitive.to_array());
        for lane in Bits(rays.setup.active) {
            let mut best = Best { t: t[lane], primitive: primitive[lane] };
            if !(ANY && best.found()) {
                let one = OneRay::new(&table, lane);
                traverse::<ANY>(tree, &one, &mut best, above, count);
                (t[lane], primitive[lane]) = (best.t, best.primitive);
            }
        }
        rays.t = Float::new(t);
        rays.primitive = Int::new(primitive);
    }
}

/// Visits the blocks in boxes that the ray enters, nearer boxes first.
#[inline(always)]
fn traverse<const ANY: bool>(
    tree: &WideTree,
    one: &OneRay<'_>,
    best: &mut Best,
    above: &mut Frames,
    count: &mut impl Count,
) {
    above.clear();
    let mut frame = one.enter(tree, 0, best.t, count);
    while let Some(child) = above.next(&mut frame, tree, best.t) {
        if child & BlockRef::LEAF != 0 {
            test(&tree.blocks, BlockRef::from_bits(child), one, best, count);
            if ANY && best.found() {
                return;
            }
        } else {
            above.push(&frame, tree);
            frame = one.enter(tree, child, best.t, count);
        }
    }
}
