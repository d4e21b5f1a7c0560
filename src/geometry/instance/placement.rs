//! The maps between world and object space, for one ray or one per lane.

use super::Instance;
use crate::geometry::{Ray, ShadingNormal, Surface};
use crate::math::{Mask, Real, Vector, dot, length, max_element, normalize};
use crate::simd::axes;

/// The maps of an instance, or of one per lane.
pub(crate) struct Placement<R: Real> {
    to_object: ToObject<R>,
    /// The rows of A.
    to_world: [R::Vec3; 3],
    /// The constants of [`Placement::surface`].
    slope: R,
    base: R,
}

/// The map from world to object space of an instance, or of one per lane.
pub(crate) struct ToObject<R: Real> {
    /// The rows of L.
    pub(crate) rows: [R::Vec3; 3],
    /// c, the origin of object space.
    pub(crate) center: R::Vec3,
}

/// The product of a matrix with these rows and `v`.
#[inline(always)]
fn apply<V: Vector>(rows: &[V; 3], v: V) -> V {
    V::new(dot(rows[0], v), dot(rows[1], v), dot(rows[2], v))
}

impl<R: Real> ToObject<R> {
    /// The ray in object space, where distances along it are the same as in world space.
    #[inline(always)]
    pub(crate) fn ray(&self, ray: &Ray<R>) -> Ray<R> {
        let origin = apply(&self.rows, ray.origin - self.center);
        let direction = apply(&self.rows, ray.direction);
        Ray { origin, direction, time: ray.time }
    }

    /// The normal in world space of a plane in object space, with a length of its own. It stays on
    /// the same side of the surface, also if the instance is mirrored.
    #[inline(always)]
    fn normal(&self, normal: R::Vec3) -> R::Vec3 {
        let [x, y, z] = self.rows;
        x * normal[0] + y * normal[1] + z * normal[2]
    }
}

impl<R: Real> Placement<R> {
    /// The maps of the instances at `index`.
    #[inline(always)]
    pub(in crate::geometry) fn gather(list: &[Instance], index: R::Index) -> Self {
        let to_object = |i: usize| R::gather(list, index, |instance| &instance.to_object[i]);
        let to_world = |i: usize| R::gather(list, index, |instance| &instance.to_world[i]);
        let [(lx, cx), (ly, cy), (lz, cz)] = [to_object(0), to_object(1), to_object(2)];
        let [(ax, slope), (ay, base), (az, _)] = [to_world(0), to_world(1), to_world(2)];
        let center = R::Vec3::new(cx, cy, cz);
        let to_object = ToObject { rows: [lx, ly, lz], center };
        Self { to_object, to_world: [ax, ay, az], slope, base }
    }

    /// [`ToObject::ray`].
    #[inline(always)]
    pub(in crate::geometry) fn ray(&self, ray: &Ray<R>) -> Ray<R> {
        self.to_object.ray(ray)
    }

    /// Maps a vector from object to world space.
    #[inline(always)]
    pub(in crate::geometry) fn vector(&self, vector: R::Vec3) -> R::Vec3 {
        apply(&self.to_world, vector)
    }

    /// Maps a point from object to world space.
    #[inline(always)]
    pub(in crate::geometry) fn point(&self, point: R::Vec3) -> R::Vec3 {
        self.vector(point) + self.to_object.center
    }

    /// Maps a point of a surface from object to world space.
    ///
    /// Let q be the point in object space, n its normal and u the unit roundoff. A distance along n
    /// is multiplied by 1 / |Lᵀn| in world space. A spawned ray starts at A q + c, which is rounded
    /// by at most 5 u (|A| |q| + |c|). It is mapped back with 4 roundings of |L| |A| |q|, and A and
    /// the inverse of L differ by as much as another one. In world space, these errors are at most 5
    /// u |A| |L| |A| |q| in each coordinate. Along the normal, the sum is less than 20 u κ |A| |q| +
    /// 10 u |c|, where κ is the largest sum in a row of |A| |L|.
    #[inline(always)]
    pub(in crate::geometry) fn surface(&self, surface: Surface<R>) -> Surface<R> {
        let point = self.point(surface.point);
        let normal = self.to_object.normal(surface.normal);
        let scale = length(normal);
        let magnitudes = axes(|row| self.to_world[row].abs());
        let reach = max_element(apply(&magnitudes, surface.point.abs()));
        let offset = surface.offset / scale + (self.slope * reach + self.base);
        let normal = normal / scale;
        let mut shading = ShadingNormal { normal, ..surface.shading };
        if shading.smooth.any() {
            let smooth = normalize(self.to_object.normal(surface.shading.normal));
            shading.normal = shading.smooth.select(smooth, normal);
        }
        Surface { point, normal, offset, shading }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DMat3, DVec3, Vec3};

    use super::*;
    use crate::geometry::{Geometry, Hit, Shape, Surfaces, Triangle};
    use crate::math::Stream;
    use crate::math::warp::{uniform_hemisphere, uniform_sphere};

    /// Random matrices with factors of about `scale`, some of them nearly singular.
    fn matrix(random: &mut Stream, scale: f32, far: f32) -> [[f32; 4]; 3] {
        let thin = [1.0, 1.0, 0.05, 1e-3][random.bits() as usize % 4];
        let mut row = || uniform_sphere(random.uniform(), random.uniform());
        let [a, b, c] = [row(), row(), row()];
        let rows = [a, b, b + (c - b) * thin];
        rows.map(|row| {
            let [x, y, z] = (row * scale).to_array();
            [x, y, z, random.between(-far, far)]
        })
    }

    /// Calls `check` with instances of one triangle, rays that hit them, and the surface points.
    fn for_each_hit(
        mut check: impl FnMut(&Geometry, &[[f32; 4]; 3], &Ray, Hit, &Surface, &mut Stream),
    ) {
        let mut random = Stream::new(12);
        let mut hits = 0;
        for (scale, far) in [(1.0, 0.0), (1.0, 1e4), (1e-4, 1.0), (1e5, 1.0)] {
            for _ in 0..4000 {
                let mut point =
                    |size: f32| uniform_sphere(random.uniform(), random.uniform()) * size;
                let away = point(10.0);
                let vertices = [point(1.0) + away, point(1.0) + away, point(0.3) + away];
                let matrix = matrix(&mut random, scale, far);
                let Ok(instance) = Instance::new(0, &matrix) else { continue };
                let mut geometry = Geometry::default();
                geometry.instances.add_mesh([Triangle { vertices }].into_iter().collect());
                geometry.instances.push(instance);
                let geometry = Arc::new(geometry);
                let surfaces = Surfaces::new(&geometry);
                for _ in 0..20 {
                    let (s, t) = (random.uniform(), random.uniform());
                    let [a, b, c] = vertices;
                    let target = instance.point(a + (b - a) * (s * (1.0 - t)) + (c - a) * (s * t));
                    let away = uniform_sphere(random.uniform(), random.uniform());
                    let origin = target + away * (scale * random.between(0.1, 20.0));
                    let ray = Ray { origin, direction: normalize(target - origin), time: 0.0 };
                    let hit = geometry.closest_by_brute_force(&ray, 0.0, f32::INFINITY);
                    if let Some(hit) = hit {
                        let surface = surfaces.find::<f32>(Shape::Instance, &ray, hit, true);
                        check(&geometry, &matrix, &ray, hit, &surface, &mut random);
                        hits += 1;
                    }
                }
            }
        }
        assert!(hits > 100_000, "{hits}");
    }

    /// The plane of the triangle where the numbers of the matrix place it, in f64.
    fn plane(geometry: &Geometry, matrix: &[[f32; 4]; 3]) -> (DVec3, DVec3, f64) {
        let row = |i: usize| matrix[i].map(f64::from);
        let rows = [row(0), row(1), row(2)];
        let place = |v: Vec3| {
            let v = v.as_dvec3();
            DVec3::from_array(rows.map(|[x, y, z, t]| x * v.x + y * v.y + z * v.z + t))
        };
        let vertices = geometry.instances.triangles().triangles.vertices(0);
        let [a, b, c] = vertices.map(place);
        let linear = DMat3::from_cols_array_2d(&rows.map(|[x, y, z, _]| [x, y, z]));
        // Mirroring turns the vertices, but not the front.
        (a, (b - a).cross(c - a).normalize(), linear.determinant().signum())
    }

    #[test]
    fn points_are_on_the_placed_triangle() {
        let (mut off, mut angle, mut most) = (0.0_f64, 0.0_f64, 0.0_f64);
        for_each_hit(|geometry, matrix, ray, hit, surface, _| {
            let (a, normal, side) = plane(geometry, matrix);
            let distance = (surface.point.as_dvec3() - a).dot(normal).abs();
            off = off.max(distance / f64::from(surface.offset));
            // Nearly singular matrices magnify the rounding of the normal.
            let condition = f64::from(geometry.condition());
            let normal = normal * side;
            let between = normal.cross(surface.normal.as_dvec3()).length();
            angle = angle.max(between / condition);
            assert!(normal.dot(surface.normal.as_dvec3()) > 0.0, "{matrix:?}");
            let end = ray.origin + ray.direction * hit.t;
            let size = length(end - ray.origin) + length(end) + 1.0;
            let reach = f64::from(size) * condition;
            // Points may be moved away from edges by up to 32 offsets.
            let most_off = 1e-5 * reach + 32.0 * f64::from(surface.offset);
            assert!(f64::from(length(surface.point - end)) < most_off, "{matrix:?} {ray:?}");
            let coordinates = length(surface.point)
                + length(geometry.instances.list()[0].world_to_object().center);
            most = most.max(f64::from(surface.offset) / (f64::from(coordinates) * condition));
        });
        assert!(off < 1.0, "off the plane by {off} offsets");
        assert!(most < 2e-4, "offsets of {most} times the condition number and the coordinates");
        assert!(angle < 1e-5, "normals off by {angle} times the condition number");
    }

    #[test]
    fn no_ray_meets_the_instance_that_it_leaves() {
        for_each_hit(|geometry, matrix, ray, _, surface, random| {
            let front = dot(surface.normal, ray.direction) < 0.0;
            let side = if front { surface.normal } else { -surface.normal };
            let direction = uniform_hemisphere(side, random.uniform(), random.uniform()).0;
            let leaving = Ray { origin: surface.spawn(side), direction, time: 0.0 };
            let hit = geometry.closest_by_brute_force(&leaving, 0.0, f32::INFINITY);
            // Directions that graze the surface may be below it, by the error of the normal.
            let sine = dot(direction, side);
            assert!(hit.is_none() || sine < 1e-6 * geometry.condition(), "{matrix:?} {leaving:?}");
        });
    }
}
