//! Points of triangles.

use glam::DVec3;

use crate::geometry::{Ray, Surface};
use crate::math::{Mask, Real, UNIT_ROUNDOFF, Vector, cross, dot, length, max, max_element, min};
use crate::simd::axes;

/// Where the sine of the angle between two edges is below 2^-10, their cross product cancels too
/// much in f32.
const LEAST_SINE2: f32 = 1.0 / (1 << 20) as f32;
/// Below this square of twice the area, products of the cross product lose bits to underflow.
const LEAST_AREA2: f32 = 1e-24;

/// The unit normals of triangles, and the barycentric coordinates of points on them for the second
/// and the third vertex, not yet limited to their range. `u` and `v` are the edges from the first
/// vertex, and `p` leads from there to the points.
///
/// The normals are off by at most 2^-12 radians. Nearly all triangles need f32 only; thin and tiny
/// ones are computed in f64.
#[inline(always)]
fn locate<R: Real>(vertices: [R::Vec3; 3], [u, v]: [R::Vec3; 2], p: R::Vec3) -> (R::Vec3, [R; 2]) {
    let across = cross(u, v);
    let area2 = dot(across, across);
    let inverse = R::ONE / area2.sqrt();
    let fine = area2.gt(dot(u, u) * dot(v, v) * LEAST_SINE2) & area2.gt(R::splat(LEAST_AREA2));
    let normal = across * inverse;
    let share = |across: R::Vec3| dot(across, normal) * inverse;
    let shares = [share(cross(p, v)), share(cross(u, p))];
    if !(!fine).any() {
        return (normal, shares);
    }
    let [a, b, c] = vertices.map(|vertex| [vertex[0], vertex[1], vertex[2]]);
    let [[ax, ay, az], [bx, by, bz], [cx, cy, cz], [px, py, pz]] = [a, b, c, [p[0], p[1], p[2]]];
    let numbers = [ax, ay, az, bx, by, bz, cx, cy, cz, px, py, pz];
    let [x, y, z, second, third] = R::each_lane(R::ZERO.to_bits(), numbers, |_, numbers| {
        let vector = |i: usize| [0, 1, 2].map(|axis| f64::from(numbers[3 * i + axis]));
        let [a, b, c, p] = [0, 1, 2, 3].map(|i| DVec3::from_array(vector(i)));
        let (u, v) = (b - a, c - a);
        let across = u.cross(v);
        let inverse = 1.0 / across.dot(across).sqrt();
        let normal = across * inverse;
        let share = |across: DVec3| (across.dot(normal) * inverse) as f32;
        let [x, y, z] = normal.as_vec3().to_array();
        [x, y, z, share(p.cross(v)), share(u.cross(p))]
    });
    let [s, t] = shares;
    (fine.select(normal, R::Vec3::new(x, y, z)), [fine.select(s, second), fine.select(t, third)])
}

/// The point at distance `t` along `ray` on the triangle with these vertices, and its barycentric
/// coordinates for the second and the third vertex.
///
/// The point may be off along the triangle, by about the rounding error of `ray.origin + t
/// ray.direction`, but never leaves the triangle: the coordinates are limited to their range. Its
/// distance from the triangle's plane is below half of [`Surface::offset`].
#[inline(always)]
pub(in crate::geometry) fn surface<R: Real>(
    vertices: [R::Vec3; 3],
    ray: &Ray<R>,
    t: R,
) -> (Surface<R>, [R; 2]) {
    let [a, b, c] = vertices;
    let (u, v) = (b - a, c - a);
    let p = (ray.origin - a) + ray.direction * t;
    let (normal, [second, third]) = locate::<R>(vertices, [u, v], p);
    let second = min(max(second, R::ZERO), R::ONE);
    let third = min(max(third, R::ZERO), R::ONE - second);
    let [x, y, z] = axes(|i| max(max(a[i].abs(), b[i].abs()), c[i].abs()));
    let extent = max_element(R::Vec3::new(x, y, z));
    // The sheared vertices of the ray test are off by up to 8 roundings of the edges' lengths, and
    // the point is off by 6 roundings of its coordinates.
    let offset = ((length(u) + length(v)) * 12.0 + extent * 8.0) * UNIT_ROUNDOFF;
    let surface = Surface::flat(a + (u * second + v * third), normal, offset);
    (surface, [second, third])
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::geometry::{PreparedRay, PrimitiveModel, Triangle};
    use crate::math::warp::{uniform_hemisphere, uniform_sphere};
    use crate::math::{Stream, normalize};

    /// Random triangles: round ones, needles, and flat ones with a vertex near the opposite edge.
    fn triangle(random: &mut Stream, scale: f32) -> [Vec3; 3] {
        let mut point = || uniform_sphere(random.uniform(), random.uniform()) * scale;
        let [a, b, c] = [point(), point(), point()];
        let thin = [1.0, 1e-2, 1e-4, 1e-6][random.bits() as usize % 4];
        match random.bits() % 3 {
            0 => [a, b, b + (c - b) * thin],
            1 => [a, b, a + (b - a) * random.uniform() + c * thin],
            _ => [a, a + (b - a) * thin, a + (c - a) * thin],
        }
    }

    /// Calls `check` with triangles and rays that hit them, the distance, and the surface point.
    fn for_each_hit(mut check: impl FnMut(&[Vec3; 3], &Ray, f32, &Surface, [f32; 2], &mut Stream)) {
        let mut random = Stream::new(9);
        let mut hits = 0;
        for scale in [1e-6, 1e-3, 1.0, 1e3, 1e8] {
            for _ in 0..100_000 {
                let vertices = triangle(&mut random, scale);
                let triangle = Triangle { vertices };
                let [a, b, c] = vertices;
                let (s, t) = (random.uniform(), random.uniform());
                let target = a + (b - a) * (s * (1.0 - t)) + (c - a) * (s * t);
                let away = uniform_sphere(random.uniform(), random.uniform());
                let origin =
                    target + away * (scale * [0.01, 1.0, 50.0][random.bits() as usize % 3]);
                let ray = Ray { origin, direction: normalize(target - origin), time: 0.0 };
                let t = triangle.intersect(&PreparedRay::new(&ray), 0.0, f32::INFINITY);
                if let Some(t) = t.filter(|_| !triangle.is_degenerate()) {
                    let (surface, shares) = surface(vertices, &ray, t);
                    check(&vertices, &ray, t, &surface, shares, &mut random);
                    hits += 1;
                }
            }
        }
        assert!(hits > 300_000, "{hits}");
    }

    #[test]
    fn tiny_triangles_have_exact_points() {
        for scale in [1e-10, 1e-18, 1e-20, 1e-30, 1e-36] {
            let vertices = [Vec3::ZERO, Vec3::X * scale, Vec3::Y * scale];
            let origin = Vec3::new(0.25, 0.5, 1.0) * scale;
            let ray = Ray { origin, direction: Vec3::NEG_Z, time: 0.0 };
            let (surface, shares) = surface(vertices, &ray, scale);
            assert_eq!(surface.normal, Vec3::Z, "{scale}");
            let near = |a: f32, b: f32| (a - b).abs() < 1e-5;
            assert!(near(shares[0], 0.25) && near(shares[1], 0.5), "{scale}: {shares:?}");
        }
    }

    #[test]
    fn points_and_normals_are_as_exact_as_stated() {
        let (mut plane, mut along, mut angle) = (0.0_f64, 0.0_f64, 0.0_f64);
        for_each_hit(|vertices, ray, t, surface, shares, _| {
            let [a, b, c] = vertices.map(Vec3::as_dvec3);
            let normal = (b - a).cross(c - a).normalize();
            let point = surface.point.as_dvec3();
            plane = plane.max((point - a).dot(normal).abs() / f64::from(surface.offset));
            angle = angle.max(normal.cross(surface.normal.as_dvec3()).length());
            let [second, third] = shares.map(f64::from);
            assert!(second >= 0.0 && third >= 0.0 && second + third <= 1.0 + 1e-7, "{shares:?}");
            // The nearest point of the triangle to the exact end of the ray cannot be farther away
            // than its own rounding error and that of the barycentric coordinates.
            let end = ray.origin.as_dvec3() + ray.direction.as_dvec3() * f64::from(t);
            let u = f64::from(UNIT_ROUNDOFF);
            let reach = (ray.origin.as_dvec3() - a).length()
                + 2.0 * f64::from(t)
                + a.abs().max_element()
                + b.abs().max_element()
                + c.abs().max_element();
            let edges = (b - a).length().max((c - a).length());
            let thinness = edges * edges / (b - a).cross(c - a).length();
            along = along.max((point - end).length() / (u * reach * (1.0 + thinness)));
        });
        assert!(plane < 0.5, "off the plane by {plane} offsets");
        assert!(angle < 1.0 / 4096.0, "normals off by {angle}");
        assert!(along < 16.0, "off the ray's end by {along} roundings");
    }

    #[test]
    fn no_ray_meets_the_triangle_that_it_leaves() {
        for_each_hit(|vertices, ray, _, surface, _, random| {
            let front = dot(surface.normal, ray.direction) < 0.0;
            let side = if front { surface.normal } else { -surface.normal };
            let direction = uniform_hemisphere(side, random.uniform(), random.uniform()).0;
            let leaving = Ray { origin: surface.spawn(side), direction, time: 0.0 };
            let triangle = Triangle { vertices: *vertices };
            let hit = triangle.intersect(&PreparedRay::new(&leaving), 0.0, f32::INFINITY);
            assert_eq!(hit, None, "{triangle:?} {leaving:?}");
        });
    }
}
