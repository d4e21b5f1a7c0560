//! The kernel `beam`, which tests all rays of a packet at once against every box of a wide node.
//!
//! The rays' origins and directions lie in intervals. Interval arithmetic bounds the distances at
//! which any of them enters and leaves a box, for one box in each lane. (Boulos, Wald, Benthin
//! 2008, "Adaptive Ray Packet Reordering", section 3, cull packets in this way before they test the
//! rays one by one.) Rays are tested individually only against primitives whose boxes the beam may
//! enter.
//!
//! Differences from the paper:
//! 1. Distances are measured along the longest axis of the first ray. The intervals of the slopes
//!    on the other two axes then describe the frustum around the rays.
//! 2. The boxes of individual primitives are taken from the leaf blocks, so that rays are tested
//!    only against primitives whose own box the beam may enter.
//! 3. In trees that are large, or have instances or holes, a beam may be much wider than the boxes. Such
//!    a beam does a limited amount of work, and its rays visit the rest as a stream.

use super::job::TraceJob;
use super::meshes::MeshTrees;
use super::octants::Octants;
use super::stream::Tracer;
use super::visits::{Child, Visits};
use crate::accel::ray::{Packet, Rays, VECTORS};
use crate::accel::tree::wide::WideTree;
use crate::accel::{Count, HitBatch, LeafBlocks, LeafRef, Meshes, NoMeshes};
use crate::math::{Real, Word};
use crate::simd::{Float, Int, LANES, Mask, axes};

/// The intervals that bound the rays of a packet. Each value is the same in every lane.
struct Beam<const V: usize> {
    /// Whether the directions of the rays are negative on each axis.
    negative: [bool; 3],
    /// Least and largest slope, on each axis, of the distance as a function of a plane's
    /// coordinate.
    slopes: [[Float; 2]; 3],
    /// Offsets that are subtracted for near planes and for far planes, one for each of the two
    /// slopes.
    near_offsets: [[Float; 2]; 3],
    far_offsets: [[Float; 2]; 3],
    /// Least lower end of the rays' intervals.
    t_min: Float,
    /// Factors that convert the rays' distances to distances along the beam's axis.
    scales: [Float; V],
}

impl<const V: usize> Beam<V> {
    /// Creates the beam of the active rays. Returns `None` if no ray is active.
    #[inline(always)]
    fn new(packet: &Packet<V>, octants: &Octants) -> Option<Self> {
        let vectors = &packet.vectors;
        let longest = vectors.iter().find_map(Rays::longest_axis_of_first)?;
        let mut beam = Self {
            negative: octants.negative,
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

    /// Returns whether the rays spread by more than a quarter of the distance. In large trees, such rays
    /// are a stream from the start: without this test, shadow rays of coffee ran at 0.61 of the speed
    /// (`profiling/lost.md`).
    #[inline(always)]
    fn is_wide(&self) -> bool {
        let across = |slope: Float| Float::splat(1.0) / slope.abs();
        let spread = axes(|axis| {
            let [low, high] = self.slopes[axis];
            (across(low) - across(high)).gt(Float::splat(0.25)).any()
        });
        spread[0] || spread[1] || spread[2]
    }

    /// Factor that turns lower bounds of distances along the beam's axis into lower bounds along its
    /// rays. It is 0.001% too small, which covers rounding.
    fn distance_factor(&self) -> f32 {
        let most = self.scales.iter().fold(Float::ZERO, |most, scale| scale.max(most));
        0.999_99 / most.largest_lane().first()
    }

    /// Returns a lower bound of the distances at which any ray enters the boxes, and a mask of the
    /// boxes that some ray may enter up to `limit`. `plane` returns the lower (0) or the upper (1)
    /// planes on an axis.
    #[inline(always)]
    fn enter(&self, plane: impl Fn(usize, usize) -> Float, limit: Float) -> (Float, Mask) {
        let near = axes(|axis| plane(axis, usize::from(self.negative[axis])));
        let far = axes(|axis| plane(axis, usize::from(!self.negative[axis])));
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

    /// Pushes the children of a node that the beam may enter up to `limit`.
    #[inline(always)]
    fn visit(
        &self,
        tree: &WideTree,
        index: u32,
        limit: Float,
        visits: &mut Visits,
        count: &mut impl Count,
    ) {
        let node = &tree.nodes[index as usize];
        let plane = |axis: usize, end: usize| Float::new(node.planes[axis][end]);
        let (entry, entered) = self.enter(plane, limit);
        count.node(LANES as u32, entered.bits().count_ones());
        let entering = entered.select(Int::splat(BEAM), Int::ZERO);
        visits.push::<false>(tree, node, entering, entry);
    }

    /// Returns the lanes of those primitives of a block whose boxes the beam may enter up to
    /// `limit`.
    #[inline(always)]
    fn candidates(
        &self,
        blocks: &LeafBlocks,
        block: LeafRef,
        limit: Float,
        count: &mut impl Count,
    ) -> u32 {
        let Some(ends) = blocks.bounds(block) else { return block.valid() };
        let (_, entered) = self.enter(|axis, end| ends[end][axis], limit);
        let candidates = entered.bits() & block.valid();
        count.boxes(LANES as u32, candidates.count_ones());
        candidates
    }
}

/// In visits, a beam counts as a set of one ray.
const BEAM: u32 = 1;

/// Number of vectors in a beam of 64 rays, for trees that fit into the fast caches.
const MANY: usize = 64 / LANES;
/// Number of vectors in a beam for all other trees, whose boxes are small compared with a beam.
const FEW: usize = VECTORS;
/// Number of visits and of tested primitives after which such a beam leaves the rest to its rays: two for each
/// ray. Half of it, or a limit of tests alone, makes little difference (`profiling/lost.md`).
const MOST_WORK: u32 = (2 * FEW * LANES) as u32;

/// Traces packets as beams. If the rays of a packet differ in octant, or spread too much, they are
/// traced as streams. Returns the indices of the wild rays (see `Setup::load`), which are left to
/// the scalar reference.
#[inline(never)] // so that profilers find it
pub(crate) fn trace<const ANY: bool, C: Count>(
    tree: &WideTree,
    job: &TraceJob<'_>,
    hits: &mut HitBatch,
    count: &mut C,
) -> Vec<usize> {
    match (tree.is_large, tree.is_plain()) {
        (true, true) => trace_beams::<ANY, false, FEW, C>(tree, NoMeshes, job, hits, count),
        (false, true) => trace_beams::<ANY, false, MANY, C>(tree, NoMeshes, job, hits, count),
        (_, false) => {
            trace_beams::<ANY, true, FEW, C>(tree, MeshTrees::new(tree), job, hits, count)
        }
    }
}

fn trace_beams<const ANY: bool, const INSTANCES: bool, const V: usize, C: Count>(
    tree: &WideTree,
    meshes: impl Meshes,
    job: &TraceJob<'_>,
    hits: &mut HitBatch,
    count: &mut C,
) -> Vec<usize> {
    let mut tracer = Tracer::new(tree, meshes);
    job.trace::<ANY, INSTANCES, V, C>(hits, count, |packet, count| {
        if tree.nodes.is_empty() {
            return;
        }
        let octants = Octants::new(packet);
        let beam = if octants.mixed { None } else { Beam::new(packet, &octants) };
        match beam {
            Some(beam) if !(tree.is_large && beam.is_wide()) => {
                let Tracer { visits, meshes, .. } = &mut tracer;
                traverse::<ANY, V>(tree, packet, &beam, visits, meshes, count);
                if V == FEW && !visits.is_empty() {
                    tracer.finish::<ANY>(tree, &mut packet.vectors, beam.distance_factor(), count);
                }
            }
            _ => tracer.trace::<ANY>(tree, &mut packet.vectors, count),
        }
    })
}

/// Visits the blocks in boxes that the beam may enter, nearer boxes first. If the beam proves to be wide,
/// leaves visits to its rays.
#[inline(always)]
fn traverse<const ANY: bool, const V: usize>(
    tree: &WideTree,
    packet: &mut Packet<V>,
    beam: &Beam<V>,
    visits: &mut Visits,
    meshes: &mut impl Meshes,
    count: &mut impl Count,
) {
    let mut work = 0;
    let mut limit = packet.farthest(&beam.scales);
    visits.start(BEAM);
    while V != FEW || work < MOST_WORK {
        let Some(visit) = visits.next::<false>() else { return };
        work += 1;
        match visit.child() {
            _ if visit.distance > limit.first() => {}
            Child::Node(index) => beam.visit(tree, index, limit, visits, count),
            Child::LeafBlock(block) => {
                let candidates = beam.candidates(&tree.blocks, block, limit, count);
                if candidates != 0 {
                    // The rays of a beam are coherent, so that often all miss a primitive.
                    tree.blocks.test_packet::<V, ANY, true, false>(
                        block, candidates, packet, meshes, count,
                    );
                    limit = packet.farthest(&beam.scales);
                    work += candidates.count_ones();
                }
            }
        }
    }
}
