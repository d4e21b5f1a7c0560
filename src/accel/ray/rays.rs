//! A vector of rays and their closest hits so far.

use glam::Vec3;

use super::BestLanes;
use crate::accel::{Extent, HitBatch, RayVector, Setup};
use crate::geometry::{HitLanes, Ray, RayLanes, shear_axes};
use crate::math::{Real, Word};
use crate::simd::{Bits, Float, Int, Mask, Vec3x, axes};

/// A vector of rays and their closest hits so far.
#[derive(Clone, Copy)]
pub(crate) struct Rays {
    pub(crate) setup: Setup,
    orientations: Orientations,
    /// Distance of the closest hit so far, initially the end of the interval; −∞ for inactive lanes
    /// and for rays that have finished.
    pub(crate) t: Float,
    /// Primitive of the closest hit; [`HitBatch::MISS`] before the first hit, and whenever any hit
    /// suffices.
    pub(crate) primitive: Int,
    /// The instances to which triangles of meshes belong. They have no meaning for other primitives.
    pub(crate) instance: Int,
}

/// Rays with the same longest axis and the same sign on it, which share the order of axes in
/// triangle tests.
#[derive(Clone, Copy)]
pub(crate) struct Orientation {
    pub(crate) axes: [usize; 3],
    pub(crate) rays: u32,
}

/// The orientations of a vector's rays.
#[derive(Clone, Copy)]
struct Orientations {
    orientations: [Orientation; 6],
    count: usize,
}

impl Orientations {
    const NONE: Self = Self { orientations: [Orientation { axes: [0; 3], rays: 0 }; 6], count: 0 };

    /// Replaces the orientations by those of the rays of `setup`.
    #[inline(always)]
    fn set(&mut self, setup: &Setup) {
        self.count = 0;
        let negative = setup.shear.negative.bits();
        for longest in 0..3 {
            let along = setup.shear.longest[longest].bits() & setup.active;
            for (is_negative, rays) in [(false, along & !negative), (true, along & negative)] {
                if rays != 0 {
                    self.orientations[self.count] =
                        Orientation { axes: shear_axes(longest, is_negative), rays };
                    self.count += 1;
                }
            }
        }
    }
}

impl Rays {
    pub(crate) const NONE: Self = Self {
        setup: Setup::NONE,
        orientations: Orientations::NONE,
        t: Float::ZERO,
        primitive: Int::ZERO,
        instance: Int::ZERO,
    };

    /// Loads the rays whose bits are set in `present`. Returns the bits of those that are left to
    /// the scalar reference, as [`Setup::load`] does.
    #[inline(always)]
    pub(crate) fn load(&mut self, rays: &RayVector, present: u32, extent: &Extent) -> u32 {
        let wild = self.setup.load(rays, present, extent);
        self.t = self.only(rays.t_max, Float::splat(f32::NEG_INFINITY));
        self.primitive = Int::splat(HitBatch::MISS);
        self.orientations.count = 0;
        wild
    }

    /// Finds the orientations, unless they are known. Many rays are never tested in this way.
    #[inline(always)]
    pub(crate) fn find_orientations(&mut self) {
        if self.orientations.count == 0 {
            self.orientations.set(&self.setup);
        }
    }

    /// Returns the rays in groups with the same longest axis and sign, which [`Self::find_orientations`] has
    /// found. Usually all rays are in one group.
    #[inline(always)]
    pub(crate) fn orientations(&self) -> &[Orientation] {
        debug_assert!(
            self.orientations.count > 0 || self.setup.active == 0,
            "orientations were not looked for"
        );
        &self.orientations.orientations[..self.orientations.count]
    }

    /// Bits of the rays that still search for hits. Their `t` is not negative, since all hits lie
    /// at positive distances.
    #[inline(always)]
    pub(crate) fn looking(&self) -> u32 {
        self.t.ge(Float::ZERO).bits()
    }

    /// The rays that have hit something.
    #[inline(always)]
    pub(crate) fn found<const ANY: bool>(&self) -> Mask {
        if ANY {
            // Inactive lanes have the distance −∞ too.
            self.t.eq(Float::splat(f32::NEG_INFINITY)) & Mask::from_bits(self.setup.active)
        } else {
            !self.primitive.eq(Int::splat(HitBatch::MISS))
        }
    }

    /// The closest hits so far, in memory.
    #[inline(always)]
    pub(crate) fn best(&self) -> BestLanes {
        BestLanes {
            t: self.t.to_array(),
            primitive: self.primitive.to_array(),
            instance: self.instance.to_array(),
        }
    }

    /// Sets the closest hits. If any hit suffices, ends the search of the rays that have one.
    #[inline(always)]
    pub(crate) fn set_best<const ANY: bool>(&mut self, best: &BestLanes) {
        let primitive = Int::new(best.primitive);
        if ANY {
            self.end(!primitive.eq(Int::splat(HitBatch::MISS)));
        } else {
            (self.t, self.primitive) = (Float::new(best.t), primitive);
            self.instance = Int::new(best.instance);
        }
    }

    /// Ends the search of the rays in `hit`, for which any hit suffices.
    #[inline(always)]
    pub(crate) fn end(&mut self, hit: Mask) {
        // Whether any ray has hit is unpredictable, so there is no branch on it.
        self.t = hit.select(Float::splat(f32::NEG_INFINITY), self.t);
    }

    /// The lanes of `hit` whose hit at distance `t` is not farther than the closest so far, and for
    /// which `keep` returns true.
    #[inline(always)]
    pub(crate) fn filter(&self, t: Float, hit: Mask, keep: impl Fn(Ray, f32) -> bool) -> Mask {
        let RayLanes { origin, direction, time, .. } = self.setup.ray;
        let (mut left, distances) = ((hit & t.le(self.t)).bits(), t.to_array());
        for lane in Bits(left) {
            let vector = |v: Vec3x| Vec3::from_array(axes(|axis| v[axis].to_array()[lane]));
            let (origin, direction) = (vector(origin), vector(direction));
            let ray = Ray { origin, direction, time: time.to_array()[lane] };
            left &= !(u32::from(!keep(ray, distances[lane])) << lane);
        }
        Mask::from_bits(left)
    }

    /// Keeps the hits that are closer than the closest so far, or equally close with a lower index.
    #[inline(always)]
    pub(crate) fn offer<const ANY: bool>(&mut self, hits: HitLanes, primitive: u32) {
        let HitLanes { t, hit } = hits;
        let closer = hit & t.lt(self.t);
        if ANY {
            self.end(closer);
            return;
        }
        let ties = (hit & t.eq(self.t)).bits();
        if ties != 0 {
            let mut best = self.primitive.to_array();
            for lane in Bits(ties) {
                if best[lane] != HitBatch::MISS {
                    best[lane] = best[lane].min(primitive);
                }
            }
            self.primitive = Int::new(best);
        }
        self.t = closer.select(t, self.t);
        self.primitive = closer.select(Int::splat(primitive), self.primitive);
    }
}

/// The properties of rays from which beams are built.
impl Rays {
    /// The axis on which the direction of the first active ray is longest; `None` if no ray is
    /// active.
    #[inline(always)]
    pub(crate) fn longest_axis_of_first(&self) -> Option<usize> {
        let lane = Bits(self.setup.active).next()?;
        let speed = axes(|axis| self.setup.ray.direction[axis].to_array()[lane].abs());
        let most = if speed[0] > speed[1] { 0 } else { 1 };
        Some(if speed[2] > speed[most] { 2 } else { most })
    }

    /// Magnitudes of the rays' directions along `axis`, always positive; 1 in inactive lanes.
    #[inline(always)]
    pub(crate) fn scale(&self, axis: usize) -> Float {
        let one = Float::splat(1.0);
        self.only(one / self.setup.slab.steepness[axis], one)
    }

    /// `value` in active lanes, `none` in the others.
    #[inline(always)]
    pub(crate) fn only(&self, value: Float, none: Float) -> Float {
        Mask::from_bits(self.setup.active).select(value, none)
    }

    #[inline(always)]
    pub(crate) fn t_min(&self) -> Float {
        self.setup.ray.t_min
    }

    #[inline(always)]
    pub(crate) fn steepness(&self, axis: usize) -> Float {
        self.setup.slab.steepness[axis]
    }

    /// Coordinates of the origins on `axis`, negated if `sign` is −1. Returns them with the slack
    /// added, and with it subtracted.
    #[inline(always)]
    pub(crate) fn slab_origins(&self, axis: usize, sign: Float) -> (Float, Float) {
        let origin = self.setup.ray.origin[axis] * sign;
        let slack = self.setup.slab.slack;
        (origin + slack, origin - slack)
    }
}
