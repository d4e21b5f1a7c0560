//! The points that rays hit, over lanes: of any primitives, one a lane.

use glam::Vec3;

use crate::geometry::{Geometry, Quad, Ray, Sphere};
use crate::math::UNIT_ROUNDOFF;
use crate::simd::{Bits, Float, LANES, Lanes, Mask, Vec3x, axes};

/// One [`Surface`](crate::geometry::Surface) a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceLanes {
    pub(crate) point: Vec3x,
    pub(crate) normal: Vec3x,
    pub(crate) offset: Float,
}

/// Where rays are, in the lanes that have hit something.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HitPoints {
    pub(crate) origin: Vec3x,
    pub(crate) direction: Vec3x,
    pub(crate) time: Float,
    pub(crate) t: Float,
    pub(crate) primitive: Lanes<u32>,
}

impl SurfaceLanes {
    /// [`Surface::spawn`](crate::geometry::Surface::spawn).
    #[inline(always)]
    pub(crate) fn spawn(&self, side: Vec3x) -> Vec3x {
        self.point + side * self.offset
    }

    fn select(mask: Mask, yes: Self, no: Self) -> Self {
        Self {
            point: Vec3x::select(mask, yes.point, no.point),
            normal: Vec3x::select(mask, yes.normal, no.normal),
            offset: mask.select(yes.offset, no.offset),
        }
    }
}

/// [`Primitive::surface`](crate::geometry::Primitive::surface) in the lanes of `present`; anything
/// in others.
#[inline(always)]
pub(crate) fn surfaces(geometry: &Geometry, hits: &HitPoints, present: u32) -> SurfaceLanes {
    let (mut spheres, mut quads) = (0, 0);
    let ends = (geometry.spheres.len(), geometry.spheres.len() + geometry.quads.len());
    for lane in Bits(present) {
        let primitive = hits.primitive[lane] as usize;
        spheres |= u32::from(primitive < ends.0) << lane;
        quads |= u32::from(primitive >= ends.0 && primitive < ends.1) << lane;
    }
    let triangles = present & !spheres & !quads;
    let mut found = SurfaceLanes { point: Vec3x::ZERO, normal: Vec3x::ZERO, offset: Float::ZERO };
    if spheres != 0 {
        found = sphere_surfaces(&geometry.spheres, hits, spheres);
    }
    if quads != 0 {
        let quad_surfaces = quad_surfaces(&geometry.quads, ends.0, hits, quads);
        found = SurfaceLanes::select(Mask::from_bits(quads), quad_surfaces, found);
    }
    if triangles != 0 {
        let triangle_surfaces = triangle_surfaces(geometry, hits, triangles);
        found = SurfaceLanes::select(Mask::from_bits(triangles), triangle_surfaces, found);
    }
    found
}

/// `N` vectors and a number for each lane of `lanes`; 0 in others.
#[inline(always)]
fn gather<const N: usize>(
    lanes: u32,
    of: impl Fn(usize) -> ([Vec3; N], f32),
) -> ([Vec3x; N], Float) {
    let (mut vectors, mut numbers) = ([[[0.0; LANES]; 3]; N], [0.0; LANES]);
    for lane in Bits(lanes) {
        let (from, number) = of(lane);
        for (vector, from) in vectors.iter_mut().zip(from) {
            for axis in 0..3 {
                vector[axis][lane] = from[axis];
            }
        }
        numbers[lane] = number;
    }
    (vectors.map(|vector| Vec3x::new(&vector)), Float::new(numbers))
}

#[inline(always)]
fn sphere_surfaces(spheres: &[Sphere], hits: &HitPoints, lanes: u32) -> SurfaceLanes {
    let ([center, motion], radius) = gather(lanes, |lane| {
        let sphere = &spheres[hits.primitive[lane] as usize];
        ([sphere.center, sphere.motion()], sphere.radius)
    });
    let center = center + motion * hits.time;
    let normal = (hits.origin + hits.direction * hits.t - center).normalize();
    let far = Vec3x(axes(|axis| center[axis].abs())).max_element();
    let extent = far.max(radius);
    let bound = Float::splat(10.0) * radius + Float::splat(6.0) * extent;
    SurfaceLanes {
        point: center + normal * radius,
        normal,
        offset: Float::splat(UNIT_ROUNDOFF) * bound,
    }
}

#[inline(always)]
fn quad_surfaces(quads: &[Quad], first: usize, hits: &HitPoints, lanes: u32) -> SurfaceLanes {
    let ([q, u, v, normal, dual_u, dual_v], offset) = gather(lanes, |lane| {
        let quad = &quads[hits.primitive[lane] as usize - first];
        let [dual_u, dual_v] = quad.duals();
        ([quad.q, quad.u, quad.v, quad.normal, dual_u, dual_v], quad.offset())
    });
    let p = (hits.origin - q) + hits.direction * hits.t;
    let (a, b) = (p.dot(dual_u), p.dot(dual_v));
    SurfaceLanes { point: q + (u * a + v * b), normal, offset }
}

/// One by one: they are in f64.
#[inline(always)]
fn triangle_surfaces(geometry: &Geometry, hits: &HitPoints, lanes: u32) -> SurfaceLanes {
    let vector = |v: Vec3x| axes(|axis| v[axis].to_array());
    let (origin, direction) = (vector(hits.origin), vector(hits.direction));
    let (time, t) = (hits.time.to_array(), hits.t.to_array());
    let ([point, normal], offset) = gather(lanes, |lane| {
        let at = |v: &[Lanes; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
        let ray = Ray { origin: at(&origin), direction: at(&direction), time: time[lane] };
        let surface = geometry.get(hits.primitive[lane]).surface(&ray, t[lane]);
        ([surface.point, surface.normal], surface.offset)
    });
    SurfaceLanes { point, normal, offset }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Triangle;
    use crate::math::random::Stream;

    #[test]
    fn lanes_are_the_scalar_surfaces() {
        let mut random = Stream::new(14);
        let mut vector =
            |size: f32| Vec3::from_array([(); 3].map(|()| random.between(-size, size)));
        let mut geometry = Geometry::default();
        for _ in 0..40 {
            let center = vector(5.0);
            let radius = vector(1.0).length_squared() + 0.1;
            geometry.spheres.push(Sphere { center, center1: center + vector(1.0), radius });
            geometry.quads.extend(Quad::new(vector(5.0), vector(3.0), vector(3.0)));
            geometry.triangles.push(Triangle { vertices: [vector(5.0), vector(5.0), vector(5.0)] });
        }
        let mut counts = [0; 3];
        for round in 0..5000u32 {
            let mut rays = [Ray { origin: Vec3::ZERO, direction: Vec3::Z, time: 0.0 }; LANES];
            let (mut t, mut primitive, mut present) = ([0.0; LANES], [0; LANES], 0);
            for lane in 0..LANES {
                let (origin, to) = (vector(8.0), vector(4.0));
                rays[lane] = Ray { origin, direction: to - origin, time: to.x.abs() * 0.25 };
                let hit = geometry.closest_by_brute_force(&rays[lane], 0.0, f32::INFINITY);
                let Some(hit) = hit else { continue };
                // Of one kind, mostly, or of all.
                let kind = match hit.primitive as usize {
                    p if p < 40 => 0,
                    p if p < 40 + geometry.quads.len() => 1,
                    _ => 2,
                };
                if round % 4 == 3 || round % 4 == kind {
                    counts[kind as usize] += 1;
                    (t[lane], primitive[lane]) = (hit.t, hit.primitive);
                    present |= 1 << lane;
                }
            }
            let lanes = |of: fn(&Ray) -> Vec3| {
                Vec3x(axes(|axis| Float::new(rays.map(|ray| of(&ray)[axis]))))
            };
            let hits = HitPoints {
                origin: lanes(|ray| ray.origin),
                direction: lanes(|ray| ray.direction),
                time: Float::new(rays.map(|ray| ray.time)),
                t: Float::new(t),
                primitive,
            };
            let found = surfaces(&geometry, &hits, present);
            let spawned = found.spawn(found.normal);
            for lane in Bits(present) {
                let want = geometry.get(primitive[lane]).surface(&rays[lane], t[lane]);
                let at = |v: Vec3x| axes(|axis| v[axis].to_array()[lane]).map(f32::to_bits);
                let bits = |v: Vec3| v.to_array().map(f32::to_bits);
                assert_eq!(at(found.point), bits(want.point), "{want:?}");
                assert_eq!(at(found.normal), bits(want.normal), "{want:?}");
                assert_eq!(found.offset.to_array()[lane].to_bits(), want.offset.to_bits());
                assert_eq!(at(spawned), bits(want.spawn(want.normal)));
            }
        }
        assert!(counts.iter().all(|&count| count > 1000), "{counts:?} hits");
    }
}
