//! The points where rays hit primitives, from tables that vectors can read: one file for each shape.

mod moving_sphere;
mod quad;
mod sphere;
mod triangle;

use std::sync::Arc;

use super::{Geometry, Ray, Shape, Surface, shapes};
use crate::math::Real;

/// The primitives of one shape in rows.
trait SurfaceTable {
    fn new(geometry: &Arc<Geometry>) -> Self;

    /// The points that `ray` hits at distance `t`.
    fn find<R: Real>(&self, primitive: R::Word, ray: &Ray<R>, t: R) -> Surface<R>;

    /// The texture coordinates of such points, both in [0, 1] up to rounding.
    fn uv<R: Real>(&self, primitive: R::Word, ray: &Ray<R>, surface: &Surface<R>, t: R) -> (R, R);
}

macro_rules! surfaces {
    ($($name:ident in $module:ident,)*) => {
        /// A geometry's primitives in rows, a table for each shape.
        #[derive(Debug)]
        pub(crate) struct Surfaces {
            $($module: $module::Table,)*
        }

        impl Surfaces {
            pub(crate) fn new(geometry: &Arc<Geometry>) -> Self {
                Self { $($module: SurfaceTable::new(geometry),)* }
            }

            /// The points that `ray` hits at distance `t`, on primitives of one shape.
            #[inline(always)]
            pub(crate) fn find<R: Real>(
                &self,
                shape: Shape,
                primitive: R::Word,
                ray: &Ray<R>,
                t: R,
            ) -> Surface<R> {
                match shape {
                    $(Shape::$name => self.$module.find(primitive, ray, t),)*
                }
            }

            /// The texture coordinates of such points, both in [0, 1] up to rounding.
            pub(crate) fn uv<R: Real>(
                &self,
                shape: Shape,
                primitive: R::Word,
                ray: &Ray<R>,
                surface: &Surface<R>,
                t: R,
            ) -> (R, R) {
                match shape {
                    $(Shape::$name => self.$module.uv(primitive, ray, surface, t),)*
                }
            }
        }
    };
}

shapes!(surfaces);
