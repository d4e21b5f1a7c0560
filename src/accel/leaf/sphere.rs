//! Leaf blocks of spheres that do not move.

use super::{Leaf, Meshes, count_tests, gather, numbers, transpose};
use crate::accel::Count;
use crate::accel::ray::{Best, OneRay, Packet};
use crate::geometry::sphere::lanes::{hits, misses, padded_radius2};
use crate::geometry::{Geometry, RayLanes};
use crate::math::Real;
use crate::simd::{Bits, Float, LANES, Lanes, Vec3x, axes, first_bits};

#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct LeafBlock {
    pub(super) center: [Lanes; 3],
    pub(super) radius: Lanes,
    pub(super) primitive: Lanes<u32>,
}

impl Leaf for LeafBlock {
    fn new(geometry: &Geometry, primitives: &[u32]) -> Self {
        let spheres = || primitives.iter().map(|&p| &geometry.spheres[p as usize]);
        Self {
            // The contract adds the motion even if it is 0, which turns a coordinate of −0 into 0.
            center: transpose(spheres().map(|sphere| sphere.center_at(0.0))),
            radius: gather(spheres().map(|sphere| sphere.radius)),
            primitive: numbers(primitives),
        }
    }

    #[inline(always)]
    fn bounds(&self) -> Option<[[Float; 3]; 2]> {
        let radius = Float::new(self.radius);
        let center = |axis: usize| Float::new(self.center[axis]);
        Some([axes(|axis| center(axis) - radius), axes(|axis| center(axis) + radius)])
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
        let (center, radius) = (Vec3x::of_lanes(&self.center), Float::new(self.radius));
        best.offer_lanes(hits::<true>(&one.ray(), center, radius), &self.primitive);
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
        let padded = padded_radius2(Float::new(self.radius)).to_array();
        for lane in Bits(lanes) {
            let center = Vec3x::splat_lane(&self.center, lane);
            let radius = Float::splat(self.radius[lane]);
            let (padded, primitive) = (Float::splat(padded[lane]), self.primitive[lane]);
            test_packet::<V, ANY, SPANNING>(packet, |_| center, radius, padded, primitive);
        }
    }
}

/// Tests the rays of a packet against a sphere. `center` returns its position at the rays' times.
///
/// The filter does not rule out rays that leave a huge sphere, because of its margin. For spanning
/// spheres, the test rules them out before the square root.
#[inline(always)]
pub(super) fn test_packet<const V: usize, const ANY: bool, const SPANNING: bool>(
    packet: &mut Packet<V>,
    center: impl Fn(&RayLanes) -> Vec3x,
    radius: Float,
    padded_radius2: Float,
    primitive: u32,
) {
    let mut missed = [0; V];
    for (missed, rays) in missed.iter_mut().zip(&packet.vectors) {
        let ray = &rays.setup.ray;
        *missed = misses(ray, center(ray), padded_radius2);
    }
    // One branch serves all vectors. Usually all rays miss, which CPUs predict well.
    let all = first_bits(LANES);
    if missed.iter().all(|&missed| missed == all) {
        return;
    }
    for (rays, missed) in packet.vectors.iter_mut().zip(missed) {
        if missed != all {
            let ray = &rays.setup.ray;
            if let Some(hits) = hits::<SPANNING>(ray, center(ray), radius) {
                rays.offer::<ANY>(hits, primitive);
            }
        }
    }
}
