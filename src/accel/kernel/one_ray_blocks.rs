//! One ray, against the N primitives of a block.

use super::one_ray::OneRay;
use crate::accel::batch::HitBatch;
use crate::accel::counters::Count;
use crate::accel::leaf::{BlockRef, Blocks};
use crate::geometry::Shape;
use crate::geometry::lanes::{self, HitLanes, QuadTest};
use crate::simd::{Bits, Float, LANES, Lanes, Vec3x, axes};

/// The closest hit so far. The interval is open: a hit at `t` counts only where one at `t` was
/// found before, and has a lower index.
#[derive(Clone, Copy)]
pub(crate) struct Best {
    pub(crate) t: f32,
    /// [`HitBatch::MISS`] before there is one.
    pub(crate) primitive: u32,
}

impl Best {
    #[inline(always)]
    pub(crate) fn found(&self) -> bool {
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

/// The closest hits so far of a vector of rays.
pub(crate) struct BestLanes {
    pub(crate) t: Lanes,
    pub(crate) primitive: Lanes<u32>,
}

impl BestLanes {
    #[inline(always)]
    pub(crate) fn lane(&self, lane: usize) -> Best {
        Best { t: self.t[lane], primitive: self.primitive[lane] }
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, best: Best) {
        (self.t[lane], self.primitive[lane]) = (best.t, best.primitive);
    }
}

/// Tests the primitives of a block.
#[inline(always)]
pub(crate) fn test(
    blocks: &Blocks,
    block: BlockRef,
    one: &OneRay<'_>,
    best: &mut Best,
    count: &mut impl Count,
) {
    count.leaf(LANES as u32, block.count());
    match block.kind() {
        Shape::Sphere => {
            let block = &blocks.spheres[block.index()];
            let radius = Float::new(block.radius);
            let hits = lanes::sphere::<true>(&one.ray(), Vec3x::of_lanes(&block.center), radius);
            best.offer_lanes(hits, &block.primitive);
        }
        Shape::MovingSphere => {
            let block = &blocks.moving_spheres[block.index()];
            let (ray, radius) = (one.ray(), Float::new(block.still.radius));
            let hits = lanes::sphere::<true>(&ray, block.centers(ray.time), radius);
            best.offer_lanes(hits, &block.still.primitive);
        }
        Shape::Quad => {
            let block = &blocks.quads[block.index()];
            let (ray, quads) = (one.ray(), block.lanes());
            let t = quads.distance(&ray);
            let near = t.gt(ray.t_min) & t.le(Float::splat(best.t));
            if near.any() {
                let hit = near & quads.contains(&ray, t);
                best.offer_lanes(Some(HitLanes { t, hit }), &block.primitive);
            }
        }
        Shape::Triangle => {
            let valid = block.valid();
            let block = &blocks.triangles[block.index()];
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
