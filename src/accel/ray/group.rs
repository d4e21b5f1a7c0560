//! Rays that are traced one after the other, and their closest hits so far.

use super::best::{Best, BestLanes};
use super::one_ray::{OneRay, Table};
use super::rays::Rays;
use crate::accel::setup::Setup;
use crate::simd::LANES;

/// Up to `V` vectors of rays, and their closest hits so far. The rays are numbered through the lanes
/// of all vectors, and a set of them is a mask.
pub(crate) struct Group<const V: usize> {
    tables: [Table; V],
    best: [BestLanes; V],
}

impl<const V: usize> Group<V> {
    /// A placeholder without rays.
    pub(crate) const NONE: Self =
        Self { tables: [const { Table::NONE }; V], best: [const { BestLanes::NONE }; V] };

    /// Takes over up to `V` vectors of rays. Returns the set of those that search for hits.
    #[inline(always)]
    pub(crate) fn load(&mut self, vectors: &[Rays]) -> u32 {
        let mut looking = 0;
        for (vector, rays) in vectors.iter().enumerate() {
            self.tables[vector].set(&rays.setup);
            self.best[vector] = rays.best();
            looking |= rays.looking() << (vector * LANES);
        }
        looking
    }

    /// Writes the closest hits to the vectors from which the rays were taken.
    #[inline(always)]
    pub(crate) fn store<const ANY: bool>(&self, vectors: &mut [Rays]) {
        for (rays, best) in vectors.iter_mut().zip(&self.best) {
            rays.set_best::<ANY>(best);
        }
    }

    /// The closest hit so far of one ray.
    #[inline(always)]
    pub(crate) fn best(&self, ray: usize) -> Best {
        let (vector, lane) = place::<V>(ray);
        self.best[vector].lane(lane)
    }

    #[inline(always)]
    pub(crate) fn set_best(&mut self, ray: usize, best: Best) {
        let (vector, lane) = place::<V>(ray);
        self.best[vector].set(lane, best);
    }

    #[inline(always)]
    pub(crate) fn ray(&self, ray: usize) -> OneRay<'_> {
        let (vector, lane) = place::<V>(ray);
        OneRay::new(&self.tables[vector], lane)
    }
}

impl Group<1> {
    /// Takes over the rays of `setup`, without hits.
    #[inline(always)]
    pub(crate) fn new(setup: &Setup) -> Self {
        let mut group = Self::NONE;
        group.tables[0].set(setup);
        group
    }
}

/// The vector and the lane of a ray.
#[inline(always)]
fn place<const V: usize>(ray: usize) -> (usize, usize) {
    // The remainder shows the compiler that the vector is in range.
    (ray / LANES % V, ray % LANES)
}

/// Iterator over the rays of a set.
pub(crate) struct Members(pub(crate) u32);

impl Iterator for Members {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let ray = self.0.trailing_zeros() as usize;
        self.0 &= self.0 - 1;
        Some(ray)
    }
}
