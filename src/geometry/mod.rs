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

/// What a kind of primitive is.
pub(crate) trait PrimitiveModel {
    /// Distance of the first hit in the open interval `(t_min, t_max)`, in units of the length of the
    /// ray's direction.
    fn intersect(&self, ray: &PreparedRay, t_min: f32, t_max: f32) -> Option<f32>;

    /// A box around it over all times, `[0, 1]`.
    fn bounds(&self) -> Bounds;

    /// How it is tested and shaded.
    fn shape(&self) -> Shape;

    /// The vectors that define it, for the scene's hash.
    fn identity(&self) -> [Vec3; 3];
}

macro_rules! primitives {
    ($($(#[doc = $doc:literal])* $name:ident in $list:ident called $word:literal,)*) => {
        /// All primitives of a scene. A primitive's index is its position in the order of these lists.
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct Geometry {
            $($(#[doc = $doc])* pub $list: Vec<$name>,)*
        }

        /// A reference to one primitive.
        #[derive(Clone, Copy, Debug)]
        pub enum Primitive<'a> {
            $($(#[doc = $doc])* $name(&'a $name),)*
        }

        impl Geometry {
            /// Number of primitives.
            pub fn len(&self) -> usize {
                0 $(+ self.$list.len())*
            }

            /// Primitive number `index`.
            ///
            /// # Panics
            /// If `index` is not below [`Geometry::len`].
            #[inline(always)]
            pub fn get(&self, index: u32) -> Primitive<'_> {
                let mut left = index as usize;
                $(
                    if let Some(primitive) = self.$list.get(left) {
                        return Primitive::$name(primitive);
                    }
                    left = left.wrapping_sub(self.$list.len());
                )*
                panic!("no primitive has the number {index}")
            }
        }

        impl Primitive<'_> {
            /// Its name in messages, which is part of the scene's hash.
            pub(crate) fn name(self) -> &'static str {
                match self {
                    $(Self::$name(_) => $word,)*
                }
            }

            /// [`PrimitiveModel::intersect`].
            #[inline(always)]
            pub(crate) fn intersect(self, ray: &PreparedRay, t_min: f32, t_max: f32) -> Option<f32> {
                match self {
                    $(Self::$name(primitive) => primitive.intersect(ray, t_min, t_max),)*
                }
            }

            /// [`PrimitiveModel::bounds`].
            pub fn bounds(self) -> Bounds {
                match self {
                    $(Self::$name(primitive) => primitive.bounds(),)*
                }
            }

            /// [`PrimitiveModel::shape`].
            pub(crate) fn shape(self) -> Shape {
                match self {
                    $(Self::$name(primitive) => primitive.shape(),)*
                }
            }

            /// [`PrimitiveModel::identity`].
            pub(crate) fn identity(self) -> [Vec3; 3] {
                match self {
                    $(Self::$name(primitive) => primitive.identity(),)*
                }
            }
        }
    };
}

primitives! {
    /// Spheres, still or moving.
    Sphere in spheres called "sphere",
    /// Parallelograms.
    Quad in quads called "quad",
    /// Triangles.
    Triangle in triangles called "triangle",
}

impl Geometry {
    /// Whether there is no primitive.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
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
