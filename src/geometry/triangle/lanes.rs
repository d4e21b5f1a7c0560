//! Tests of triangles and rays in lanes.

use super::{distance, distance_by_select};
use crate::math::{Real, UNIT_ROUNDOFF};
use crate::simd::{Bits, Float, LANES, Lanes, Mask, Vec3x, axes};

/// Triangles in the coordinates of their rays, and the lanes that may hit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShearedTriangles {
    /// Each vertex has two coordinates across the ray, followed by its distance along the ray.
    vertices: [[Float; 3]; 3],
    /// The edge functions.
    edges: [Float; 3],
    /// Bound on the products of two coordinates across the ray, one on each axis, up to rounding.
    most: Float,
    /// Bound on the errors of `edges`.
    error: Float,
    candidates: Mask,
}

/// What f32 arithmetic can tell about hits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Verdict {
    /// The lanes that may hit. The others certainly miss.
    pub(crate) possible: u32,
    /// The lanes that certainly hit, as far as rays ask for any hit.
    pub(crate) certain: u32,
}

/// Shears triangles and filters the lanes: f32 edge functions whose signs are certain reject nearly
/// all misses. The remaining candidates are decided in f64 (rule 1 of the contract in
/// ARCHITECTURE.md), unless [`ShearedTriangles::verdict`] is certain of them.
///
/// `origin` and `vertices` are in the order of [`crate::geometry::PreparedRay`]'s axes, and `shear`
/// maps the rays' directions to (0, 0, 1) in that order.
#[inline(always)]
pub(crate) fn shear(
    origin: [Float; 3],
    shear: Vec3x,
    vertices: [[Float; 3]; 3],
) -> ShearedTriangles {
    let vertices = axes(|i| {
        let p = axes(|axis| vertices[i][axis] - origin[axis]);
        [p[0] - shear[0] * p[2], p[1] - shear[1] * p[2], shear[2] * p[2]]
    });
    let [a, b, c] = vertices;
    // The error of a b − c d comes from the roundings of two products (one if fused) and of their
    // difference. In total it is below 5 unit roundoffs of `largest(0) * largest(1)`, which no product
    // exceeds. The tiny summand covers underflow.
    let largest = |axis: usize| a[axis].abs().max(b[axis].abs()).max(c[axis].abs());
    let most = largest(0).free_mul_add(largest(1), Float::splat(4e-30));
    let error = most * Float::splat(EDGE_ERROR);
    let edge = |from: [Float; 3], to: [Float; 3]| from[0].free_mul_sub(to[1], from[1] * to[0]);
    let (u, v, w) = (edge(b, c), edge(c, a), edge(a, b));
    let (high, low) = (u.max(v).max(w), u.min(v).min(w));
    let mixed = high.gt(error) & low.lt(-error);
    ShearedTriangles { vertices, edges: [u, v, w], most, error, candidates: !mixed }
}

/// The triangles with the same coordinate on an axis at all vertices ([`Triangle::level_axis`]), and the
/// distances of their planes. The three axes may be in any order.
///
/// [`Triangle::level_axis`]: super::Triangle::level_axis
#[derive(Clone, Copy, Debug)]
pub(crate) struct Levels {
    lanes: u32,
    distances: Lanes,
}

impl Levels {
    /// Those of the triangles in the lanes of `valid`.
    #[inline(always)]
    pub(crate) fn new(
        origin: [Float; 3],
        direction: impl Fn(usize) -> Float,
        vertices: &[[Float; 3]; 3],
        valid: u32,
    ) -> Self {
        let [a, b, c] = vertices;
        let level = axes(|axis| a[axis].eq(b[axis]) & b[axis].eq(c[axis]));
        let lanes = (level[0] | level[1] | level[2]).bits() & valid;
        let mut distances = Float::ZERO;
        if lanes != 0 {
            for axis in 0..3 {
                let distance = (a[axis] - origin[axis]) / direction(axis);
                distances = level[axis].select(distance, distances);
            }
        }
        Self { lanes, distances: distances.to_array() }
    }

    /// Whether no triangle is level.
    #[inline(always)]
    pub(crate) fn are_none(&self) -> bool {
        self.lanes == 0
    }

    /// The distance of a triangle that has the distance `t` by its edge functions.
    #[inline(always)]
    pub(crate) fn distance(&self, lane: usize, t: f32) -> f32 {
        if self.lanes >> lane & 1 == 1 && !t.is_nan() { self.distances[lane] } else { t }
    }
}

/// Bound on the error of an edge function, relative to the largest product in it.
const EDGE_ERROR: f32 = 5.0 * UNIT_ROUNDOFF;
/// Bound on the error of a distance t times the sum of the edge functions, relative to `most * (farthest + t)`.
/// See [`ShearedTriangles::verdict`].
const DISTANCE_ERROR: f32 = 96.0 * UNIT_ROUNDOFF;

/// Up to this many candidates are decided one by one. If there are more, all lanes are decided at
/// once. Twice this limit is 1% slower on x86-64-v3.
const MOST_ALONE: u32 = LANES as u32 / 8;

impl ShearedTriangles {
    /// The lanes of `valid` that the filter has not rejected.
    #[inline(always)]
    pub(crate) fn candidates(&self, valid: u32) -> u32 {
        self.candidates.bits() & valid
    }

    /// Tells from f32 distances which lanes of `valid` hit in the interval from `t_min`, which is at
    /// least 0, to `t_max`. Only `ANY` makes lanes certain to hit.
    ///
    /// Many triangles pass the edge functions but lie outside the interval: behind the ray's origin,
    /// like the triangle that it leaves; beyond its end, like the lamp at which a shadow ray aims; or
    /// beyond the closest hit so far.
    #[inline(always)]
    pub(crate) fn verdict<const ANY: bool>(
        &self,
        valid: u32,
        t_min: Float,
        t_max: Float,
    ) -> Verdict {
        let ([a, b, c], [u, v, w]) = (axes(|i| self.vertices[i][2]), self.edges);
        // The tiny number covers the rounding of subnormal distances.
        let farthest = a.abs().max(b.abs()).max(c.abs()).max(Float::splat(1e-35));
        // No hit lies beyond the farthest vertex, so this makes the end finite and changes nothing else.
        let t_max = if ANY { t_max.min(farthest + farthest) } else { t_max };
        let total = u + v + w;
        let along = u.free_mul_add(a, v.free_mul_add(b, w * c)) * Float::splat(1.0).copysign(total);
        // With the exact total S and distance T, this estimates |S| (t − T). In unit roundoffs of
        // `most * (farthest + t)`, it is in error by at most 37 (edge functions 15, sums and products
        // 22), and the rounding of T to f32 adds 6. If f32 has the sign of S wrong, |S| is at most 25 of
        // `most`, and the estimate at most 25 + 37. The distance of a plane (`Levels`) differs from T by at
        // most 8 roundings of the farthest vertex, since shearing rounds the coordinate on the plane's axis
        // three times. As |S| is at most 6 of `most`, that adds 48.
        let beyond = |t: Float| total.abs().free_mul_sub(t, along);
        // No intermediate result above exceeds 16 times `most * (farthest + t)`. So if one of them is
        // infinite, this is, too, and nothing is certain.
        let margin = |t: Float| {
            let size = self.most * Float::splat(16.0) * (farthest + t);
            size.free_mul_add(Float::splat(DISTANCE_ERROR / 16.0), Float::splat(1e-36))
        };
        let (near, far) = ((beyond(t_min), margin(t_min)), (beyond(t_max), margin(t_max)));
        let outside = near.0.gt(near.1) | far.0.lt(-far.1);
        let inside = near.0.lt(-near.1) & far.0.gt(far.1);
        let met = u.min(v).min(w).gt(self.error) | u.max(v).max(w).lt(-self.error);
        let certain = if ANY { (met & inside).bits() & valid } else { 0 };
        Verdict { possible: (self.candidates & !outside).bits() & valid, certain }
    }

    /// Distances in the lanes of `candidates`, NaN for misses. The other lanes are unspecified.
    #[inline(always)]
    pub(crate) fn distances(&self, candidates: u32) -> Float {
        let lanes: [[Lanes; 3]; 3] = axes(|i| axes(|axis| self.vertices[i][axis].to_array()));
        let sheared = |lane: usize| axes(|i| axes(|axis| lanes[i][axis][lane]));
        let mut distances = [0.0; LANES];
        if candidates.count_ones() > MOST_ALONE {
            for (lane, t) in distances.iter_mut().enumerate() {
                *t = distance_by_select(sheared(lane));
            }
        } else {
            for lane in Bits(candidates) {
                distances[lane] = distance(sheared(lane));
            }
        }
        Float::new(distances)
    }

    /// Calls `visit` with the lane and distance of each candidate. The distance is NaN for a miss.
    /// `SELECT` decides misses without a branch.
    #[inline(always)]
    pub(crate) fn decide<const SELECT: bool>(
        &self,
        candidates: u32,
        mut visit: impl FnMut(usize, f32),
    ) {
        let lanes: [[Lanes; 3]; 3] = axes(|i| axes(|axis| self.vertices[i][axis].to_array()));
        for lane in Bits(candidates) {
            let sheared = axes(|i| axes(|axis| lanes[i][axis][lane]));
            visit(lane, if SELECT { distance_by_select(sheared) } else { distance(sheared) });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{PreparedRay, PrimitiveModel, Ray, Triangle};
    use crate::math::Stream;
    use crate::simd::first_bits;
    use glam::Vec3;

    fn vector(random: &mut Stream) -> Vec3 {
        Vec3::from_array([(); 3].map(|()| random.between(-1.0, 1.0)))
    }

    /// Random triangles of which some are small, distant or thin, and a ray to a point of the first.
    fn case(random: &mut Stream) -> (Vec<Triangle>, Ray, f32) {
        let [size, thin, away] = [8, 12, 8].map(|powers| {
            let power = random.bits() as i32 % powers;
            (0..power).fold(1.0_f32, |value, _| value * 0.25)
        });
        let triangles: Vec<_> = (0..LANES)
            .map(|_| {
                let corner = vector(random);
                let [along, across] = [(); 2].map(|()| vector(random) * size);
                Triangle {
                    vertices: [corner, corner + along, corner + along * 0.5 + across * thin],
                }
            })
            .collect();
        let [a, b, c] = triangles[0].vertices;
        // One in four rays aims at an edge, or at a vertex.
        let mut weight = || if random.bits().is_multiple_of(8) { 0.0 } else { random.uniform() };
        let (u, v) = (weight(), weight());
        let target = a + ((b - a) * u + (c - a) * v) * if u + v > 1.0 { 0.5 } else { 1.0 };
        let direction = vector(random);
        (triangles, Ray { origin: target - direction * away, direction, time: 0.0 }, away)
    }

    fn sheared(triangles: &[Triangle], ray: &Ray) -> ShearedTriangles {
        let PreparedRay { axes: order, shear: turned, .. } = PreparedRay::new(ray);
        let lane = |i: usize, axis: usize| std::array::from_fn(|t| triangles[t].vertices[i][axis]);
        let vertices = axes(|i| axes(|axis| Float::new(lane(i, order[axis]))));
        let origin = axes(|axis| Float::splat(ray.origin[order[axis]]));
        shear(origin, Vec3x(axes(|axis| Float::splat(turned[axis]))), vertices)
    }

    #[test]
    fn verdicts_never_contradict_exact_distances() {
        let mut random = Stream::new(14);
        for _ in 0..200_000 {
            let (triangles, ray, away) = case(&mut random);
            let (prepared, sheared) = (PreparedRay::new(&ray), sheared(&triangles, &ray));
            let exact = |triangle: &Triangle| {
                triangle.intersect(&prepared, f32::NEG_INFINITY, f32::INFINITY).unwrap_or(f32::NAN)
            };
            let first = exact(&triangles[0]);
            let first = if first > 0.0 { first } else { away };
            let near = [
                first.next_down(),
                first,
                first.next_up(),
                first * random.between(0.999_99, 1.000_01),
            ];
            let mut end = || near[random.bits() as usize % 4];
            for (t_min, t_max) in [(0.0, end()), (end(), f32::INFINITY), (0.0, first * 2.0)] {
                let all = first_bits(LANES);
                let [t_low, t_high] = [t_min, t_max].map(Float::splat);
                let any = sheared.verdict::<true>(all, t_low, t_high);
                let closest = sheared.verdict::<false>(all, t_low, t_high);
                for (lane, triangle) in triangles.iter().enumerate() {
                    let t = exact(triangle);
                    let has = |lanes: u32| lanes >> lane & 1 == 1;
                    // A hit at exactly `t_max` may win a tie.
                    let (may, does) = (t > t_min && t <= t_max, t > t_min && t < t_max);
                    let sound = has(any.possible) && has(closest.possible) || !may;
                    assert!(sound, "skipped in {t_min} to {t_max}: {triangle:?} {ray:?}");
                    let sound = does || !has(any.certain | closest.certain);
                    assert!(sound, "missed in {t_min} to {t_max}: {triangle:?} {ray:?}");
                }
            }
        }
    }

    #[test]
    fn most_verdicts_are_certain() {
        let (mut random, mut hits, mut decided) = (Stream::new(15), 0, [0; 4]);
        for _ in 0..10_000 {
            let (triangles, ray, _) = case(&mut random);
            let sheared = sheared(&triangles, &ray);
            let Some(t) = triangles[0].intersect(&PreparedRay::new(&ray), 0.0, f32::INFINITY)
            else {
                continue;
            };
            let verdict =
                |t_min, t_max| sheared.verdict::<true>(1, Float::splat(t_min), Float::splat(t_max));
            hits += 1;
            decided[0] += 1 - verdict(t * 1.01, f32::INFINITY).possible;
            decided[1] += 1 - verdict(0.0, t * 0.99).possible;
            decided[2] += verdict(t * 0.99, t * 1.01).certain;
            decided[3] += verdict(0.0, f32::INFINITY).certain;
        }
        assert!(decided.iter().all(|&number| number * 3 > hits * 2), "of {hits}: {decided:?}");
    }

    /// The exact test rounds the distance to 0, which lies outside the interval.
    #[test]
    fn subnormal_distances_are_not_certain() {
        let vertices =
            [(-1e5, -1e5, 0.0), (1e5, -1e5, 0.0), (0.0, 1e5, f32::from_bits(1))].map(Vec3::from);
        let ray = Ray { origin: Vec3::Y * -5e4, direction: Vec3::Z, time: 0.0 };
        let triangle = Triangle { vertices };
        assert_eq!(triangle.intersect(&PreparedRay::new(&ray), 0.0, 1.0), None);
        let sheared = sheared(&[triangle; LANES], &ray);
        assert_eq!(sheared.verdict::<true>(1, Float::ZERO, Float::splat(1.0)).certain, 0);
    }
}
