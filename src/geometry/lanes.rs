//! The primitive tests over lanes: many rays against one primitive, or one ray against many.
//!
//! Each function is the scalar test of the same primitive in the same order of operations,
//! with branches turned into masks. Lanes that hold NaN miss.

use super::triangle;
use crate::math::UNIT_ROUNDOFF;
use crate::simd::{Bits, Float, Lanes, Mask, Vec3x, axes};

/// What the sphere and quad tests need of rays: [`super::PreparedRay`] without the shear.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayLanes {
    pub(crate) origin: Vec3x,
    pub(crate) direction: Vec3x,
    pub(crate) time: Float,
    pub(crate) length2: Float,
    pub(crate) inv_length2: Float,
    /// Lower ends of the open intervals.
    pub(crate) t_min: Float,
}

impl RayLanes {
    pub(crate) const NONE: Self = Self {
        origin: Vec3x::ZERO,
        direction: Vec3x::ZERO,
        time: Float::ZERO,
        length2: Float::ZERO,
        inv_length2: Float::ZERO,
        t_min: Float::ZERO,
    };
}

/// Distances of hits, where there are any.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HitLanes {
    pub(crate) t: Float,
    pub(crate) hit: Mask,
}

/// Hits of spheres that are at `center` at the rays' times, above `t_min`; `None` where no
/// lane comes near.
#[inline(always)]
pub(crate) fn sphere(ray: &RayLanes, center: Vec3x, radius: Float) -> Option<HitLanes> {
    let f = ray.origin - center;
    let b = -f.dot(ray.direction);
    let l = f + ray.direction * (b * ray.inv_length2);
    let discriminant = radius * radius - l.dot(l);
    let real = discriminant.ge(Float::ZERO);
    if !real.any() {
        return None;
    }
    let q = b + (ray.length2 * discriminant).sqrt().copysign(b);
    let c = f.dot(f) - radius * radius;
    let (by_product, by_sum) = (c / q, q * ray.inv_length2);
    let ahead = b.gt(Float::ZERO);
    let (near, far) = (ahead.select(by_product, by_sum), ahead.select(by_sum, by_product));
    let t = near.gt(ray.t_min).select(near, far);
    Some(HitLanes { t, hit: real & t.gt(ray.t_min) })
}

/// [`sphere`] behind a filter in free arithmetic, half the work of the test: for lanes of which
/// mostly none comes near.
///
/// With `f` known exactly, r² − l·l is off by less than 13 roundings of f·f here, by less than 16
/// in the test; a ray that is surely outside and goes away hits nothing at distances above 0.
#[inline(always)]
pub(crate) fn filtered_sphere(ray: &RayLanes, center: Vec3x, radius: Float) -> Option<HitLanes> {
    let (Vec3x([fx, fy, fz]), Vec3x([dx, dy, dz])) = (ray.origin - center, ray.direction);
    let away = fz.free_mul_add(dz, fy.free_mul_add(dy, fx * dx));
    let f2 = fz.free_mul_add(fz, fy.free_mul_add(fy, fx * fx));
    let radius2 = radius * (radius * Float::splat(1.0 + 8.0 * UNIT_ROUNDOFF));
    // The tiny number is for underflow.
    let radius2 = radius2 + Float::splat(1e-36);
    // −(f·f − r²) and then −(l·l − r²), both too large by the margin.
    let inside = f2.free_mul_add(Float::splat(-1.0 + 64.0 * UNIT_ROUNDOFF), radius2);
    let discriminant = (away * ray.inv_length2).free_mul_add(away, inside);
    // Negative where both are.
    let missed = discriminant.lt(Float::ZERO) | (inside.lt(Float::ZERO) & away.gt(Float::ZERO));
    if missed.all() { None } else { sphere(ray, center, radius) }
}

/// Quads by what their test needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuadLanes {
    pub(crate) q: Vec3x,
    pub(crate) normal: Vec3x,
    pub(crate) dual_u: Vec3x,
    pub(crate) dual_v: Vec3x,
}

/// Hits of quads above `t_min` and up to `limit`; `None` where no lane meets a plane there.
#[inline(always)]
pub(crate) fn quad(ray: &RayLanes, quad: &QuadLanes, limit: Float) -> Option<HitLanes> {
    let from_corner = ray.origin - quad.q;
    let t = -quad.normal.dot(from_corner) / quad.normal.dot(ray.direction);
    let near = t.gt(ray.t_min) & t.le(limit);
    if !near.any() {
        return None;
    }
    let p = from_corner + ray.direction * t;
    let (a, b) = (p.dot(quad.dual_u), p.dot(quad.dual_v));
    let one = Float::splat(1.0);
    let inside = Float::ZERO.le(a) & a.le(one) & Float::ZERO.le(b) & b.le(one);
    Some(HitLanes { t, hit: near & inside })
}

/// Vertices as their rays see them: sideways, sideways, ahead.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShearedTriangles {
    vertices: [[Float; 3]; 3],
    candidates: Mask,
}

/// Triangles filtered, then decided (contract, rule 1): f32 edge functions whose sign is sure
/// reject nearly all lanes, the rest are decided one by one in f64.
///
/// `origin` and `vertices` are in the order of [`super::PreparedRay`]'s axes, and `shear` is
/// what takes the rays' directions to (0, 0, 1) there.
#[inline(always)]
pub(crate) fn shear_triangles(
    origin: [Float; 3],
    shear: Vec3x,
    vertices: [[Float; 3]; 3],
) -> ShearedTriangles {
    let vertices = axes(|i| {
        let p = axes(|axis| vertices[i][axis] - origin[axis]);
        [p[0] - shear[0] * p[2], p[1] - shear[1] * p[2], shear[2] * p[2]]
    });
    let [a, b, c] = vertices;
    // The error of a b − c d is below that of its two products and its difference, together
    // 2.1 roundings of the larger product (fused: 1.1); the tiny number is for underflow.
    let margin = Float::splat(3.0 * UNIT_ROUNDOFF);
    let tiny = Float::splat(1e-36);
    let edge = |from: [Float; 3], to: [Float; 3]| {
        let subtrahend = from[1] * to[0];
        let value = from[0].free_mul_sub(to[1], subtrahend);
        let error = subtrahend.abs().free_mul_add(margin, tiny) + value.abs() * margin;
        (value.gt(error), value.lt(-error))
    };
    let ((up, un), (vp, vn), (wp, wn)) = (edge(b, c), edge(c, a), edge(a, b));
    let mixed = (up | vp | wp) & (un | vn | wn);
    ShearedTriangles { vertices, candidates: !mixed }
}

impl ShearedTriangles {
    /// The lanes, among those of `valid`, that cannot be ruled out.
    #[inline(always)]
    pub(crate) fn candidates(&self, valid: u32) -> u32 {
        self.candidates.bits() & valid
    }

    /// Calls `visit` with each candidate's lane and distance, NaN for a miss.
    #[inline(always)]
    pub(crate) fn decide(&self, candidates: u32, mut visit: impl FnMut(usize, f32)) {
        let lanes: [[Lanes; 3]; 3] = axes(|i| axes(|axis| self.vertices[i][axis].to_array()));
        for lane in Bits(candidates) {
            let sheared = axes(|i| axes(|axis| lanes[i][axis][lane]));
            visit(lane, triangle::distance(sheared));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Geometry, PreparedRay, Primitive, Quad, Ray, Sphere, Triangle};
    use crate::math::random::Stream;
    use crate::simd::LANES;
    use glam::Vec3;

    /// A number of any size, sometimes one that rounding is hard on.
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
        Vec3x::new(&axes(|axis| std::array::from_fn(|lane| vectors[lane][axis])))
    }

    /// The lane tests of `primitives[i]` and `rays[i]` agree with the scalar ones, bit by bit.
    fn check<'a>(rays: &[Ray], primitives: &'a Geometry, t_min: f32) {
        let prepared: Vec<PreparedRay> = rays.iter().map(PreparedRay::new).collect();
        let float = |f: &dyn Fn(usize) -> f32| Float::new(std::array::from_fn(f));
        let ray = RayLanes {
            origin: lanes(&prepared.iter().map(|p| p.ray.origin).collect::<Vec<_>>()),
            direction: lanes(&prepared.iter().map(|p| p.ray.direction).collect::<Vec<_>>()),
            time: float(&|i| prepared[i].ray.time),
            length2: float(&|i| prepared[i].length2),
            inv_length2: float(&|i| prepared[i].inv_length2),
            t_min: Float::splat(t_min),
        };
        let compare = |hits: Option<HitLanes>, primitive: &dyn Fn(usize) -> Primitive<'a>| {
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
        let Geometry { spheres, quads, triangles } = primitives;
        let centers: Vec<Vec3> = (0..LANES).map(|i| spheres[i].center_at(rays[i].time)).collect();
        let radius = float(&|i| spheres[i].radius);
        let one = |lane: usize| Primitive::Sphere(&spheres[lane]);
        compare(sphere(&ray, lanes(&centers), radius), &one);
        compare(filtered_sphere(&ray, lanes(&centers), radius), &one);

        let of = |f: &dyn Fn(&Quad) -> Vec3| lanes(&quads.iter().map(f).collect::<Vec<_>>());
        let quad_lanes = QuadLanes {
            q: of(&|quad| quad.q),
            normal: of(&|quad| quad.normal),
            dual_u: of(&|quad| quad.duals()[0]),
            dual_v: of(&|quad| quad.duals()[1]),
        };
        let hits = quad(&ray, &quad_lanes, Float::splat(f32::INFINITY));
        compare(hits, &|lane| Primitive::Quad(&quads[lane]));

        // The axes are shared: one ray, all triangles.
        let PreparedRay { axes: order, shear, .. } = prepared[0];
        let splat = |v: Vec3| axes(|axis| Float::splat(v[axis]));
        let vertices = axes(|i| {
            let vertex = lanes(&triangles.iter().map(|t| t.vertices[i]).collect::<Vec<_>>());
            axes(|axis| vertex[order[axis]])
        });
        let origin = axes(|axis| splat(rays[0].origin)[order[axis]]);
        let sheared = shear_triangles(origin, Vec3x(splat(shear)), vertices);
        let mut distances = [f32::NAN; LANES];
        let all = crate::simd::first_bits(LANES);
        sheared.decide(sheared.candidates(all), |lane, t| distances[lane] = t);
        for (lane, triangle) in triangles.iter().enumerate() {
            let scalar = triangle.intersect(&prepared[0], f32::NEG_INFINITY, f32::INFINITY);
            let vector = Some(distances[lane]).filter(|t| t.is_finite());
            assert_eq!(
                vector.map(f32::to_bits),
                scalar.map(f32::to_bits),
                "{triangle:?} {:?}",
                rays[0]
            );
        }
    }

    #[test]
    fn lanes_agree_with_scalars() {
        let mut random = Stream::new(77);
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
                let quad = loop {
                    let (u, v) = (vector(&mut random), vector(&mut random));
                    if let Some(quad) = Quad::new(vector(&mut random), u, v) {
                        break quad;
                    }
                };
                primitives.quads.push(quad);
                let vertices = [(); 3].map(|()| vector(&mut random));
                primitives.triangles.push(Triangle { vertices });
            }
            check(&rays, &primitives, if round % 3 == 0 { 0.5 } else { 0.0 });
        }
    }
}
