//! The lists of all primitives and shapes, and the trait that each primitive implements.

use glam::Vec3;

use super::{Bounds, PreparedRay};

/// Passes the list of primitives to the macro `$list`, after `$arguments`. Each entry has the type, its
/// module, and the name and type of its list in [`Geometry`](super::Geometry).
macro_rules! primitives {
    ($list:ident $($arguments:tt)?) => {
        $list! {
            $($arguments)?
            /// Spheres, still or moving.
            Sphere in sphere listed in spheres: Vec<Sphere>,
            /// Parallelograms.
            Quad in quad listed in quads: Vec<Quad>,
            /// Triangles.
            Triangle in triangle listed in triangles: Triangles,
        }
    };
}
pub(crate) use primitives;

/// Passes the list of shapes to the macro `$list`, after `$arguments`. Each entry has the variant of
/// [`Shape`], and the name of its module in `accel/leaf` and `geometry/surfaces`. Every shape has its
/// own code for ray tests, leaf blocks and shading.
macro_rules! shapes {
    ($list:ident $($arguments:tt)?) => {
        $list! {
            $($arguments)?
            Sphere in sphere,
            MovingSphere in moving_sphere,
            Quad in quad,
            Triangle in triangle,
            Instance in instance,
        }
    };
}
pub(crate) use shapes;

/// `match_primitive!(value, |primitive| code)` runs `code` with the sphere, quad or triangle in `value`,
/// compiled for each of these types.
macro_rules! match_primitive {
    ([$value:expr, $primitive:ident, $code:expr]
     $($(#[$doc:meta])* $name:ident in $module:ident listed in $list:ident: $many:ty,)*) => {
        match $value {
            $(Primitive::$name($primitive) => $code,)*
        }
    };
    ($value:expr, |$primitive:ident| $code:expr) => {
        primitives!(match_primitive [$value, $primitive, $code])
    };
}
pub(super) use match_primitive;

/// `match_shape!(shape, tables, |table| code)` runs `code` with a reference to the field of `tables` for
/// this shape, compiled for each shape.
macro_rules! match_shape {
    ([$shape:expr, $tables:expr, $table:ident, $code:expr] $($name:ident in $module:ident,)*) => {
        match $shape {
            $(Shape::$name => {
                let $table = &$tables.$module;
                $code
            })*
        }
    };
    ($shape:expr, $tables:expr, |$table:ident| $code:expr) => {
        shapes!(match_shape [$shape, $tables, $table, $code])
    };
}
pub(crate) use match_shape;

/// A kind of primitive.
pub(crate) trait PrimitiveModel: Sized {
    /// The numbers that define a primitive.
    type Record;

    /// Distance of the first hit in the open interval `(t_min, t_max)`, in units of the length of
    /// the ray's direction.
    fn intersect(&self, ray: &PreparedRay, t_min: f32, t_max: f32) -> Option<f32>;

    /// A box that contains the primitive at all times in `[0, 1]`.
    fn bounds(&self) -> Bounds;

    /// The shape, which selects the code that tests and shades the primitive.
    fn shape(&self) -> Shape;

    /// The vectors that define the primitive, for the scene's hash.
    fn identity(&self) -> [Vec3; 3];

    /// The numbers that define the primitive, for ray sets.
    fn record(&self) -> Self::Record;

    /// Builds the primitive that the finite numbers of `record` define. `Err` contains the
    /// condition that the numbers must satisfy.
    fn from_record(record: &Self::Record) -> Result<Self, &'static str>;
}

macro_rules! shape {
    ($($name:ident in $module:ident,)*) => {
        /// The shape of a primitive. Still and moving spheres are different shapes, and so are
        /// triangles and instances of triangles.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Shape {
            $($name,)*
        }

        impl Shape {
            /// All shapes, in the order of their discriminants.
            pub(crate) const ALL: [Self; [$(Self::$name,)*].len()] = [$(Self::$name,)*];

            /// The shape with this discriminant, or the last one if there is none.
            #[inline(always)]
            pub(crate) fn of_bits(bits: u32) -> Self {
                $(if bits == Self::$name as u32 {
                    return Self::$name;
                })*
                Self::ALL[Self::ALL.len() - 1]
            }
        }
    };
}

shapes!(shape);

/// The components of three vectors, in order.
pub(super) fn components(vectors: [Vec3; 3]) -> [f32; 9] {
    let [[a, b, c], [d, e, f], [g, h, i]] = vectors.map(|vector| vector.to_array());
    [a, b, c, d, e, f, g, h, i]
}

/// The inverse of [`components`].
pub(super) fn vectors(&[a, b, c, d, e, f, g, h, i]: &[f32; 9]) -> [Vec3; 3] {
    [[a, b, c], [d, e, f], [g, h, i]].map(Vec3::from_array)
}
