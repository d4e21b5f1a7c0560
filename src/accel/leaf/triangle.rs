//! Leaf blocks of triangles.

use glam::Vec3;

use super::{Leaf, Meshes, numbers, transpose};
use crate::accel::Count;
use crate::accel::ray::{Best, OneRay, Packet, Rays};
use crate::geometry::triangle::lanes::{Levels, shear};
use crate::geometry::{Geometry, HitLanes};
use crate::math::Real;
use crate::simd::{Bits, Float, LANES, Lanes, Mask, axes};

#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct LeafBlock {
    vertices: [[Lanes; 3]; 3],
    primitive: Lanes<u32>,
}

impl Leaf for LeafBlock {
    fn new(geometry: &Geometry, primitives: &[u32]) -> Self {
        let first = geometry.first_triangle();
        let mut triangles = [[Vec3::NAN; 3]; LANES];
        for (triangle, &primitive) in triangles.iter_mut().zip(primitives) {
            *triangle = geometry.triangles.vertices(primitive as usize - first);
        }
        let vertex = |i: usize| transpose(triangles.iter().map(|triangle| triangle[i]));
        Self { vertices: axes(vertex), primitive: numbers(primitives) }
    }

    #[inline(always)]
    fn bounds(&self) -> Option<[[Float; 3]; 2]> {
        let vertex = |i: usize, axis: usize| Float::new(self.vertices[i][axis]);
        Some([
            axes(|axis| vertex(0, axis).min(vertex(1, axis)).min(vertex(2, axis))),
            axes(|axis| vertex(0, axis).max(vertex(1, axis)).max(vertex(2, axis))),
        ])
    }

    #[inline(always)]
    fn test_one<const ANY: bool>(
        &self,
        valid: u32,
        few: bool,
        one: &OneRay<'_>,
        best: &mut Best,
        meshes: &mut impl Meshes,
        _: &mut impl Count,
    ) {
        let order = one.axes();
        let origin = axes(|axis| one.splat(&one.table.origin[order[axis]]));
        let vertices = axes(|i| axes(|axis| Float::new(self.vertices[i][order[axis]])));
        let sheared = shear(origin, one.vector(&one.table.shear), vertices);
        let t_min = one.table.t_min[one.lane];
        let verdict = sheared.verdict::<ANY>(valid, Float::splat(t_min), Float::splat(best.t));
        if verdict.possible == 0 {
            return;
        }
        let holes = meshes.may_have_holes();
        let direction = |axis: usize| one.splat(&one.table.direction[order[axis]]);
        let levels = Levels::new(origin, direction, &vertices, verdict.possible);
        if ANY && !holes && verdict.certain != 0 {
            // Only whether there is a hit is read.
            best.primitive = self.primitive[0];
        } else if few && !ANY && !holes && levels.are_none() {
            // No CPU can predict these, unlike what remains of shadow rays.
            sheared.decide::<true>(verdict.possible, |lane, t| {
                best.offer_by_select(t, t_min, self.primitive[lane]);
            });
        } else {
            sheared.decide::<false>(verdict.possible, |lane, t| {
                let (primitive, t) = (self.primitive[lane], levels.distance(lane, t));
                let is_hole = || meshes.is_hole(primitive, || one.scalar_ray(), t);
                if t > t_min && (t > best.t || !is_hole()) {
                    best.offer(t, primitive);
                }
            });
        }
    }

    /// Counts one test for each orientation of a vector of rays, not one for each vector.
    #[inline(always)]
    fn test_packet<const V: usize, const ANY: bool, const ALL_MISS: bool, const SPANNING: bool>(
        &self,
        lanes: u32,
        packet: &mut Packet<V>,
        meshes: &mut impl Meshes,
        count: &mut impl Count,
    ) {
        for lane in Bits(lanes) {
            let primitive = self.primitive[lane];
            for rays in &mut packet.vectors {
                test_rays::<ANY>(rays, &self.vertices, lane, primitive, meshes, count);
            }
        }
    }
}

/// Tests a vector of rays against a triangle, one orientation after the other.
#[inline(always)]
fn test_rays<const ANY: bool>(
    rays: &mut Rays,
    vertices: &[[Lanes; 3]; 3],
    lane: usize,
    primitive: u32,
    meshes: &impl Meshes,
    count: &mut impl Count,
) {
    let looking = rays.looking();
    let (mut t, mut decided) = (Float::ZERO, 0);
    rays.find_orientations();
    for orientation in rays.orientations() {
        count.leaf(LANES as u32, (looking & orientation.rays).count_ones());
        let origin = axes(|axis| rays.setup.ray.origin[orientation.axes[axis]]);
        let vertices =
            axes(|i| axes(|axis| Float::splat(vertices[i][orientation.axes[axis]][lane])));
        let sheared = shear(origin, rays.setup.shear.shear, vertices);
        let candidates = sheared.candidates(orientation.rays);
        if candidates != 0 {
            t = Mask::from_bits(candidates).select(sheared.distances(candidates), t);
            decided |= candidates;
        }
    }
    if decided != 0 {
        let ray = &rays.setup.ray;
        let vertex = |i: usize, axis: usize| vertices[i][axis][lane];
        let level =
            |axis: usize| vertex(0, axis) == vertex(1, axis) && vertex(1, axis) == vertex(2, axis);
        if let Some(axis) = (0..3).find(|&axis| level(axis)) {
            let distance = (Float::splat(vertex(0, axis)) - ray.origin[axis]) / ray.direction[axis];
            t = t.eq(t).select(distance, t);
        }
        let hit = Mask::from_bits(decided) & t.gt(rays.setup.ray.t_min);
        let no_hole = |ray, t| !meshes.is_hole(primitive, || ray, t);
        let hit = if meshes.may_have_holes() { rays.filter(t, hit, no_hole) } else { hit };
        rays.offer::<ANY>(HitLanes { t, hit }, primitive);
    }
}
