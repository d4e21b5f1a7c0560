//! Single rays, taken from a vector of rays.

use glam::Vec3;

use crate::accel::{Setup, Shear};
use crate::geometry::shear_axes;
use crate::geometry::{Ray, RayLanes};
use crate::math::{Real, Word};
use crate::simd::{Float, Int, LANES, Lanes, Vec3x, axes};

/// A vector of prepared rays in memory, read lane by lane.
pub(crate) struct Table {
    pub(crate) origin: [Lanes; 3],
    pub(crate) direction: [Lanes; 3],
    time: Lanes,
    pub(crate) t_min: Lanes,
    length2: Lanes,
    inv_length2: Lanes,
    pub(crate) inverse: [Lanes; 3],
    pub(crate) near_offset: [Lanes; 3],
    pub(crate) far_offset: [Lanes; 3],
    pub(crate) shear: [Lanes; 3],
    /// Whether the direction is negative on each axis.
    down: [[bool; LANES]; 3],
    /// The order of axes in which triangle tests read coordinates.
    axes: [Lanes<u32>; 3],
}

impl Table {
    pub(crate) const NONE: Self = Self {
        origin: [[0.0; LANES]; 3],
        direction: [[0.0; LANES]; 3],
        time: [0.0; LANES],
        t_min: [0.0; LANES],
        length2: [0.0; LANES],
        inv_length2: [0.0; LANES],
        inverse: [[0.0; LANES]; 3],
        near_offset: [[0.0; LANES]; 3],
        far_offset: [[0.0; LANES]; 3],
        shear: [[0.0; LANES]; 3],
        down: [[false; LANES]; 3],
        axes: [[0; LANES]; 3],
    };

    /// Takes over the rays of `setup`. It writes in place, since moving a large value copies it.
    #[inline(always)]
    pub(crate) fn set(&mut self, setup: &Setup) {
        let lanes = |v: Vec3x| axes(|axis| v[axis].to_array());
        let (slab, offsets) = (&setup.slab, setup.offsets());
        let down = axes(|axis| slab.inverse[axis].lt(Float::ZERO));
        let by_sign = |axis: usize, negative: usize, positive: usize| {
            down[axis].select(offsets[negative], offsets[positive]).to_array()
        };
        let Shear { longest: [is_x, is_y, _], negative, .. } = &setup.shear;
        let order = |axis: usize, negative: bool| {
            let of = |longest| Int::splat(shear_axes(longest, negative)[axis] as u32);
            is_x.select(of(0), is_y.select(of(1), of(2)))
        };
        // Names all fields, so that none is forgotten.
        let Self {
            origin,
            direction,
            time,
            t_min,
            length2,
            inv_length2,
            inverse,
            near_offset,
            far_offset,
            shear,
            down: is_down,
            axes: orientation,
        } = self;
        *origin = lanes(setup.ray.origin);
        *direction = lanes(setup.ray.direction);
        *time = setup.ray.time.to_array();
        *t_min = setup.ray.t_min.to_array();
        *length2 = setup.ray.length2.to_array();
        *inv_length2 = setup.ray.inv_length2.to_array();
        *inverse = lanes(setup.slab.inverse);
        *near_offset = axes(|axis| by_sign(axis, axis + 3, axis));
        *far_offset = axes(|axis| by_sign(axis, axis, axis + 3));
        *shear = lanes(setup.shear.shear);
        for (is_down, mask) in is_down.iter_mut().zip(down) {
            let bits = mask.bits();
            for (lane, is_down) in is_down.iter_mut().enumerate() {
                *is_down = bits >> lane & 1 == 1;
            }
        }
        *orientation =
            axes(|axis| negative.select(order(axis, true), order(axis, false)).to_array());
    }
}

/// One ray of a [`Table`]. Its numbers are broadcast to all lanes at each use: a broadcast load
/// from the table is as fast as a register, whereas whole vectors that spill to memory are not.
pub(crate) struct OneRay<'a> {
    pub(crate) table: &'a Table,
    pub(crate) lane: usize,
}

impl<'a> OneRay<'a> {
    #[inline(always)]
    pub(crate) fn new(table: &'a Table, lane: usize) -> Self {
        Self { table, lane }
    }

    /// Whether the direction is negative on `axis`.
    #[inline(always)]
    pub(crate) fn is_down(&self, axis: usize) -> bool {
        self.table.down[axis][self.lane]
    }

    /// The order of axes in which triangle tests read coordinates.
    #[inline(always)]
    pub(crate) fn axes(&self) -> [usize; 3] {
        axes(|axis| self.table.axes[axis][self.lane] as usize)
    }

    #[inline(always)]
    pub(crate) fn splat(&self, lanes: &Lanes) -> Float {
        Float::splat(lanes[self.lane])
    }

    #[inline(always)]
    pub(crate) fn vector(&self, lanes: &[Lanes; 3]) -> Vec3x {
        Vec3x::splat_lane(lanes, self.lane)
    }

    #[inline(always)]
    pub(crate) fn full_ray(&self) -> Ray<Float> {
        let RayLanes { origin, direction, time, .. } = self.ray();
        Ray { origin, direction, time }
    }

    pub(crate) fn scalar_ray(&self) -> Ray {
        let Table { origin, direction, time, .. } = self.table;
        let vector = |lanes: &[Lanes; 3]| Vec3::from_array(axes(|axis| lanes[axis][self.lane]));
        Ray { origin: vector(origin), direction: vector(direction), time: time[self.lane] }
    }

    #[inline(always)]
    pub(crate) fn ray(&self) -> RayLanes {
        RayLanes {
            origin: self.vector(&self.table.origin),
            direction: self.vector(&self.table.direction),
            time: self.splat(&self.table.time),
            length2: self.splat(&self.table.length2),
            inv_length2: self.splat(&self.table.inv_length2),
            t_min: self.splat(&self.table.t_min),
            // Used only to test many rays against one sphere; with ∞, that test rejects no ray.
            padded_inv_length2: Float::INFINITY,
        }
    }
}
