//! All primitives of a scene, and the definition of the closest hit.

mod instances;

use glam::Vec3;

pub use self::instances::Instances;
use super::primitive::{match_primitive, primitives};
use super::{
    Bounds, Hit, Holes, Instance, PreparedRay, PrimitiveModel, Quad, Ray, Shape, Sphere, Triangle,
    Triangles,
};
use crate::math::max;

/// A list of the primitives of one kind.
trait List {
    type Item;

    /// The primitive at `index`, or `None` beyond the end.
    fn at(&self, index: usize) -> Option<Self::Item>;
}

impl<T: Copy> List for Vec<T> {
    type Item = T;

    #[inline(always)]
    fn at(&self, index: usize) -> Option<T> {
        self.get(index).copied()
    }
}

impl List for Triangles {
    type Item = Triangle;

    #[inline(always)]
    fn at(&self, index: usize) -> Option<Triangle> {
        self.get(index)
    }
}

macro_rules! primitive {
    ($($(#[doc = $doc:literal])* $name:ident in $module:ident listed in $list:ident: $many:ty,)*) => {
        /// All primitives of a scene. A primitive's number is its position in the concatenation of
        /// these lists. The triangles of meshes that instances place have the numbers that follow.
        #[derive(Clone, Debug, Default, PartialEq)]
        pub struct Geometry {
            $($(#[doc = $doc])* pub $list: $many,)*
            /// Meshes placed any number of times.
            pub instances: Instances,
            /// The triangles that may have holes.
            #[doc(hidden)]
            pub holes: Holes,
        }

        /// One primitive.
        #[derive(Clone, Copy, Debug)]
        pub enum Primitive {
            $($(#[doc = $doc])* $name($name),)*
        }

        impl Geometry {
            /// Number of primitives, without instances.
            pub fn len(&self) -> usize {
                0 $(+ self.$list.len())*
            }

            /// The primitive with this index.
            ///
            /// # Panics
            /// If `index` is not below [`Geometry::len`].
            #[inline(always)]
            pub fn get(&self, index: u32) -> Primitive {
                let mut left = index as usize;
                $(
                    if let Some(primitive) = List::at(&self.$list, left) {
                        return Primitive::$name(primitive);
                    }
                    left = left.wrapping_sub(self.$list.len());
                )*
                panic!("primitive index {index} is out of range")
            }
        }

        impl Primitive {
            /// The name of the primitive's kind in messages. It is part of the scene's hash.
            pub(crate) fn name(self) -> &'static str {
                match self {
                    $(Self::$name(_) => stringify!($module),)*
                }
            }
        }
    };
}

primitives!(primitive);

impl Primitive {
    /// [`PrimitiveModel::intersect`].
    #[inline(always)]
    pub(crate) fn intersect(self, ray: &PreparedRay, t_min: f32, t_max: f32) -> Option<f32> {
        match_primitive!(self, |primitive| primitive.intersect(ray, t_min, t_max))
    }

    /// [`PrimitiveModel::bounds`].
    pub fn bounds(self) -> Bounds {
        match_primitive!(self, |primitive| primitive.bounds())
    }

    /// [`PrimitiveModel::shape`].
    pub(crate) fn shape(self) -> Shape {
        match_primitive!(self, |primitive| primitive.shape())
    }

    /// [`PrimitiveModel::identity`].
    pub(crate) fn identity(self) -> [Vec3; 3] {
        match_primitive!(self, |primitive| primitive.identity())
    }
}

impl Geometry {
    /// The index of the first triangle among all primitives.
    pub(crate) fn first_triangle(&self) -> usize {
        self.spheres.len() + self.quads.len()
    }

    /// Moves the tables of triangles to huge pages. Call this after the last primitive has been added.
    pub(crate) fn settle(&mut self) {
        self.triangles.settle();
        self.instances.settle();
    }

    /// Size of the lists in memory.
    pub(crate) fn bytes(&self) -> u64 {
        let Self { spheres, quads, triangles, instances, .. } = self;
        let solids = size_of_val(&**spheres) + size_of_val(&**quads);
        solids as u64 + triangles.bytes() + instances.bytes()
    }

    /// Whether there are no primitives and no instances.
    pub fn is_empty(&self) -> bool {
        self.elements() == 0
    }

    /// Number of elements, over which trees are built: the primitives, then the instances.
    pub fn elements(&self) -> usize {
        self.len() + self.instances.len()
    }

    /// Number of elements, and of triangles of meshes, over which trees are built.
    pub(crate) fn all_primitives(&self) -> u64 {
        (self.elements() + self.instances.triangle_count()) as u64
    }

    /// The shape of an element, or of a primitive including the triangles of meshes.
    #[inline(always)]
    pub(crate) fn shape(&self, number: u32) -> Shape {
        if (number as usize) < self.len() { self.get(number).shape() } else { Shape::Instance }
    }

    /// The name of the kind of primitive that was hit.
    pub(crate) fn name(&self, hit: &Hit) -> &'static str {
        if (hit.primitive as usize) < self.len() {
            self.get(hit.primitive).name()
        } else {
            "triangle of a mesh"
        }
    }

    /// The bounding box of each element over all times.
    pub fn boxes(&self) -> Vec<Bounds> {
        let primitives = (0..self.len() as u32).map(|primitive| self.get(primitive).bounds());
        primitives.chain(self.instances.boxes()).collect()
    }

    /// Whether any primitive moves, so that hits depend on the time of a ray.
    pub fn moves(&self) -> bool {
        self.spheres.iter().any(|sphere| sphere.motion() != Vec3::ZERO)
    }

    /// The largest [`Quad::condition`] or condition of an instance, at least 1.
    pub fn condition(&self) -> f32 {
        let quads = self.quads.iter().map(Quad::condition);
        let instances = self.instances.list().iter().map(Instance::condition);
        quads.chain(instances).fold(1.0, max)
    }

    /// [`Triangles::attributes`] of the primitive, which need not be a triangle.
    pub(crate) fn attributes(&self, primitive: u32) -> Option<(u32, Vec<f32>)> {
        self.triangles.attributes((primitive as usize).checked_sub(self.first_triangle())?)
    }

    /// Whether triangles, including those of meshes, may have holes.
    pub(crate) fn may_have_holes(&self) -> bool {
        self.holes.any() || self.instances.triangles().holes.any()
    }

    /// Whether a hit of primitive `primitive` at distance `t` is in a hole, and does not count.
    #[inline]
    pub(crate) fn is_hole(&self, primitive: u32, instance: u32, ray: &Ray, t: f32) -> bool {
        let triangle = (primitive as usize).checked_sub(self.first_triangle());
        let is_hole = |i| self.holes.is_hole(&self.triangles, i, instance, ray, t);
        self.holes.any() && triangle.is_some_and(is_hole)
    }

    /// Distance of the first hit of a primitive in the open interval `(t_min, t_max)` that is not in
    /// a hole.
    #[inline(always)]
    pub(crate) fn intersect(
        &self,
        primitive: u32,
        instance: u32,
        ray: &PreparedRay,
        t_min: f32,
        t_max: f32,
    ) -> Option<f32> {
        let t = self.get(primitive).intersect(ray, t_min, t_max)?;
        (!self.is_hole(primitive, instance, &ray.ray, t)).then_some(t)
    }

    /// Finds the closest hit by testing every primitive. This is the definition that every
    /// acceleration structure is tested against.
    pub fn closest_by_brute_force(&self, ray: &Ray, t_min: f32, t_max: f32) -> Option<Hit> {
        if !ray.is_finite() {
            return None;
        }
        let ray = PreparedRay::new(ray);
        let mut best: Option<Hit> = None;
        for primitive in 0..self.len() as u32 {
            let limit = best.map_or(t_max, |hit| hit.t);
            if let Some(t) = self.intersect(primitive, 0, &ray, t_min, limit) {
                best = Some(Hit::of(primitive, t));
            }
        }
        self.instances.closest_by_brute_force(&ray.ray, (t_min, t_max), self.len() as u32, best)
    }
}
