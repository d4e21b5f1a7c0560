//! Rays, primitives and their contract intersections.
//!
//! A primitive's `intersect` is the definition of a hit: over all primitives the closest
//! hit has the least distance in the open interval, ties go to the lowest index. No
//! acceleration structure enters the definition.

mod bounds;
pub(crate) mod quad;
mod ray;
pub(crate) mod ray_lanes;
mod shape;
pub(crate) mod sphere;
mod surfaces;
pub(crate) mod triangle;
mod volume;

pub use bounds::Bounds;
pub use quad::Quad;
pub(crate) use ray::PreparedRay;
pub(crate) use ray::shear_axes;
pub use ray::{Hit, Ray};
pub(crate) use shape::{Shape, shapes};
pub use sphere::Sphere;
pub(crate) use sphere::distance as sphere_distance;
pub(crate) use surfaces::Surfaces;
pub use triangle::Triangle;
pub(crate) use volume::Volume;

use glam::Vec3;

use crate::math::{Real, max};

/// A point of a surface, as found by a ray, or one a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface<R: Real = f32> {
    /// The point, moved onto the primitive where that is more exact than `o + t d`.
    pub point: R::Vec3,
    /// Unit geometric normal on the primitive's front: outward of a sphere, `u × v` of a
    /// quad, counter-clockwise of a triangle.
    pub normal: R::Vec3,
    /// How far along the normal a ray must start to be surely off the surface.
    pub offset: R,
}

impl<R: Real> Surface<R> {
    /// Origin of a ray that leaves on the side of `side`, ±`normal`.
    ///
    /// The distance bounds the rounding errors of the point and of the primitive's own
    /// test (Pharr et al., section 6.8), so that no ray meets the surface that it leaves.
    #[inline(always)]
    pub(crate) fn spawn(&self, side: R::Vec3) -> R::Vec3 {
        self.point + side * self.offset
    }
}

/// All primitives of a scene. A primitive's index is its position in the order spheres,
/// quads, triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Geometry {
    /// Still and moving spheres.
    pub spheres: Vec<Sphere>,
    /// Parallelograms.
    pub quads: Vec<Quad>,
    /// Triangles.
    pub triangles: Vec<Triangle>,
}

/// A reference to one primitive.
#[derive(Clone, Copy, Debug)]
pub enum Primitive<'a> {
    /// A sphere.
    Sphere(&'a Sphere),
    /// A quad.
    Quad(&'a Quad),
    /// A triangle.
    Triangle(&'a Triangle),
}

impl Geometry {
    /// Number of primitives.
    pub fn len(&self) -> usize {
        self.spheres.len() + self.quads.len() + self.triangles.len()
    }

    /// Whether there is no primitive.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Primitive number `index`, which must be below [`Geometry::len`].
    #[inline(always)]
    pub fn get(&self, index: u32) -> Primitive<'_> {
        let index = index as usize;
        if let Some(sphere) = self.spheres.get(index) {
            return Primitive::Sphere(sphere);
        }
        let index = index - self.spheres.len();
        match self.quads.get(index) {
            Some(quad) => Primitive::Quad(quad),
            None => Primitive::Triangle(&self.triangles[index - self.quads.len()]),
        }
    }

    /// A box around each primitive over all times.
    pub fn boxes(&self) -> Vec<Bounds> {
        (0..self.len() as u32).map(|primitive| self.get(primitive).bounds()).collect()
    }

    /// Whether anything moves: the moment of a ray matters.
    pub fn moves(&self) -> bool {
        self.spheres.iter().any(|sphere| sphere.motion() != Vec3::ZERO)
    }

    /// Largest [`Quad::condition`], at least 1.
    pub fn condition(&self) -> f32 {
        self.quads.iter().fold(1.0, |most, quad| max(most, quad.condition()))
    }

    /// The closest hit by trying every primitive: the definition that every
    /// acceleration structure is tested against.
    pub fn closest_by_brute_force(&self, ray: &Ray, t_min: f32, t_max: f32) -> Option<Hit> {
        if !ray.is_finite() {
            return None;
        }
        let ray = PreparedRay::new(ray);
        let mut best: Option<Hit> = None;
        for primitive in 0..self.len() as u32 {
            let limit = best.map_or(t_max, |hit| hit.t);
            if let Some(t) = self.get(primitive).intersect(&ray, t_min, limit) {
                best = Some(Hit { t, primitive });
            }
        }
        best
    }
}

impl Primitive<'_> {
    /// Distance of the first hit in the open interval `(t_min, t_max)`, in units of the
    /// length of the ray's direction.
    #[inline(always)]
    pub fn intersect(self, ray: &PreparedRay, t_min: f32, t_max: f32) -> Option<f32> {
        match self {
            Self::Sphere(sphere) => sphere.intersect(ray, t_min, t_max),
            Self::Quad(quad) => quad.intersect(ray, t_min, t_max),
            Self::Triangle(triangle) => triangle.intersect(ray, t_min, t_max),
        }
    }

    /// A box around the primitive over all times, `[0, 1]`.
    pub fn bounds(self) -> Bounds {
        match self {
            Self::Sphere(sphere) => sphere.bounds(),
            Self::Quad(quad) => quad.bounds(),
            Self::Triangle(triangle) => triangle.bounds(),
        }
    }
}
