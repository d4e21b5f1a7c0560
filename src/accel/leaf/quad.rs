//! Leaf blocks of quads.

use super::{Leaf, Meshes, count_tests, numbers, transpose};
use crate::accel::Count;
use crate::accel::ray::{Best, OneRay, Packet, Rays};
use crate::geometry::quad::lanes::{QuadLanes, QuadTest, SpecialQuad};
use crate::geometry::{Geometry, HitLanes};
use crate::math::Real;
use crate::simd::{Bits, Float, LANES, Lanes, Mask, Vec3x};

#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct LeafBlock {
    q: [Lanes; 3],
    normal: [Lanes; 3],
    dual_u: [Lanes; 3],
    dual_v: [Lanes; 3],
    primitive: Lanes<u32>,
    /// The data of a cheaper test, which packets use; `None` for quads that need the general test.
    special: [Option<SpecialQuad>; LANES],
}

impl LeafBlock {
    /// Returns the quads, one in each lane.
    #[inline(always)]
    fn lanes(&self) -> QuadLanes {
        self.with(Vec3x::of_lanes)
    }

    /// Returns the quad of one lane, copied to every lane.
    #[inline(always)]
    fn splat(&self, lane: usize) -> QuadLanes {
        self.with(|lanes| Vec3x::splat_lane(lanes, lane))
    }

    #[inline(always)]
    fn with(&self, vector: impl Fn(&[Lanes; 3]) -> Vec3x) -> QuadLanes {
        QuadLanes {
            q: vector(&self.q),
            normal: vector(&self.normal),
            dual_u: vector(&self.dual_u),
            dual_v: vector(&self.dual_v),
        }
    }
}

impl Leaf for LeafBlock {
    fn new(geometry: &Geometry, primitives: &[u32]) -> Self {
        let first = geometry.spheres.len();
        let quads = || primitives.iter().map(|&p| &geometry.quads[p as usize - first]);
        let mut special = [const { None }; LANES];
        special.iter_mut().zip(quads()).for_each(|(to, quad)| *to = SpecialQuad::new(quad));
        Self {
            q: transpose(quads().map(|quad| quad.q)),
            normal: transpose(quads().map(|quad| quad.normal)),
            dual_u: transpose(quads().map(|quad| quad.duals()[0])),
            dual_v: transpose(quads().map(|quad| quad.duals()[1])),
            primitive: numbers(primitives),
            special,
        }
    }

    #[inline(always)]
    fn test_one<const ANY: bool>(
        &self,
        _: u32,
        _: bool,
        one: &OneRay<'_>,
        best: &mut Best,
        _: &mut impl Meshes,
        _: &mut impl Count,
    ) {
        let (ray, quads) = (one.ray(), self.lanes());
        let t = quads.distance(&ray);
        let near = t.gt(ray.t_min) & t.le(Float::splat(best.t));
        if near.any() {
            let hit = near & quads.contains(&ray, t);
            best.offer_lanes(Some(HitLanes { t, hit }), &self.primitive);
        }
    }

    #[inline(always)]
    fn test_packet<const V: usize, const ANY: bool, const ALL_MISS: bool, const SPANNING: bool>(
        &self,
        lanes: u32,
        packet: &mut Packet<V>,
        _: &mut impl Meshes,
        count: &mut impl Count,
    ) {
        count_tests(packet, lanes, count);
        for lane in Bits(lanes) {
            let primitive = self.primitive[lane];
            // The special cases are distinguished here, once for all vectors.
            match &self.special[lane] {
                Some(SpecialQuad::Aligned(quad)) => {
                    test_packet::<V, ANY, ALL_MISS>(packet, quad, primitive);
                }
                Some(SpecialQuad::Level(quad)) => {
                    test_packet::<V, ANY, ALL_MISS>(packet, quad, primitive);
                }
                Some(SpecialQuad::Upright(quad)) => {
                    test_packet::<V, ANY, ALL_MISS>(packet, quad, primitive);
                }
                None => test_packet::<V, ANY, ALL_MISS>(packet, &self.splat(lane), primitive),
            }
        }
    }
}

/// Tests a quad against the rays of a packet.
#[inline(always)]
fn test_packet<const V: usize, const ANY: bool, const ALL_MISS: bool>(
    packet: &mut Packet<V>,
    quad: &(impl QuadTest + Copy),
    primitive: u32,
) {
    // A copy can stay in registers while the vectors are modified.
    let quad = *quad;
    // Only `offer` reads the closest hit so far. If the test read it too, each quad would have to
    // wait for the previous one.
    let offer = |rays: &mut Rays, t: Float| {
        let ray = &rays.setup.ray;
        let hit = t.gt(ray.t_min) & quad.contains(ray, t);
        rays.offer::<ANY>(HitLanes { t, hit }, primitive);
    };
    if !ALL_MISS {
        // Without the early test, doing all divisions first, as below, is slower.
        for rays in &mut packet.vectors {
            let t = quad.distance(&rays.setup.ray);
            offer(rays, t);
        }
        return;
    }
    // All divisions come first, then one branch for all vectors, so that no vector waits for
    // another.
    let (mut distances, mut near) = ([Float::ZERO; V], Mask::NONE);
    for (t, rays) in distances.iter_mut().zip(&packet.vectors) {
        *t = quad.distance(&rays.setup.ray);
        near = near | (t.gt(rays.setup.ray.t_min) & t.le(rays.t));
    }
    if near.any() {
        for (rays, t) in packet.vectors.iter_mut().zip(distances) {
            offer(rays, t);
        }
    }
}
