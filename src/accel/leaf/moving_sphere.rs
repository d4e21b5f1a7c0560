//! Blocks of spheres that move.

use std::mem::take;

use super::{Leaf, count_tests, sphere, transpose};
use crate::accel::counters::Count;
use crate::accel::huge_pages::settle;
use crate::accel::ray::best::Best;
use crate::accel::ray::one_ray::OneRay;
use crate::accel::ray::packet::Packet;
use crate::geometry::Geometry;
use crate::geometry::ray_lanes::RayLanes;
use crate::geometry::sphere::lanes::{hits, padded_radius2};
use crate::simd::{Bits, Float, Lanes, Vec3x, prefetch};

#[derive(Clone, Debug)]
#[repr(C, align(64))]
struct Block {
    /// At time 0.
    still: sphere::Block,
    motion: [Lanes; 3],
}

#[derive(Clone, Debug, Default)]
pub(super) struct Blocks(Vec<Block>);

impl Leaf for Blocks {
    fn push(&mut self, geometry: &Geometry, primitives: &[u32]) {
        let motions = primitives.iter().map(|&p| geometry.spheres[p as usize].motion());
        let still = sphere::Block::new(geometry, primitives);
        self.0.push(Block { still, motion: transpose(motions) });
    }

    fn len(&self) -> usize {
        self.0.len()
    }

    fn settle(&mut self) {
        self.0 = settle(take(&mut self.0));
    }

    #[inline(always)]
    fn prefetch(&self, block: usize) {
        prefetch(&self.0[block]);
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.0)
    }

    #[inline(always)]
    fn test_one(&self, block: usize, _: u32, one: &OneRay<'_>, best: &mut Best) {
        let Block { still, motion } = &self.0[block];
        let (ray, radius) = (one.ray(), Float::new(still.radius));
        let center = Vec3x::of_lanes(&still.center) + Vec3x::of_lanes(motion) * ray.time;
        best.offer_lanes(hits::<true>(&ray, center, radius), &still.primitive);
    }

    #[inline(always)]
    fn test_packet<const V: usize, const ANY: bool, const NEAR: bool, const LEAVE: bool>(
        &self,
        block: usize,
        lanes: u32,
        packet: &mut Packet<V>,
        count: &mut impl Count,
    ) {
        count_tests(packet, lanes, count);
        let Block { still, motion } = &self.0[block];
        let padded = padded_radius2(Float::new(still.radius)).to_array();
        for lane in Bits(lanes) {
            let center = Vec3x::splat_lane(&still.center, lane);
            let motion = Vec3x::splat_lane(motion, lane);
            let center = |ray: &RayLanes| center + motion * ray.time;
            let radius = Float::splat(still.radius[lane]);
            let (padded, primitive) = (Float::splat(padded[lane]), still.primitive[lane]);
            sphere::test_packet::<V, ANY, LEAVE>(packet, center, radius, padded, primitive);
        }
    }
}
