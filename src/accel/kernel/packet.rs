//! Packets: vectors of rays against one primitive.

use super::rays::Rays;
use crate::accel::batch::HitBatch;
use crate::accel::counters::Count;
use crate::accel::leaf::{BlockRef, Blocks};
use crate::geometry::Shape;
use crate::geometry::lanes::{self, HitLanes, QuadTest, RayLanes, SpecialQuad};
use crate::simd::{Bits, Float, Int, LANES, Mask, Vec3x, first_bits};

/// Vectors of rays in the packets of most kernels: 32 rays, which share a primitive's numbers and
/// the questions that CPUs cannot foretell the answers of.
pub(crate) const VECTORS: usize = 32 / LANES;

/// A packet on its way.
pub(crate) struct Packet<const V: usize> {
    pub(crate) vectors: [Rays; V],
}

impl<const V: usize> Packet<V> {
    pub(crate) const NONE: Self = Self { vectors: [Rays::NONE; V] };

    /// Writes what was hit. Rays that hit nothing are left as they are.
    #[inline(always)]
    pub(crate) fn store<const ANY: bool>(&self, first: usize, end: usize, hits: &mut HitBatch) {
        for (vector, rays) in self.vectors.iter().enumerate() {
            let first = end.min(first + vector * LANES);
            let (old_t, old) = (&mut hits.t[first..end], &mut hits.primitive[first..end]);
            let hit = rays.found::<ANY>();
            let (t, primitive) =
                if ANY { (Float::ZERO, Int::splat(0)) } else { (rays.t, rays.primitive) };
            if old.len() >= LANES {
                hit.select(primitive, Int::load(old)).store(old);
                hit.select(t, Float::load(old_t)).store(old_t);
            } else {
                let (t, primitive) = (t.to_array(), primitive.to_array());
                for lane in Bits(hit.bits() & first_bits(old.len())) {
                    old_t[lane] = t[lane];
                    old[lane] = primitive[lane];
                }
            }
        }
    }

    /// Tests the primitives in the lanes of a block whose bits are set, one after the other.
    ///
    /// What to ask before the costly part of a test changes nothing but speed: of quads whether
    /// any ray is near their plane (`NEAR`), of spheres whether rays leave them (`LEAVE`).
    #[inline(always)]
    pub(crate) fn test<const ANY: bool, const NEAR: bool, const LEAVE: bool>(
        &mut self,
        blocks: &Blocks,
        block: BlockRef,
        lanes: u32,
        count: &mut impl Count,
    ) {
        // Triangles are counted where they are tested: once for each axis that rays go along.
        if block.kind() != Shape::Triangle {
            for rays in &self.vectors {
                let looking = rays.looking().count_ones();
                (0..lanes.count_ones()).for_each(|_| count.leaf(LANES as u32, looking));
            }
        }
        match block.kind() {
            Shape::Sphere => {
                let block = &blocks.spheres[block.index()];
                let padded = lanes::padded_radius2(Float::new(block.radius)).to_array();
                for lane in Bits(lanes) {
                    let center = Vec3x::splat_lane(&block.center, lane);
                    let radius = Float::splat(block.radius[lane]);
                    let (padded, primitive) = (Float::splat(padded[lane]), block.primitive[lane]);
                    self.test_sphere::<ANY, LEAVE>(|_| center, radius, padded, primitive);
                }
            }
            Shape::MovingSphere => {
                let block = &blocks.moving_spheres[block.index()];
                let padded = lanes::padded_radius2(Float::new(block.still.radius)).to_array();
                for lane in Bits(lanes) {
                    let center = Vec3x::splat_lane(&block.still.center, lane);
                    let motion = Vec3x::splat_lane(&block.motion, lane);
                    let radius = Float::splat(block.still.radius[lane]);
                    let center = |ray: &RayLanes| center + motion * ray.time;
                    let padded = Float::splat(padded[lane]);
                    let primitive = block.still.primitive[lane];
                    self.test_sphere::<ANY, LEAVE>(center, radius, padded, primitive);
                }
            }
            Shape::Quad => {
                let (block, special) =
                    (&blocks.quads[block.index()], &blocks.special[block.index()]);
                for lane in Bits(lanes) {
                    let primitive = block.primitive[lane];
                    // Told apart here, once for all vectors.
                    match &special[lane] {
                        Some(SpecialQuad::Aligned(quad)) => {
                            self.test_quad::<ANY, NEAR>(quad, primitive);
                        }
                        Some(SpecialQuad::Level(quad)) => {
                            self.test_quad::<ANY, NEAR>(quad, primitive);
                        }
                        Some(SpecialQuad::Upright(quad)) => {
                            self.test_quad::<ANY, NEAR>(quad, primitive);
                        }
                        None => self.test_quad::<ANY, NEAR>(&block.splat(lane), primitive),
                    }
                }
            }
            Shape::Triangle => {
                let block = &blocks.triangles[block.index()];
                for lane in Bits(lanes) {
                    let primitive = block.primitive[lane];
                    for rays in &mut self.vectors {
                        rays.test_triangle::<ANY>(&block.vertices, lane, primitive, count);
                    }
                }
            }
        }
    }

    /// Tests a quad.
    #[inline(always)]
    fn test_quad<const ANY: bool, const NEAR: bool>(
        &mut self,
        quad: &(impl QuadTest + Copy),
        primitive: u32,
    ) {
        // A copy stays in registers while vectors change.
        let quad = *quad;
        // Only `offer` looks at what is closest so far: asked in here, each quad would wait for the
        // one before.
        let offer = |rays: &mut Rays, t: Float| {
            let ray = &rays.setup.ray;
            let hit = t.gt(ray.t_min) & quad.contains(ray, t);
            rays.offer::<ANY>(HitLanes { t, hit }, primitive);
        };
        if !NEAR {
            // Dividing first, as below, loses where nothing is asked.
            for rays in &mut self.vectors {
                let t = quad.distance(&rays.setup.ray);
                offer(rays, t);
            }
            return;
        }
        // All divisions first, then one question for all: no vector waits for another.
        let (mut distances, mut near) = ([Float::ZERO; V], Mask::NONE);
        for (t, rays) in distances.iter_mut().zip(&self.vectors) {
            *t = quad.distance(&rays.setup.ray);
            near = near | (t.gt(rays.setup.ray.t_min) & t.le(rays.t));
        }
        if near.any() {
            for (rays, t) in self.vectors.iter_mut().zip(distances) {
                offer(rays, t);
            }
        }
    }

    /// Tests a sphere that is at `center` at a ray's time.
    #[inline(always)]
    fn test_sphere<const ANY: bool, const LEAVE: bool>(
        &mut self,
        center: impl Fn(&RayLanes) -> Vec3x,
        radius: Float,
        padded_radius2: Float,
        primitive: u32,
    ) {
        let mut missed = [0; V];
        for (missed, rays) in missed.iter_mut().zip(&self.vectors) {
            let ray = &rays.setup.ray;
            *missed = lanes::misses_sphere(ray, center(ray), padded_radius2);
        }
        // Asked once for all vectors: mostly all miss, and CPUs learn that.
        let all = first_bits(LANES);
        if missed.iter().all(|&missed| missed == all) {
            return;
        }
        for (rays, missed) in self.vectors.iter_mut().zip(missed) {
            if missed != all {
                let ray = &rays.setup.ray;
                if let Some(hits) = lanes::sphere::<LEAVE>(ray, center(ray), radius) {
                    rays.offer::<ANY>(hits, primitive);
                }
            }
        }
    }

    /// The largest distance, times the rays' scales, that a ray still looks at: in every lane.
    #[inline(always)]
    pub(crate) fn farthest(&self, scales: &[Float; V]) -> Float {
        let mut farthest = Float::splat(f32::NEG_INFINITY);
        for (rays, scale) in self.vectors.iter().zip(scales) {
            farthest = (rays.t * *scale).max(farthest);
        }
        farthest.largest_lane()
    }
}
