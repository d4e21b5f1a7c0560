//! Leaf blocks of spheres that move.

use super::{Leaf, Meshes, count_tests, sphere, transpose};
use crate::accel::Count;
use crate::accel::ray::{Best, OneRay, Packet};
use crate::geometry::sphere::lanes::{hits, padded_radius2};
use crate::geometry::{Geometry, RayLanes};
use crate::math::Real;
use crate::simd::{Bits, Float, Lanes, Vec3x};

#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct LeafBlock {
    /// The spheres at time 0.
    still: sphere::LeafBlock,
    motion: [Lanes; 3],
}

impl Leaf for LeafBlock {
    fn new(geometry: &Geometry, primitives: &[u32]) -> Self {
        let motions = primitives.iter().map(|&p| geometry.spheres[p as usize].motion());
        Self { still: Leaf::new(geometry, primitives), motion: transpose(motions) }
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
        let Self { still, motion } = self;
        let (ray, radius) = (one.ray(), Float::new(still.radius));
        let center = Vec3x::of_lanes(&still.center) + Vec3x::of_lanes(motion) * ray.time;
        best.offer_lanes(hits::<true>(&ray, center, radius), &still.primitive);
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
        let Self { still, motion } = self;
        let padded = padded_radius2(Float::new(still.radius)).to_array();
        for lane in Bits(lanes) {
            let center = Vec3x::splat_lane(&still.center, lane);
            let motion = Vec3x::splat_lane(motion, lane);
            let center = |ray: &RayLanes| center + motion * ray.time;
            let radius = Float::splat(still.radius[lane]);
            let (padded, primitive) = (Float::splat(padded[lane]), still.primitive[lane]);
            sphere::test_packet::<V, ANY, SPANNING>(packet, center, radius, padded, primitive);
        }
    }
}
