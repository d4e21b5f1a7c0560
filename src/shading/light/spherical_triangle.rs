//! Uniform sampling of the solid angle of a triangle (Arvo 1995, "Stratified Sampling of
//! Spherical Triangles").
//!
//! The code departs from the paper in three points to keep precision in f32, in the manner of
//! Peters 2021, "BRDF Importance Sampling for Polygonal Lights":
//! 1. The solid angle is twice the angle whose tangent is det(a, b, c) over a sum of products (Van
//!    Oosterom and Strackee 1983), where a, b and c are the directions to the vertices. It is not
//!    the excess of three angles computed by arccosines.
//! 2. For a random number u, sampling needs the point on the arc from a to c that forms a triangle
//!    with a and b of u times the solid angle. The formula of point 1, solved for this point, gives
//!    the tangent of half its angle from a as a quotient.
//! 3. Quantities that vanish for small triangles are computed without cancellation. The
//!    determinants come from the edges, which are given, and not from differences of directions.
//!    1 − cos and 1 + cos of the angle between two directions are half the squared lengths of their
//!    difference and sum.

use super::sample::Plane;
use super::{MIN_SINE, MIN_SOLID_ANGLE};
use crate::math::{Real, atan2, cross, dot, length, max, normalize, sin_cos};

/// A triangle as seen from a point, projected onto the unit sphere around that point.
pub(super) struct SphericalTriangle<R: Real> {
    /// Direction to the first vertex.
    a: R::Vec3,
    /// Direction to the second vertex.
    b: R::Vec3,
    /// Unit vector perpendicular to a, along the arc from a towards the third vertex.
    along: R::Vec3,
    /// 1 + a·b.
    one_plus_cos: R,
    /// |det(a, b, along)|.
    det: R,
    solid_angle: R,
    /// Whether the triangle is large enough, and not too edge-on, for f32. If not, it is sampled by
    /// area.
    pub(super) exact: R::Mask,
}

impl<R: Real> SphericalTriangle<R> {
    /// Returns the triangle with these vertices in `plane`, as seen from `from`.
    #[inline(always)]
    pub(super) fn new([p, q, r]: [R::Vec3; 3], plane: &Plane<R>, from: R::Vec3) -> Self {
        let (pq, pr) = (q - p, r - p);
        let (to_p, to_q, to_r) = (p - from, q - from, r - from);
        let (lp, lq, lr) = (length(to_p), length(to_q), length(to_r));
        let height = dot(to_p, plane.normal).abs();
        let volume = height * (plane.area * 2.0);
        let sum = lp * lq * lr + dot(to_p, to_q) * lr + dot(to_p, to_r) * lq + dot(to_q, to_r) * lp;
        let solid_angle = atan2(volume, sum) * 2.0;
        let exact =
            solid_angle.gt(R::splat(MIN_SOLID_ANGLE)) & height.gt(max(lp, max(lq, lr)) * MIN_SINE);
        let (a, b) = (to_p * (R::ONE / lp), to_q * (R::ONE / lq));
        let along = normalize(pr - a * dot(a, pr));
        let (det, middle) = (dot(cross(along, a), pq).abs() / lq, a + b);
        let one_plus_cos = dot(middle, middle) * 0.5;
        Self { a, b, along, one_plus_cos, det, solid_angle, exact }
    }

    /// Returns the density of [`Self::sample`]'s directions per unit solid angle.
    #[inline(always)]
    pub(super) fn pdf(&self) -> R {
        R::ONE / self.solid_angle
    }

    /// Samples a direction to the triangle.
    #[inline(always)]
    pub(super) fn sample(&self, u: R, v: R) -> R::Vec3 {
        let Self { a, b, along, one_plus_cos, det, solid_angle, .. } = *self;
        // The point c on the arc that forms a triangle with a and b of u times the solid angle.
        let (sin, cos) = sin_cos(u * solid_angle * 0.5);
        let (y, x) = (one_plus_cos * sin, det * cos - dot(b, along) * sin);
        let (x2, y2) = (x * x, y * y);
        let c = (a * (x2 - y2) + along * (x * 2.0 * y)) * (R::ONE / (x2 + y2));
        // A point on the arc from b to c, uniform in the cosine of its angle from b.
        let bc = c - b;
        let one_minus_cos = v * (dot(bc, bc) * 0.5);
        let sin = max(R::ZERO, one_minus_cos * (R::splat(2.0) - one_minus_cos)).sqrt();
        let towards = normalize(bc - b * dot(b, bc));
        normalize(b * (R::ONE - one_minus_cos) + towards * sin)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};

    use super::*;
    use crate::math::Stream;

    /// Number of parts along each edge.
    const PARTS: usize = 6;

    /// Triangles and the points from which they are seen: near, far, close to the plane, an edge or
    /// a vertex, and above the middle of a huge triangle.
    const VIEWS: [([Vec3; 3], Vec3); 7] = {
        let (v, o) = (Vec3::new, Vec3::ZERO);
        let lamp = [v(343.0, 554.0, 227.0), v(213.0, 554.0, 227.0), v(343.0, 554.0, 332.0)];
        [
            (lamp, v(278.0, 0.0, 279.0)),
            (lamp, v(300.0, 553.0, 250.0)),
            (lamp, v(250.0, 555.0, 200.0)),
            (lamp, v(214.0, 552.0, 226.0)),
            (lamp, v(150.0, 553.0, 240.0)),
            ([v(300.0, -300.0, 4.0), v(0.0, 600.0, 4.0), v(-300.0, -300.0, 3.0)], o),
            ([v(1.0, 0.02, 0.04), v(1.02, -0.04, 0.06), v(0.98, 0.08, -0.06)], o),
        ]
    };

    /// Computes a solid angle in f64 by the formula of Van Oosterom and Strackee.
    #[allow(clippy::disallowed_methods)]
    fn solid_angle([a, b, c]: [DVec3; 3], from: DVec3) -> f64 {
        let [a, b, c] = [a, b, c].map(|v| (v - from).normalize());
        let volume = a.dot((b - a).cross(c - a)).abs();
        2.0 * volume.atan2(1.0 + a.dot(b) + a.dot(c) + b.dot(c))
    }

    fn spherical(vertices: [Vec3; 3], from: Vec3) -> SphericalTriangle<f32> {
        let [a, b, c] = vertices.map(|v| v.as_dvec3());
        let normal = (b - a).cross(c - a);
        let area = (0.5 * normal.length()) as f32;
        let plane = Plane { point: vertices[0], normal: normal.normalize().as_vec3(), area };
        SphericalTriangle::new(vertices, &plane, from)
    }

    #[test]
    fn solid_angles_agree_with_the_closed_form() {
        for (vertices, from) in VIEWS {
            let spherical = spherical(vertices, from);
            assert!(spherical.exact);
            let got = f64::from(1.0 / spherical.pdf());
            let want = solid_angle(vertices.map(|v| v.as_dvec3()), from.as_dvec3());
            assert!((got - want).abs() < 1e-4 * want, "{from}: {got} {want}");
        }
        assert!(!spherical(VIEWS[0].0, Vec3::new(0.0, -1e5, 0.0)).exact);
    }

    #[test]
    fn samples_are_uniform_in_solid_angle() {
        const N: u32 = 200_000;
        for (vertices, from) in VIEWS {
            let spherical = spherical(vertices, from);
            assert!(spherical.exact);
            let ([a, b, c], eye) = (vertices.map(|v| v.as_dvec3()), from.as_dvec3());
            let (u, v) = (b - a, c - a);
            let normal = u.cross(v);
            let mut random = Stream::new(11);
            // PARTS × PARTS cells of two triangles each.
            let mut counts = [[[0u32; 2]; PARTS]; PARTS];
            for _ in 0..N {
                let direction = spherical.sample(random.uniform(), random.uniform()).as_dvec3();
                let t = normal.dot(a - eye) / normal.dot(direction);
                let p = eye + direction * t - a;
                let n2 = normal.dot(normal);
                let place = [p.cross(v), u.cross(p)].map(|w| w.dot(normal) / n2 * PARTS as f64);
                let edge = 1e-3 * PARTS as f64;
                assert!(
                    place.iter().all(|&x| x > -edge) && place[0] + place[1] < PARTS as f64 + edge
                );
                let cell = place.map(|x| (x.max(0.0) as usize).min(PARTS - 1));
                let upper = place[0] - cell[0] as f64 + place[1] - cell[1] as f64 > 1.0;
                counts[cell[0]][cell[1]][usize::from(upper)] += 1;
            }
            let whole = solid_angle([a, b, c], eye);
            for (i, row) in counts.iter().enumerate() {
                for (j, cell) in row.iter().enumerate() {
                    let at = |i: usize, j: usize| a + (u * i as f64 + v * j as f64) / PARTS as f64;
                    let halves = [
                        [at(i, j), at(i + 1, j), at(i, j + 1)],
                        [at(i + 1, j + 1), at(i + 1, j), at(i, j + 1)],
                    ];
                    for (upper, (half, &count)) in halves.into_iter().zip(cell).enumerate() {
                        if i + j + upper >= PARTS {
                            assert!(
                                f64::from(count) < 1e-3 * f64::from(N),
                                "{i} {j} {upper}: {count}"
                            );
                            continue;
                        }
                        let p = solid_angle(half, eye) / whole;
                        let got = f64::from(count) / f64::from(N);
                        // Five standard deviations, over 252 tests.
                        let bound = 5.0 * (p * (1.0 - p) / f64::from(N)).sqrt() + 2e-5;
                        assert!((got - p).abs() < bound, "{from} {i} {j} {upper}: {got} {p}");
                    }
                }
            }
        }
    }
}
