//! The points that rays hit, over lanes: of any primitives of one shape, one a lane.

use std::sync::Arc;

use glam::Vec3;

use crate::geometry::{Geometry, Primitive, Quad, Ray};
use crate::math::UNIT_ROUNDOFF;
use crate::simd::{Float, Indices, Int, LANES, Lanes, Quad as Words, Vec3x, axes, quad};

/// One [`Surface`](crate::geometry::Surface) a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceLanes {
    pub(crate) point: Vec3x,
    pub(crate) normal: Vec3x,
    pub(crate) offset: Float,
}

/// Where rays are that have hit something.
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
}

/// What primitives have in common that are shaded together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    Sphere,
    MovingSphere,
    Quad,
    Triangle,
}

impl Shape {
    pub(crate) fn of(primitive: Primitive<'_>) -> Self {
        match primitive {
            Primitive::Sphere(sphere) if sphere.motion() == Vec3::ZERO => Self::Sphere,
            Primitive::Sphere(_) => Self::MovingSphere,
            Primitive::Quad(_) => Self::Quad,
            Primitive::Triangle(_) => Self::Triangle,
        }
    }
}

/// Geometry in words, from which the surfaces of any primitives are gathered.
#[derive(Debug)]
pub(crate) struct Surfaces {
    geometry: Arc<Geometry>,
    /// Centre at time 0, radius.
    spheres: Vec<Words>,
    /// Where any sphere moves.
    motions: Vec<Words>,
    /// Corner, offset; edges, dual edges, beside each a component of the normal.
    quads: Vec<[Words; 5]>,
}

impl Surfaces {
    pub(crate) fn new(geometry: &Arc<Geometry>) -> Self {
        let parallelogram = |q: &Quad| {
            let ([dual_u, dual_v], [x, y, z]) = (q.duals(), q.normal.to_array());
            [quad(q.q, q.offset()), quad(q.u, x), quad(q.v, y), quad(dual_u, z), quad(dual_v, 0.0)]
        };
        let spheres = &geometry.spheres;
        let moving = if geometry.moves() { &spheres[..] } else { &[] };
        Self {
            geometry: Arc::clone(geometry),
            // That is where a still sphere is at any time, a zero's sign included.
            spheres: spheres.iter().map(|s| quad(s.center_at(0.0), s.radius)).collect(),
            motions: moving.iter().map(|s| quad(s.motion(), 0.0)).collect(),
            quads: geometry.quads.iter().map(parallelogram).collect(),
        }
    }

    /// [`Primitive::surface`] of primitives of one shape.
    #[inline(always)]
    pub(crate) fn find(&self, shape: Shape, hits: &HitPoints) -> SurfaceLanes {
        match shape {
            Shape::Sphere => self.spheres::<false>(hits),
            Shape::MovingSphere => self.spheres::<true>(hits),
            Shape::Quad => self.quads(hits),
            Shape::Triangle => self.triangles(hits),
        }
    }

    #[inline(always)]
    fn spheres<const MOVING: bool>(&self, hits: &HitPoints) -> SurfaceLanes {
        let indices = Indices::new(Int::new(hits.primitive), self.spheres.len());
        let (mut center, radius) = indices.gather(&self.spheres, |sphere| sphere);
        if MOVING {
            let (motion, _) = indices.gather(&self.motions, |motion| motion);
            center = center + motion * hits.time;
        }
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
    fn quads(&self, hits: &HitPoints) -> SurfaceLanes {
        let number = Int::new(hits.primitive) - Int::splat(self.spheres.len() as u32);
        let indices = Indices::new(number, self.quads.len());
        let part = |i: usize| indices.gather(&self.quads, |quad| &quad[i]);
        let ((q, offset), (u, x), (v, y)) = (part(0), part(1), part(2));
        let ((dual_u, z), (dual_v, _)) = (part(3), part(4));
        let p = (hits.origin - q) + hits.direction * hits.t;
        let (a, b) = (p.dot(dual_u), p.dot(dual_v));
        SurfaceLanes { point: q + (u * a + v * b), normal: Vec3x([x, y, z]), offset }
    }

    /// One by one: they are in f64.
    fn triangles(&self, hits: &HitPoints) -> SurfaceLanes {
        let vector = |v: Vec3x| axes(|axis| v[axis].to_array());
        let (origin, direction) = (vector(hits.origin), vector(hits.direction));
        let (time, t) = (hits.time.to_array(), hits.t.to_array());
        let (mut point, mut normal, mut offset) =
            ([[0.0; LANES]; 3], [[0.0; LANES]; 3], [0.0; LANES]);
        for lane in 0..LANES {
            let at = |v: &[Lanes; 3]| Vec3::new(v[0][lane], v[1][lane], v[2][lane]);
            let ray = Ray { origin: at(&origin), direction: at(&direction), time: time[lane] };
            let surface = self.geometry.get(hits.primitive[lane]).surface(&ray, t[lane]);
            for axis in 0..3 {
                point[axis][lane] = surface.point[axis];
                normal[axis][lane] = surface.normal[axis];
            }
            offset[lane] = surface.offset;
        }
        let offset = Float::new(offset);
        SurfaceLanes { point: Vec3x::new(&point), normal: Vec3x::new(&normal), offset }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Hit, Sphere, Triangle};
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
            geometry.spheres.push(Sphere::still(vector(5.0), radius));
            geometry.quads.extend(Quad::new(vector(5.0), vector(3.0), vector(3.0)));
            geometry.triangles.push(Triangle { vertices: [vector(5.0), vector(5.0), vector(5.0)] });
        }
        let geometry = Arc::new(geometry);
        let surfaces = Surfaces::new(&geometry);
        let mut counts = [0; 4];
        // Hits wait until they fill lanes.
        let mut waiting: [Vec<(Ray, Hit)>; 4] = Default::default();
        while counts.iter().any(|&count| count < 100) {
            let shape = loop {
                let (origin, to) = (vector(8.0), vector(4.0));
                let ray = Ray { origin, direction: to - origin, time: to.x.abs() * 0.25 };
                let hit = geometry.closest_by_brute_force(&ray, 0.0, f32::INFINITY);
                let Some(hit) = hit else { continue };
                let shape = Shape::of(geometry.get(hit.primitive));
                let waiting = &mut waiting[shape as usize];
                waiting.push((ray, hit));
                if waiting.len() == LANES {
                    break shape;
                }
            };
            counts[shape as usize] += 1;
            let mut full = waiting[shape as usize].drain(..);
            let full: [(Ray, Hit); LANES] =
                std::array::from_fn(|_| full.next().expect("as many as lanes"));
            let lanes = |of: fn(&Ray) -> Vec3| {
                Vec3x(axes(|axis| Float::new(full.map(|(ray, _)| of(&ray)[axis]))))
            };
            let hits = HitPoints {
                origin: lanes(|ray| ray.origin),
                direction: lanes(|ray| ray.direction),
                time: Float::new(full.map(|(ray, _)| ray.time)),
                t: Float::new(full.map(|(_, hit)| hit.t)),
                primitive: full.map(|(_, hit)| hit.primitive),
            };
            let found = surfaces.find(shape, &hits);
            let spawned = found.spawn(found.normal);
            for (lane, (ray, hit)) in full.iter().enumerate() {
                let want = geometry.get(hit.primitive).surface(ray, hit.t);
                let at = |v: Vec3x| axes(|axis| v[axis].to_array()[lane]).map(f32::to_bits);
                let bits = |v: Vec3| v.to_array().map(f32::to_bits);
                assert_eq!(at(found.point), bits(want.point), "{want:?}");
                assert_eq!(at(found.normal), bits(want.normal), "{want:?}");
                assert_eq!(found.offset.to_array()[lane].to_bits(), want.offset.to_bits());
                assert_eq!(at(spawned), bits(want.spawn(want.normal)));
            }
        }
    }
}
