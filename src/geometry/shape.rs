//! The shapes that have code of their own in tests, leaf blocks and shading.

/// Hands the list of shapes to the macro `$list`: the variant of [`Shape`], and its module in `accel/leaf`.
macro_rules! shapes {
    ($list:ident) => {
        $list! {
            Sphere in sphere,
            MovingSphere in moving_sphere,
            Quad in quad,
            Triangle in triangle,
        }
    };
}
pub(crate) use shapes;

macro_rules! shape {
    ($($name:ident in $module:ident,)*) => {
        /// A shape of primitives.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Shape {
            $($name,)*
        }

        impl Shape {
            /// All shapes, by number.
            pub(crate) const ALL: &[Self] = &[$(Self::$name,)*];
        }
    };
}

shapes!(shape);
