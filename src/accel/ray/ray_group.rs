//! Rays that are traced together and tested one after the other, and their closest hits so far.

use super::one_ray::Table;
use super::{Best, BestLanes, OneRay, Rays};
use crate::accel::Setup;
use crate::simd::LANES;

/// Up to `V` vectors of rays, and their closest hits so far. The rays are numbered through the
/// lanes of all vectors, and a set of them is a mask.
pub(crate) struct RayGroup<const V: usize> {
    tables: [Table; V],
    best: [BestLanes; V],
}

impl<const V: usize> RayGroup<V> {
    /// A placeholder without rays.
    pub(crate) const NONE: Self =
        Self { tables: [const { Table::NONE }; V], best: [const { BestLanes::NONE }; V] };

    /// A set of rays has 32 bits.
    const FITS: () = assert!(V * LANES <= 32);

    /// Takes over up to `V` vectors of rays. Returns the set of those that search for hits.
    #[inline(always)]
    pub(crate) fn load(&mut self, vectors: &[Rays]) -> u32 {
        let () = Self::FITS;
        let mut all = 0;
        for (vector, rays) in vectors.iter().enumerate() {
            self.best[vector] = rays.best();
            let looking = rays.looking();
            if looking != 0 {
                self.tables[vector].set(&rays.setup);
                all |= looking << (vector * LANES);
            }
        }
        all
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
        let (vector, lane) = vector_and_lane::<V>(ray);
        self.best[vector].lane(lane)
    }

    #[inline(always)]
    pub(crate) fn set_best(&mut self, ray: usize, best: Best) {
        let (vector, lane) = vector_and_lane::<V>(ray);
        self.best[vector].set(lane, best);
    }

    #[inline(always)]
    pub(crate) fn ray(&self, ray: usize) -> OneRay<'_> {
        let (vector, lane) = vector_and_lane::<V>(ray);
        OneRay::new(&self.tables[vector], lane)
    }
}

impl RayGroup<1> {
    /// Takes over the rays of `setup`. Before a ray is traced, [`Self::set_best`] must give the end
    /// of its interval.
    #[inline(always)]
    pub(crate) fn new(setup: &Setup) -> Self {
        let mut group = Self::NONE;
        group.tables[0].set(setup);
        group
    }
}

#[inline(always)]
fn vector_and_lane<const V: usize>(ray: usize) -> (usize, usize) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::ray::VECTORS;
    use crate::accel::{Extent, RayBatch};
    use crate::geometry::{Bounds, Geometry, Ray, Triangle, shear_axes};
    use crate::math::Stream;
    use crate::simd::{Mask, first_bits};
    use glam::Vec3;

    const RAYS: usize = VECTORS * LANES;

    /// Loads `rays` as vectors. Each ray may hit up to the distance 10.
    fn vectors(rays: &[Ray]) -> Vec<Rays> {
        let vertices = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let triangles = [Triangle { vertices }].into_iter().collect();
        let geometry = Geometry { triangles, ..Geometry::default() };
        let bounds = Bounds { min: -Vec3::ONE, max: Vec3::ONE };
        let extent = Extent::new(&geometry, bounds, bounds);
        let mut batch = RayBatch::default();
        rays.iter().for_each(|ray| batch.push(ray, 0.0, 10.0));
        (0..rays.len())
            .step_by(LANES)
            .map(|first| {
                let mut vector = Rays::NONE;
                let present = first_bits(rays.len() - first);
                assert_eq!(vector.load(&batch.vector(first), present, &extent), 0);
                vector
            })
            .collect()
    }

    #[test]
    fn rays_and_hits_keep_their_numbers() {
        let mut random = Stream::new(51);
        let mut point = || Vec3::from_array([(); 3].map(|()| random.between(-1.0, 1.0)));
        let rays: Vec<Ray> =
            (0..RAYS).map(|_| Ray { origin: point(), direction: point(), time: 0.0 }).collect();
        let mut loaded = vectors(&rays);
        let mut group = RayGroup::<VECTORS>::NONE;
        assert_eq!(group.load(&loaded), first_bits(RAYS));
        for (number, ray) in rays.iter().enumerate() {
            let one = group.ray(number);
            let longest = ray.direction.abs().max_position();
            assert_eq!(one.axes(), shear_axes(longest, ray.direction[longest] < 0.0));
            for axis in 0..3 {
                assert_eq!(one.is_down(axis), ray.direction[axis] < 0.0);
                assert_eq!(one.splat(&one.table.origin[axis]).first(), ray.origin[axis]);
            }
            assert!(!group.best(number).found());
            let (t, primitive) = (number as f32, number as u32);
            group.set_best(number, Best { t, primitive, instance: primitive + 1 });
        }
        group.store::<false>(&mut loaded);
        for (number, vector) in (0..RAYS).step_by(LANES).zip(&loaded) {
            let best = vector.best();
            for lane in 0..LANES {
                let Best { t, primitive, instance } = best.lane(lane);
                let number = (number + lane) as u32;
                assert_eq!((t, primitive, instance), (number as f32, number, number + 1));
            }
        }
        assert_eq!(Members(first_bits(RAYS)).collect::<Vec<_>>(), (0..RAYS).collect::<Vec<_>>());
    }

    #[test]
    fn nothing_is_left_of_earlier_rays() {
        let ray = Ray { origin: Vec3::ZERO, direction: Vec3::ONE, time: 0.0 };
        let mut group = RayGroup::<VECTORS>::NONE;
        group.load(&vectors(&[ray; RAYS]));
        (0..RAYS).for_each(|number| {
            group.set_best(number, Best { t: 1.0, primitive: 7, instance: 0 });
        });
        // One vector, in which a ray has already ended and another is missing.
        let mut few = vectors(&[ray; LANES - 1]);
        few[0].end(Mask::from_bits(1));
        assert_eq!(group.load(&few), first_bits(LANES - 1) & !1);
        assert!((0..LANES).all(|number| !group.best(number).found()));
        group.set_best(2, Best { t: 1.0, primitive: 7, instance: 0 });
        group.store::<true>(&mut few);
        assert_eq!(few[0].looking(), first_bits(LANES - 1) & !0b101);
    }
}
