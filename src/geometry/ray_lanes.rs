//! Rays in lanes, for testing many rays against one primitive, or one ray against many.
//!
//! Each test returns the same bits as the scalar test of the same primitive. It runs the same
//! operations in the same order, with masks instead of branches; a test that deviates documents why
//! the result is the same. Lanes that hold NaN miss.

use crate::math::{Real, UNIT_ROUNDOFF};
use crate::simd::{Float, Mask, Vec3x};

/// The ray data for sphere and quad tests: [`super::PreparedRay`] without the shear.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayLanes {
    pub(crate) origin: Vec3x,
    pub(crate) direction: Vec3x,
    pub(crate) time: Float,
    pub(crate) length2: Float,
    pub(crate) inv_length2: Float,
    /// `inv_length2` padded by [`padded_inv_length2`].
    pub(crate) padded_inv_length2: Float,
    /// Lower ends of the open intervals, at least 0.
    pub(crate) t_min: Float,
}

impl RayLanes {
    pub(crate) const NONE: Self = Self {
        origin: Vec3x::ZERO,
        direction: Vec3x::ZERO,
        time: Float::ZERO,
        length2: Float::ZERO,
        inv_length2: Float::ZERO,
        padded_inv_length2: Float::INFINITY,
        t_min: Float::ZERO,
    };

    #[inline(always)]
    pub(crate) fn new(origin: Vec3x, direction: Vec3x, time: Float, t_min: Float) -> Self {
        let length2 = direction.dot(direction);
        let inv_length2 = Float::splat(1.0) / length2;
        let padded_inv_length2 = padded_inv_length2(inv_length2);
        Self { origin, direction, time, length2, inv_length2, padded_inv_length2, t_min }
    }
}

/// Distances of hits, valid only in the lanes of the mask `hit`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HitLanes {
    pub(crate) t: Float,
    pub(crate) hit: Mask,
}

/// 1/d·d, enlarged by the margin of [`misses`](super::sphere::lanes::misses).
#[inline(always)]
fn padded_inv_length2(inv_length2: Float) -> Float {
    inv_length2 * Float::splat(1.0 + 72.0 * UNIT_ROUNDOFF)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::quad::lanes::{QuadLanes, QuadTest, SpecialQuad};
    use crate::geometry::sphere::lanes::{hits, misses, padded_radius2};
    use crate::geometry::triangle::lanes::{Levels, shear};
    use crate::geometry::{
        Geometry, PreparedRay, Primitive, PrimitiveModel, Quad, Ray, Sphere, Triangle,
    };
    use crate::math::Stream;
    use crate::simd::{LANES, axes};
    use glam::Vec3;

    /// A random number of varying magnitude, sometimes an edge case of rounding.
    fn number(random: &mut Stream) -> f32 {
        let value = random.between(-2.0, 2.0);
        match random.bits() % 12 {
            0 => 0.0,
            1 => -0.0,
            2 => 1.0,
            3 => value * 1e-6,
            4 => value * 1e6,
            _ => value,
        }
    }

    fn vector(random: &mut Stream) -> Vec3 {
        Vec3::new(number(random), number(random), number(random))
    }

    fn lanes(vectors: &[Vec3]) -> Vec3x {
        Vec3x::of_lanes(&axes(|axis| std::array::from_fn(|lane| vectors[lane][axis])))
    }

    /// Checks that the lane tests of primitive and ray number i agree bit by bit with the scalar
    /// tests.
    fn check(rays: &[Ray], primitives: &Geometry, t_min: f32) {
        let prepared: Vec<PreparedRay> = rays.iter().map(PreparedRay::new).collect();
        let float = |f: &dyn Fn(usize) -> f32| Float::new(std::array::from_fn(f));
        let ray = RayLanes {
            origin: lanes(&prepared.iter().map(|p| p.ray.origin).collect::<Vec<_>>()),
            direction: lanes(&prepared.iter().map(|p| p.ray.direction).collect::<Vec<_>>()),
            time: float(&|i| prepared[i].ray.time),
            length2: float(&|i| prepared[i].length2),
            inv_length2: float(&|i| prepared[i].inv_length2),
            padded_inv_length2: padded_inv_length2(float(&|i| prepared[i].inv_length2)),
            t_min: Float::splat(t_min),
        };
        let compare = |hits: Option<HitLanes>, primitive: &dyn Fn(usize) -> Primitive| {
            for lane in 0..LANES {
                let scalar = primitive(lane).intersect(&prepared[lane], t_min, f32::INFINITY);
                let vector = hits.and_then(|HitLanes { t, hit }| {
                    (hit.bits() >> lane & 1 == 1).then(|| t.to_array()[lane])
                });
                let vector = vector.filter(|t| *t < f32::INFINITY);
                let bits = |t: Option<f32>| t.map(f32::to_bits);
                assert_eq!(bits(vector), bits(scalar), "{:?} {:?}", primitive(lane), rays[lane]);
            }
        };
        let Geometry { spheres, quads, triangles, .. } = primitives;
        let centers: Vec<Vec3> = (0..LANES).map(|i| spheres[i].center_at(rays[i].time)).collect();
        let radius = float(&|i| spheres[i].radius);
        let one = |lane: usize| Primitive::Sphere(spheres[lane]);
        compare(hits::<false>(&ray, lanes(&centers), radius), &one);
        compare(hits::<true>(&ray, lanes(&centers), radius), &one);
        let near = !Mask::from_bits(misses(&ray, lanes(&centers), padded_radius2(radius)));
        let found = hits::<false>(&ray, lanes(&centers), radius);
        compare(found.map(|HitLanes { t, hit }| HitLanes { t, hit: hit & near }), &one);

        let of = |f: &dyn Fn(&Quad) -> Vec3| lanes(&quads.iter().map(f).collect::<Vec<_>>());
        let quad_lanes = QuadLanes {
            q: of(&|quad| quad.q),
            normal: of(&|quad| quad.normal),
            dual_u: of(&|quad| quad.duals()[0]),
            dual_v: of(&|quad| quad.duals()[1]),
        };
        let crossed = |quad: &dyn QuadTest| {
            let t = quad.distance(&ray);
            Some(HitLanes { t, hit: t.gt(ray.t_min) & quad.contains(&ray, t) })
        };
        compare(crossed(&quad_lanes), &|lane| Primitive::Quad(quads[lane]));
        // Test each special quad against all rays.
        for one in quads {
            let found = match &SpecialQuad::new(one) {
                Some(SpecialQuad::Aligned(quad)) => crossed(quad),
                Some(SpecialQuad::Level(quad)) => crossed(quad),
                Some(SpecialQuad::Upright(quad)) => crossed(quad),
                None => continue,
            };
            compare(found, &|_| Primitive::Quad(*one));
        }

        // All lanes share one order of axes, so test one ray against all triangles.
        let PreparedRay { axes: order, shear: turned, .. } = prepared[0];
        let splat = |v: Vec3| axes(|axis| Float::splat(v[axis]));
        let vertices = axes(|i| {
            let vertex = lanes(&triangles.iter().map(|t| t.vertices[i]).collect::<Vec<_>>());
            axes(|axis| vertex[order[axis]])
        });
        let origin = axes(|axis| splat(rays[0].origin)[order[axis]]);
        let sheared = shear(origin, Vec3x(splat(turned)), vertices);
        let mut distances = [f32::NAN; LANES];
        let all = crate::simd::first_bits(LANES);
        sheared.decide::<false>(sheared.candidates(all), |lane, t| distances[lane] = t);
        let mut selected = [f32::NAN; LANES];
        sheared.decide::<true>(sheared.candidates(all), |lane, t| selected[lane] = t);
        let direction = splat(rays[0].direction);
        let levels = Levels::new(origin, |axis| direction[order[axis]], &vertices, all);
        let at_once = sheared.distances(all).to_array();
        let alone = |lane: usize| sheared.distances(1 << lane).to_array()[lane];
        for (lane, triangle) in triangles.iter().enumerate() {
            let scalar = triangle.intersect(&prepared[0], f32::NEG_INFINITY, f32::INFINITY);
            for vector in [distances[lane], selected[lane], at_once[lane], alone(lane)] {
                let vector = Some(levels.distance(lane, vector)).filter(|t| t.is_finite());
                assert_eq!(
                    vector.map(f32::to_bits),
                    scalar.map(f32::to_bits),
                    "{triangle:?} {:?}",
                    rays[0]
                );
            }
        }
    }

    #[test]
    fn lanes_agree_with_scalars() {
        let (mut random, mut uprights, mut aligned, mut level) = (Stream::new(77), 0, 0, 0);
        for round in 0..20_000 {
            let rays: Vec<Ray> = (0..LANES)
                .map(|_| Ray {
                    origin: vector(&mut random),
                    direction: vector(&mut random),
                    time: random.uniform(),
                })
                .collect();
            let mut primitives = Geometry::default();
            for _ in 0..LANES {
                let (center, motion) = (vector(&mut random), vector(&mut random));
                let radius = crate::math::max(number(&mut random).abs(), 1e-3);
                primitives.spheres.push(Sphere { center, center1: center + motion, radius });
                // A mix of aligned, level, upright and general quads.
                let (along, zeros) = (random.bits() as usize % 3, random.bits() as usize % 4);
                let quad = loop {
                    let (mut u, mut v) = (vector(&mut random), vector(&mut random));
                    if zeros > 0 {
                        u[along] = 0.0;
                    }
                    match zeros {
                        0 => {}
                        1 => v[along] = -0.0,
                        _ => v = Vec3::AXES[along] * v[along],
                    }
                    if zeros > 2 {
                        u[(along + 1) % 3] = -0.0;
                    }
                    let (u, v) = if random.bits() % 2 == 0 { (u, v) } else { (v, u) };
                    if let Some(quad) = Quad::new(vector(&mut random), u, v) {
                        break quad;
                    }
                };
                match SpecialQuad::new(&quad) {
                    Some(SpecialQuad::Aligned(_)) => aligned += 1,
                    Some(SpecialQuad::Level(_)) => level += 1,
                    Some(SpecialQuad::Upright(_)) => uprights += 1,
                    None => {}
                }
                primitives.quads.push(quad);
                let vertices = [(); 3].map(|()| vector(&mut random));
                primitives.triangles.push(Triangle { vertices });
            }
            check(&rays, &primitives, if round % 3 == 0 { 0.5 } else { 0.0 });
        }
        assert!(uprights > 3000 * LANES, "only {uprights} upright quads");
        assert!(aligned > 2000 * LANES, "only {aligned} aligned quads");
        assert!(level > 2000 * LANES, "only {level} level quads");
    }
}
