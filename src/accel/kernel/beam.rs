//! Packets as beams: all rays of a packet at once against every box of a wide node.
//!
//! The rays' origins and directions lie in intervals; interval arithmetic bounds where any of
//! them enters and leaves a box, for as many boxes at once as there are lanes (Boulos, Wald,
//! Benthin 2008, "Adaptive Ray Packet Reordering", section 3, has packets culled so before
//! their rays are tested one by one). What a beam cannot miss, its rays are tested against.
//!
//! Departures:
//! 1. Distances are measured along the axis that the first ray goes along fastest. The
//!    intervals of the other slopes are then those of the frustum around the rays.
//! 2. Boxes of primitives are taken from the leaf blocks themselves, so that only primitives
//!    whose own box the beam meets are tested.

use super::frames::{Frame, Frames};
use super::job::Job;
use super::octants::Octants;
use super::single::{Above, trace_each};
use crate::accel::batch::HitBatch;
use crate::accel::counters::Count;
use crate::accel::leaf::{BlockRef, Blocks};
use crate::accel::ray::packet::Packet;
use crate::accel::ray::rays::Rays;
use crate::accel::slab::near_and_far;
use crate::accel::tree::wide::WideTree;
use crate::simd::{Float, LANES, Mask, axes};

/// The intervals of a packet, each in every lane.
struct Beam<const V: usize> {
    /// The planes of a node that the rays meet first on each axis, and last.
    near: [usize; 3],
    far: [usize; 3],
    /// Slopes of the distance over a plane's coordinate: least and largest.
    slopes: [[Float; 2]; 3],
    /// What is taken off for near planes with either slope, and for far planes.
    near_offsets: [[Float; 2]; 3],
    far_offsets: [[Float; 2]; 3],
    /// Lower end of the rays' intervals.
    t_min: Float,
    /// By which the rays' distances are multiplied.
    scales: [Float; V],
}

impl<const V: usize> Beam<V> {
    /// The beam of the rays that are there, if there are any.
    #[inline(always)]
    fn new(packet: &Packet<V>, octants: &Octants) -> Option<Self> {
        let vectors = &packet.vectors;
        let longest = vectors.iter().find_map(Rays::longest_axis_of_first)?;
        let (near, far) = near_and_far(octants.negative);
        let mut beam = Self {
            near,
            far,
            slopes: [[Float::ZERO; 2]; 3],
            near_offsets: [[Float::ZERO; 2]; 3],
            far_offsets: [[Float::ZERO; 2]; 3],
            t_min: Float::INFINITY,
            scales: [Float::ZERO; V],
        };
        for (rays, scale) in vectors.iter().zip(&mut beam.scales) {
            *scale = rays.scale(longest);
            beam.t_min = rays.only(rays.t_min() * *scale, Float::INFINITY).min(beam.t_min);
        }
        beam.t_min = beam.t_min.least_lane();
        let none = Float::splat(f32::NEG_INFINITY);
        for axis in 0..3 {
            let sign = Float::splat(if octants.negative[axis] { -1.0 } else { 1.0 });
            let (mut low, mut high, mut near, mut far) =
                (Float::INFINITY, none, none, Float::INFINITY);
            for (rays, scale) in vectors.iter().zip(beam.scales) {
                let slope = rays.steepness(axis) * scale;
                low = rays.only(slope, Float::INFINITY).min(low);
                high = rays.only(slope, none).max(high);
                let (ahead, back) = rays.slab_origins(axis, sign);
                near = rays.only(ahead, none).max(near);
                far = rays.only(back, Float::INFINITY).min(far);
            }
            let (low, high, near, far) =
                (low.least_lane(), high.largest_lane(), near.largest_lane(), far.least_lane());
            beam.slopes[axis] = [low * sign, high * sign];
            beam.near_offsets[axis] = [near * low, near * high];
            beam.far_offsets[axis] = [far * low, far * high];
        }
        Some(beam)
    }

    /// Whether the rays spread by more than a quarter of the way: such a beam meets so many of the
    /// boxes of a large tree that it would take a thousand times as long as its rays alone.
    #[inline(always)]
    fn is_wide(&self) -> bool {
        let across = |slope: Float| Float::splat(1.0) / slope.abs();
        let spread = axes(|axis| {
            let [low, high] = self.slopes[axis];
            (across(low) - across(high)).gt(Float::splat(0.25)).any()
        });
        spread[0] || spread[1] || spread[2]
    }

    /// A bound of where any ray enters the boxes, and the bits of the boxes that the beam
    /// cannot miss up to `limit`.
    #[inline(always)]
    fn enter(&self, near: [Float; 3], far: [Float; 3], limit: Float) -> (Float, Mask) {
        let (mut entry, mut exit) = (self.t_min, limit);
        for axis in 0..3 {
            let ([low, high], [a, b]) = (self.slopes[axis], self.near_offsets[axis]);
            let near = near[axis].free_mul_sub(low, a).min(near[axis].free_mul_sub(high, b));
            entry = near.max(entry);
            let [a, b] = self.far_offsets[axis];
            let far = far[axis].free_mul_sub(low, a).max(far[axis].free_mul_sub(high, b));
            exit = far.min(exit);
        }
        (entry, entry.le(exit))
    }

    /// The children of a node that the beam cannot miss up to `limit`.
    #[inline(always)]
    fn visit(&self, tree: &WideTree, index: u32, limit: Float, count: &mut impl Count) -> Frame {
        let node = &tree.nodes[index as usize];
        let plane = |index: usize| Float::new(node.planes[index]);
        let (near, far) = (axes(|a| plane(self.near[a])), axes(|a| plane(self.far[a])));
        let (entry, entered) = self.enter(near, far, limit);
        count.node(LANES as u32, entered.bits().count_ones());
        Frame::new(index, entry, entered)
    }

    /// The lanes of a block whose primitives' boxes the beam cannot miss.
    #[inline(always)]
    fn candidates(
        &self,
        blocks: &Blocks,
        block: BlockRef,
        limit: Float,
        count: &mut impl Count,
    ) -> u32 {
        let Some([low, high]) = blocks.bounds(block) else { return block.valid() };
        let plane = |index: usize| if index < 3 { low[index] } else { high[index - 3] };
        let (_, entered) =
            self.enter(axes(|a| plane(self.near[a])), axes(|a| plane(self.far[a])), limit);
        let candidates = entered.bits() & block.valid();
        count.boxes(LANES as u32, candidates.count_ones());
        candidates
    }
}

/// Vectors of rays in a beam, in trees that fit into caches that are fast: 64 rays.
const MANY: usize = 64 / LANES;
/// In others, whose boxes are small beside a beam.
const FEW: usize = 2;

/// Takes packets through the tree as beams, those whose rays differ in octant, or spread too much, ray
/// by ray.
/// Returns the rays that it leaves to others.
#[inline(never)] // so that profilers find it
pub(crate) fn trace<const ANY: bool, C: Count>(
    tree: &WideTree,
    job: &Job<'_>,
    hits: &mut HitBatch,
    count: &mut C,
) -> Vec<usize> {
    if tree.is_large {
        trace_beams::<ANY, FEW, C>(tree, job, hits, count)
    } else {
        trace_beams::<ANY, MANY, C>(tree, job, hits, count)
    }
}

fn trace_beams<const ANY: bool, const V: usize, C: Count>(
    tree: &WideTree,
    job: &Job<'_>,
    hits: &mut HitBatch,
    count: &mut C,
) -> Vec<usize> {
    let mut above = Above::new(tree);
    job.trace::<ANY, V, C>(hits, count, |packet, count| {
        if tree.nodes.is_empty() {
            return;
        }
        let octants = Octants::new(packet);
        if octants.mixed {
            trace_each::<ANY, V>(tree, packet, &mut above, count);
        } else if let Some(beam) = Beam::new(packet, &octants) {
            if tree.is_large && beam.is_wide() {
                trace_each::<ANY, V>(tree, packet, &mut above, count);
            } else {
                traverse::<ANY, V>(tree, packet, &beam, above.first(), count);
            }
        }
    })
}

/// Visits the blocks in boxes that the beam cannot miss, nearer boxes first.
#[inline(always)]
fn traverse<const ANY: bool, const V: usize>(
    tree: &WideTree,
    packet: &mut Packet<V>,
    beam: &Beam<V>,
    above: &mut Frames,
    count: &mut impl Count,
) {
    let mut limit = packet.farthest(&beam.scales);
    let mut frame = beam.visit(tree, 0, limit, count);
    above.clear();
    while let Some(child) = above.next(&mut frame, tree, limit.first()) {
        if child & BlockRef::LEAF != 0 {
            let block = BlockRef::from_bits(child);
            let candidates = beam.candidates(&tree.blocks, block, limit, count);
            if candidates != 0 {
                tree.blocks.test_packet::<V, ANY, true, false>(block, candidates, packet, count);
                limit = packet.farthest(&beam.scales);
            }
        } else {
            above.push(&frame, tree, tree.is_large);
            frame = beam.visit(tree, child, limit, count);
        }
    }
}
