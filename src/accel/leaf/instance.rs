//! Leaf blocks of instances: a ray is transformed into the object spaces of all of them at once.

use super::{Leaf, Meshes, numbers, transpose};
use crate::accel::ray::{Best, Members, OneRay, Packet, RayGroup};
use crate::accel::{Count, ExtentLanes, Setup};
use crate::geometry::{Geometry, ToObject};
use crate::math::Real;
use crate::simd::{Bits, Float, LANES, Lanes, Mask, Vec3x, axes};

#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct LeafBlock {
    /// The rows of the linear map to object space, and the origin of object space.
    to_object: [[Lanes; 3]; 3],
    center: [Lanes; 3],
    /// The middle of the mesh's box in object space, and half its edges.
    middle: [Lanes; 3],
    half: [Lanes; 3],
    mesh: Lanes<u32>,
    instance: Lanes<u32>,
}

impl LeafBlock {
    /// Transforms a ray into all object spaces. Returns the rays, their distances to the boxes of the
    /// meshes, and the lanes whose ray enters its box up to `limit`.
    #[inline(always)]
    fn enter(&self, one: &OneRay<'_>, limit: f32) -> (Setup, Lanes, Mask) {
        let vector = |lanes: &[Lanes; 3]| Vec3x::of_lanes(lanes);
        let rows = axes(|row| vector(&self.to_object[row]));
        let ray = ToObject::<Float> { rows, center: vector(&self.center) }.ray(&one.full_ray());
        let (middle, half) = (vector(&self.middle), vector(&self.half));
        let half_edges = half[0] + half[1] + half[2];
        let extent = ExtentLanes { middle, half_edges, condition: Float::ONE };
        let t_min = one.splat(&one.table.t_min);
        let setup = Setup::in_object_space(ray, t_min, &extent);
        let slab = &setup.slab;
        let (mut entry, mut exit) = (t_min, Float::splat(limit));
        for axis in 0..3 {
            let at = middle[axis].free_mul_sub(slab.inverse[axis], slab.offset[axis]);
            let reach = (half[axis] + slab.slack) * slab.steepness[axis];
            entry = (at - reach).max(entry);
            exit = (at + reach).min(exit);
        }
        (setup, entry.to_array(), entry.le(exit))
    }
}

impl Leaf for LeafBlock {
    fn new(geometry: &Geometry, elements: &[u32]) -> Self {
        let first = geometry.len() as u32;
        let instances = || {
            let of = |&element: &u32| &geometry.instances.list()[(element - first) as usize];
            elements.iter().map(of)
        };
        let maps = || instances().map(|instance| instance.world_to_object());
        let bounds = || instances().map(|of| geometry.instances.mesh_bounds(of.mesh()));
        let middle = |low, high| 0.5 * (low + high);
        let meshes: Vec<u32> = instances().map(|instance| instance.mesh() as u32).collect();
        let numbers_of_instances: Vec<u32> = elements.iter().map(|e| e - first).collect();
        Self {
            to_object: axes(|row| transpose(maps().map(move |map| map.rows[row]))),
            center: transpose(maps().map(|map| map.center)),
            middle: transpose(bounds().map(move |b| middle(b.min, b.max))),
            half: transpose(bounds().map(move |b| {
                let middle = middle(b.min, b.max);
                (b.max - middle).max(middle - b.min)
            })),
            mesh: numbers(&meshes),
            instance: numbers(&numbers_of_instances),
        }
    }

    /// Traces the ray through the meshes whose boxes it enters, nearer boxes first.
    #[inline(never)]
    fn test_one<const ANY: bool>(
        &self,
        valid: u32,
        _: bool,
        one: &OneRay<'_>,
        best: &mut Best,
        meshes: &mut impl Meshes,
        count: &mut impl Count,
    ) {
        let (setup, entry, entered) = self.enter(one, best.t);
        let mut left = entered.bits() & valid;
        if left == 0 {
            return;
        }
        let mut group = RayGroup::new(&setup);
        while left != 0 {
            let nearer = |a: usize, b: usize| if entry[b] < entry[a] { b } else { a };
            let lane = Bits(left).reduce(nearer).expect("a lane is left");
            left &= !(1 << lane);
            if entry[lane] > best.t {
                return;
            }
            let (mesh, instance, first) = (self.mesh[lane], self.instance[lane], meshes.first());
            // Triangles of meshes come after all other primitives.
            let in_later = best.primitive >= first && instance < best.instance;
            group.set_best(lane, best.before(best.found() && in_later));
            meshes.trace::<ANY>((mesh, instance), &mut group, lane, count);
            let within = group.best(lane);
            if within.found() {
                let primitive = first + within.primitive;
                *best = Best { t: within.t, primitive, instance };
                if ANY {
                    return;
                }
            }
        }
    }

    /// Traces the rays one by one.
    #[inline(never)]
    fn test_packet<const V: usize, const ANY: bool, const ALL_MISS: bool, const SPANNING: bool>(
        &self,
        lanes: u32,
        packet: &mut Packet<V>,
        meshes: &mut impl Meshes,
        count: &mut impl Count,
    ) {
        let mut group = RayGroup::<1>::NONE;
        for rays in &mut packet.vectors {
            if rays.looking() == 0 {
                continue;
            }
            let rays = std::slice::from_mut(rays);
            let looking = group.load(rays);
            for ray in Members(looking) {
                count.leaf(LANES as u32, lanes.count_ones());
                let mut best = group.best(ray);
                self.test_one::<ANY>(lanes, false, &group.ray(ray), &mut best, meshes, count);
                group.set_best(ray, best);
            }
            group.store::<ANY>(rays);
        }
    }
}
