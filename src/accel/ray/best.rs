//! The closest hits so far of rays that are tested one after the other.

use crate::accel::HitBatch;
use crate::geometry::HitLanes;
use crate::math::Real;
use crate::simd::{Bits, Float, LANES, Lanes};

/// The closest hit so far. The ray's interval is open, so a hit at exactly `t` counts only if `t`
/// is the distance of a hit already found and the new primitive has a lower index.
#[derive(Clone, Copy)]
pub(crate) struct Best {
    pub(crate) t: f32,
    /// [`HitBatch::MISS`] before the first hit.
    pub(crate) primitive: u32,
    /// The instance to which a triangle of a mesh belongs. It has no meaning for other primitives.
    pub(crate) instance: u32,
}

impl Best {
    #[inline(always)]
    pub(crate) fn found(&self) -> bool {
        self.primitive != HitBatch::MISS
    }

    #[inline(always)]
    pub(crate) fn offer(&mut self, t: f32, primitive: u32) {
        if t < self.t || (t == self.t && self.found() && primitive < self.primitive) {
            *self = Self { t, primitive, ..*self };
        }
    }

    /// [`Self::offer`] without a branch, of a hit beyond `t_min`. For hits that no CPU can predict.
    #[inline(always)]
    pub(crate) fn offer_by_select(&mut self, t: f32, t_min: f32, primitive: u32) {
        let tie = (t == self.t) & self.found() & (primitive < self.primitive);
        let closer = (t > t_min) & ((t < self.t) | tie);
        self.t = if closer { t } else { self.t };
        self.primitive = if closer { primitive } else { self.primitive };
    }

    /// An empty search for closer hits, or for equally close ones if `ties` is set.
    #[inline(always)]
    pub(crate) fn before(&self, ties: bool) -> Self {
        let t = if ties { self.t.next_up() } else { self.t };
        Self { t, primitive: HitBatch::MISS, instance: 0 }
    }

    #[inline(always)]
    pub(crate) fn offer_lanes(&mut self, hits: Option<HitLanes>, primitive: &Lanes<u32>) {
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
    pub(crate) instance: Lanes<u32>,
}

impl BestLanes {
    pub(crate) const NONE: Self =
        Self { t: [0.0; LANES], primitive: [HitBatch::MISS; LANES], instance: [0; LANES] };

    #[inline(always)]
    pub(crate) fn lane(&self, lane: usize) -> Best {
        Best { t: self.t[lane], primitive: self.primitive[lane], instance: self.instance[lane] }
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, best: Best) {
        let Best { t, primitive, instance } = best;
        (self.t[lane], self.primitive[lane], self.instance[lane]) = (t, primitive, instance);
    }
}
