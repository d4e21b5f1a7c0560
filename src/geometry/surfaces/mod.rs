//! Computes the points where rays hit primitives, with one file for each shape.
//!
//! Each shape has a table of its primitives, which many lanes can read at once.

mod instance;
mod moving_sphere;
mod quad;
mod sphere;
mod triangle;

use std::sync::Arc;

use super::{Geometry, Hit, Ray, Shape, Surface, match_shape, shapes};
use crate::math::{Real, Vector};

/// The table of the primitives of one shape.
trait SurfaceTable {
    fn new(geometry: &Arc<Geometry>) -> Self;

    /// The point where `ray` has this hit.
    fn find<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>) -> Surface<R>;

    /// The texture coordinates of that point, both in [0, 1] up to rounding unless a mesh has its
    /// own.
    fn uv<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>, surface: &Surface<R>) -> (R, R);

    /// As [`SurfaceTable::uv`], of the second set. Only meshes have one.
    fn second_uv<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>, surface: &Surface<R>) -> (R, R) {
        self.uv(ray, hit, surface)
    }

    /// The colour of the surface itself: white unless a mesh has its own.
    fn color<R: Real>(&self, _ray: &Ray<R>, _hit: Hit<R>) -> R::Vec3 {
        R::Vec3::gray(R::ONE)
    }

    /// The directions in which the texture coordinates grow at that point.
    fn partials<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>, surface: &Surface<R>) -> Partials<R>;
}

/// How the point of a surface moves with its texture coordinates (u, v), those of the first set. Not
/// finite where the coordinates do not define it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Partials<R: Real = f32> {
    /// ∂p/∂u.
    pub u: R::Vec3,
    /// ∂p/∂v.
    pub v: R::Vec3,
    /// The direction of the first axis of normal maps: ∂p/∂u unless a mesh has its own.
    pub tangent: R::Vec3,
}

impl<R: Real> Partials<R> {
    #[inline(always)]
    fn new(u: R::Vec3, v: R::Vec3) -> Self {
        Self { u, v, tangent: u }
    }
}

macro_rules! surfaces {
    ($($name:ident in $module:ident,)*) => {
        /// The primitives of a geometry, in one table for each shape.
        #[derive(Debug)]
        pub(crate) struct Surfaces {
            $($module: $module::Table,)*
        }

        impl Surfaces {
            pub(crate) fn new(geometry: &Arc<Geometry>) -> Self {
                Self { $($module: SurfaceTable::new(geometry),)* }
            }
        }
    };
}

shapes!(surfaces);

impl Surfaces {
    /// The point where `ray` has this hit. In lanes, all hits have the same shape. `instanced`
    /// is set for [`Shape::Instance`].
    #[inline(always)]
    pub(crate) fn find<R: Real>(
        &self,
        shape: Shape,
        ray: &Ray<R>,
        hit: Hit<R>,
        instanced: bool,
    ) -> Surface<R> {
        // Without instances, the compiler can keep more of the other shapes in registers.
        assert!(instanced == (shape == Shape::Instance));
        match_shape!(shape, self, |table| table.find(ray, hit))
    }

    /// Whether `ray` meets a hole of a primitive, which is not on an instance, at distance `t`.
    pub(crate) fn is_hole(&self, primitive: u32, ray: &Ray, t: f32) -> bool {
        self.triangle.is_hole(primitive, ray, t)
    }

    /// [`SurfaceTable::second_uv`].
    pub(crate) fn second_uv<R: Real>(
        &self,
        shape: Shape,
        ray: &Ray<R>,
        hit: Hit<R>,
        surface: &Surface<R>,
    ) -> (R, R) {
        match_shape!(shape, self, |table| table.second_uv(ray, hit, surface))
    }

    /// [`SurfaceTable::color`].
    pub(crate) fn color<R: Real>(&self, shape: Shape, ray: &Ray<R>, hit: Hit<R>) -> R::Vec3 {
        match_shape!(shape, self, |table| table.color(ray, hit))
    }

    /// [`SurfaceTable::partials`].
    pub(crate) fn partials<R: Real>(
        &self,
        shape: Shape,
        ray: &Ray<R>,
        hit: Hit<R>,
        surface: &Surface<R>,
    ) -> Partials<R> {
        match_shape!(shape, self, |table| table.partials(ray, hit, surface))
    }

    /// [`SurfaceTable::uv`].
    pub(crate) fn uv<R: Real>(
        &self,
        shape: Shape,
        ray: &Ray<R>,
        hit: Hit<R>,
        surface: &Surface<R>,
    ) -> (R, R) {
        match_shape!(shape, self, |table| table.uv(ray, hit, surface))
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::*;
    use crate::geometry::{Instance, Quad, Sphere, Triangles, Vertices};
    use crate::math::{Stream, dot, length, max, normalize};

    /// One primitive of each shape, with texture coordinates of its own for each vertex of a mesh.
    fn geometries(random: &mut Stream) -> Vec<Geometry> {
        let mut vector = || Vec3::from_array([(); 3].map(|()| random.between(-1.0, 1.0)));
        let sphere = Sphere { center: vector(), center1: vector(), radius: 0.9 };
        let still = Sphere::still(vector(), 1.1);
        let quad = Quad::new(vector(), Vec3::X + vector() * 0.5, Vec3::Y + vector() * 0.5).unwrap();
        let positions = vec![vector() - Vec3::X, vector() + Vec3::X, vector() + Vec3::Y * 2.0];
        let uv = |v: Vec3| Vec2::new(v.x, v.y);
        let uvs = vec![uv(vector()), uv(vector()) + Vec2::X * 3.0, uv(vector()) + Vec2::Y * 3.0];
        let rows = [vector(), vector(), vector()].map(|row| row * 0.3);
        let matrix = [0, 1, 2].map(|i| {
            let mut row = rows[i].extend(0.5).to_array();
            row[i] += if i == 1 { -1.0 } else { 1.0 };
            row
        });
        let mut mapped = Triangles::default();
        mapped.add(Vertices { positions, uvs, ..Vertices::default() }, [[0, 1, 2]], true);
        let mut instanced = Geometry::default();
        instanced.instances.add_mesh(mapped.clone());
        instanced.instances.push(Instance::new(0, &matrix).unwrap());
        vec![
            Geometry { spheres: vec![still], ..Geometry::default() },
            Geometry { spheres: vec![sphere], ..Geometry::default() },
            Geometry { quads: vec![quad], ..Geometry::default() },
            Geometry { triangles: mapped.iter().collect(), ..Geometry::default() },
            Geometry { triangles: mapped, ..Geometry::default() },
            instanced,
        ]
    }

    /// Moves points along the surface by ∂p/∂u a + ∂p/∂v b. Their texture coordinates must then
    /// differ by (a, b).
    #[test]
    fn partials_predict_texture_coordinates() {
        let mut random = Stream::new(5);
        let mut hits = [0; 6];
        for _ in 0..2000 {
            for (kind, geometry) in geometries(&mut random).into_iter().enumerate() {
                let geometry = Arc::new(geometry);
                let (surfaces, shape) = (Surfaces::new(&geometry), geometry.shape(0));
                let mut vector = || Vec3::from_array([(); 3].map(|()| random.between(-1.0, 1.0)));
                let origin = normalize(vector()) * 6.0;
                let time = random.uniform();
                let at = |target: Vec3| {
                    let ray = Ray { origin, direction: normalize(target - origin), time };
                    let hit = geometry.closest_by_brute_force(&ray, 0.0, f32::INFINITY)?;
                    let instanced = shape == Shape::Instance;
                    let surface = surfaces.find::<f32>(shape, &ray, hit, instanced);
                    Some((ray, hit, surface, surfaces.uv::<f32>(shape, &ray, hit, &surface)))
                };
                let aim = Vec3::from_array([(); 3].map(|()| random.between(-1.0, 1.0)));
                let Some((ray, hit, surface, (u, v))) = at(aim) else { continue };
                let partials = surfaces.partials::<f32>(shape, &ray, hit, &surface);
                // Near the poles and silhouettes of spheres, the step is too coarse.
                let facing = dot(surface.normal, ray.direction).abs();
                if facing < 0.3 || length(partials.u) < 1.0 && kind < 2 {
                    continue;
                }
                let step = 1e-3 / (length(partials.u) + length(partials.v));
                let (a, b) = (random.between(-step, step), random.between(-step, step));
                let moved = surface.point + partials.u * a + partials.v * b;
                let Some((.., (next_u, next_v))) = at(moved) else { continue };
                if (next_u - u).abs() > 0.5 {
                    continue; // across the seam of a sphere
                }
                let off = max((next_u - u - a).abs(), (next_v - v - b).abs());
                assert!(off < 0.02 * step + 2e-6, "{shape:?}: {off} of {step}, {partials:?}");
                assert_eq!(partials.tangent, partials.u);
                hits[kind] += 1;
            }
        }
        assert!(hits.iter().all(|hits| *hits > 100), "{hits:?}");
    }
}
