//! Rays and hits in structure-of-arrays form, as kernels read and write them.

use glam::Vec3;

use crate::geometry::{Hit, Ray};
use crate::math::Real;
use crate::simd::{Float, LANES, Vec3x, axes, set_lanes};

/// Rays, each with the open interval in which hits count.
///
/// The arrays are padded so that a whole vector can be loaded starting at any ray. The values in
/// the padding are meaningless.
#[derive(Clone, Debug, Default)]
pub struct RayBatch {
    len: usize,
    pub(super) origin: [Vec<f32>; 3],
    pub(super) direction: [Vec<f32>; 3],
    pub(super) time: Vec<f32>,
    pub(super) t_min: Vec<f32>,
    pub(super) t_max: Vec<f32>,
}

impl RayBatch {
    /// Number of rays.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether the batch contains no rays.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Adds a ray.
    ///
    /// # Panics
    /// If `t_min` is negative, or if the batch already holds 2^32 − 1 rays.
    pub fn push(&mut self, ray: &Ray, t_min: f32, t_max: f32) {
        assert!(!(t_min < 0.0), "t_min must be 0 or more, but is {t_min}");
        assert!(self.len < u32::MAX as usize, "a batch holds at most 2^32 − 1 rays");
        let index = self.len;
        self.len += 1;
        if self.len + LANES > self.time.len() {
            // This rarely allocates, since `Vec` at least doubles its capacity whenever it grows.
            let padded = (self.len + LANES).next_multiple_of(LANES);
            self.arrays().for_each(|array| array.resize(padded, f32::NAN));
        }
        for axis in 0..3 {
            self.origin[axis][index] = ray.origin[axis];
            self.direction[axis][index] = ray.direction[axis];
        }
        self.time[index] = ray.time;
        self.t_min[index] = t_min;
        self.t_max[index] = t_max;
    }

    /// Creates an empty batch with room for `capacity` rays.
    pub(crate) fn with_capacity(capacity: usize) -> Self {
        let mut batch = Self::default();
        let padded = (capacity + LANES).next_multiple_of(LANES);
        batch.arrays().for_each(|array| array.resize(padded, f32::NAN));
        batch
    }

    /// Removes all rays.
    pub(crate) fn clear(&mut self) {
        self.len = 0;
    }

    /// Adds the rays of the lanes whose bits are set. The arrays must have room for a whole vector
    /// after the last ray.
    #[inline(always)]
    pub(crate) fn append(&mut self, rays: &RayVector, bits: u32) {
        let (set_lanes, first) = (set_lanes(bits), self.len);
        let mut to = self.arrays();
        for number in rays.numbers() {
            let array = to.next().expect("one array for each number of a ray");
            number.shuffled(set_lanes).store(&mut array[first..]);
        }
        drop(to);
        self.len += bits.count_ones() as usize;
    }

    /// Adds the rays of the first `count` lanes. The arrays must have room for a whole vector after
    /// the last ray.
    #[inline(always)]
    pub(crate) fn extend(&mut self, rays: &RayVector, count: usize) {
        let first = self.len;
        for axis in 0..3 {
            rays.origin[axis].store(&mut self.origin[axis][first..]);
            rays.direction[axis].store(&mut self.direction[axis][first..]);
        }
        rays.time.store(&mut self.time[first..]);
        rays.t_min.store(&mut self.t_min[first..]);
        rays.t_max.store(&mut self.t_max[first..]);
        self.len += count;
    }

    /// Loads a vector of rays starting at index `first`. Lanes beyond the last ray contain NaN or
    /// stale values.
    #[inline(always)]
    pub(crate) fn vector(&self, first: usize) -> RayVector {
        let load = |array: &Vec<f32>| Float::load(&array[first..]);
        let vector = |arrays: &[Vec<f32>; 3]| Vec3x(axes(|axis| load(&arrays[axis])));
        RayVector {
            origin: vector(&self.origin),
            direction: vector(&self.direction),
            time: load(&self.time),
            t_min: load(&self.t_min),
            t_max: load(&self.t_max),
        }
    }

    /// Replaces the contents with the rays of `from` at the indices `order`. The arrays must have room
    /// for them.
    pub(crate) fn reorder(&mut self, from: &mut Self, order: &[u32]) {
        for (to, from) in self.arrays().zip(from.arrays()) {
            for (to, &index) in to[..order.len()].iter_mut().zip(order) {
                *to = from[index as usize];
            }
        }
        self.len = order.len();
    }

    fn arrays(&mut self) -> impl Iterator<Item = &mut Vec<f32>> {
        let others = [&mut self.time, &mut self.t_min, &mut self.t_max];
        self.origin.iter_mut().chain(&mut self.direction).chain(others)
    }

    /// Returns ray `index`, its `t_min` and its `t_max`.
    ///
    /// # Panics
    /// If `index` is not less than [`Self::len`].
    pub fn get(&self, index: usize) -> (Ray, f32, f32) {
        assert!(index < self.len, "ray {index} is out of range: the batch has {} rays", self.len);
        let vector = |arrays: &[Vec<f32>; 3]| {
            Vec3::new(arrays[0][index], arrays[1][index], arrays[2][index])
        };
        let (origin, direction) = (vector(&self.origin), vector(&self.direction));
        let ray = Ray { origin, direction, time: self.time[index] };
        (ray, self.t_min[index], self.t_max[index])
    }
}

/// A vector of rays.
pub(crate) struct RayVector {
    pub(crate) origin: Vec3x,
    pub(crate) direction: Vec3x,
    pub(crate) time: Float,
    pub(crate) t_min: Float,
    pub(crate) t_max: Float,
}

impl RayVector {
    /// Creates rays whose intervals contain all positive distances.
    #[inline(always)]
    pub(crate) fn unbounded(ray: Ray<Float>) -> Self {
        let Ray { origin, direction, time } = ray;
        Self { origin, direction, time, t_min: Float::ZERO, t_max: Float::INFINITY }
    }

    #[inline(always)]
    pub(crate) fn ray(&self) -> Ray<Float> {
        Ray { origin: self.origin, direction: self.direction, time: self.time }
    }

    #[inline(always)]
    pub(super) fn numbers(&self) -> [Float; 9] {
        let (o, d) = (&self.origin, &self.direction);
        [o[0], o[1], o[2], d[0], d[1], d[2], self.time, self.t_min, self.t_max]
    }
}

/// The hits of rays: a distance, a primitive and an instance for each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HitBatch {
    /// Distances; +∞ for a miss.
    pub t: Vec<f32>,
    /// Numbers of primitives; [`HitBatch::MISS`] for a miss.
    pub primitive: Vec<u32>,
    /// Indices of instances, see [`Hit::instance`]; empty for scenes without instances.
    pub instance: Vec<u32>,
}

impl HitBatch {
    /// The primitive index that marks a miss.
    pub const MISS: u32 = Hit::MISS;

    /// Creates a batch of `count` misses, for scenes with or without instances.
    pub fn misses(count: usize) -> Self {
        let mut batch = Self::default();
        batch.reset(count, true);
        batch
    }

    /// Whether the hits name instances.
    pub(crate) fn has_instances(&self) -> bool {
        !self.instance.is_empty()
    }

    /// Replaces the contents with `count` misses, for scenes without instances unless `instanced`
    /// is set.
    pub fn reset(&mut self, count: usize, instanced: bool) {
        self.instance.clear();
        self.instance.resize(if instanced { count } else { 0 }, 0);
        self.t.clear();
        self.t.resize(count, f32::INFINITY);
        self.primitive.clear();
        self.primitive.resize(count, Self::MISS);
    }

    /// Number of rays, including those that miss.
    pub fn len(&self) -> usize {
        self.primitive.len()
    }

    /// Whether the batch has neither hits nor misses.
    pub fn is_empty(&self) -> bool {
        self.primitive.is_empty()
    }

    /// Adds the hit of a ray, or a miss.
    pub fn push(&mut self, hit: Option<Hit>) {
        self.t.push(hit.map_or(f32::INFINITY, |hit| hit.t));
        self.primitive.push(hit.map_or(Self::MISS, |hit| hit.primitive));
        self.instance.push(hit.map_or(0, |hit| hit.instance));
    }

    /// Returns the hit of ray `index`, or `None` if it misses.
    pub fn get(&self, index: usize) -> Option<Hit> {
        let (t, primitive) = (self.t[index], self.primitive[index]);
        let instance = self.instance.get(index).copied().unwrap_or(0);
        (primitive != Self::MISS).then_some(Hit { t, primitive, instance })
    }

    /// Sets the hit of ray `index`.
    pub(crate) fn set(&mut self, index: usize, hit: Hit) {
        (self.t[index], self.primitive[index]) = (hit.t, hit.primitive);
        if let Some(instance) = self.instance.get_mut(index) {
            *instance = hit.instance;
        }
    }
}
