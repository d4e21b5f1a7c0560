//! Packets: vectors of rays that are traced together.

use super::Rays;
use crate::accel::HitBatch;
use crate::math::{Real, Word};
use crate::simd::{Bits, Float, Int, LANES, first_bits};

/// Number of vectors in a packet of most kernels. The 32 rays of such a packet share the loads of a
/// primitive's numbers and the branches that CPUs mispredict.
pub(crate) const VECTORS: usize = 32 / LANES;

/// A packet of rays during its traversal.
pub(crate) struct Packet<const V: usize> {
    pub(crate) vectors: [Rays; V],
}

impl<const V: usize> Packet<V> {
    pub(crate) const NONE: Self = Self { vectors: [Rays::NONE; V] };

    /// Writes the hits to `hits`. Entries of rays that hit nothing are left unchanged.
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

    /// Writes the instances of the hits to `hits`. Triangles of meshes have the numbers from `meshes`
    /// on.
    #[inline(always)]
    pub(crate) fn store_instances(
        &self,
        first: usize,
        end: usize,
        meshes: u32,
        hits: &mut HitBatch,
    ) {
        let lanes = hits.instance[first..end].chunks_mut(LANES);
        for (lanes, rays) in lanes.zip(&self.vectors) {
            let (primitive, instance) = (rays.primitive.to_array(), rays.instance.to_array());
            let found = rays.found::<false>().bits() & first_bits(lanes.len());
            for lane in Bits(found) {
                lanes[lane] = if primitive[lane] >= meshes { instance[lane] } else { 0 };
            }
        }
    }

    /// For each ray, multiplies its current maximum distance by its scale. Returns the
    /// largest product, in every lane.
    #[inline(always)]
    pub(crate) fn farthest(&self, scales: &[Float; V]) -> Float {
        let mut farthest = Float::splat(f32::NEG_INFINITY);
        for (rays, scale) in self.vectors.iter().zip(scales) {
            farthest = (rays.t * *scale).max(farthest);
        }
        farthest.largest_lane()
    }
}
