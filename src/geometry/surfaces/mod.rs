//! Computes the points where rays hit primitives, with one file for each shape.
//!
//! Each shape has a table of its primitives, which many lanes can read at once.

mod moving_sphere;
mod quad;
mod sphere;
mod triangle;

use std::sync::Arc;

use super::{Geometry, Ray, Shape, Surface, shapes};
use crate::math::Real;

/// The table of the primitives of one shape.
trait SurfaceTable {
    fn new(geometry: &Arc<Geometry>) -> Self;

    /// The point that `ray` hits at distance `t`.
    fn find<R: Real>(&self, primitive: R::Word, ray: &Ray<R>, t: R) -> Surface<R>;

    /// The texture coordinates of that point, both in [0, 1] up to rounding unless a mesh has its own.
    fn uv<R: Real>(&self, primitive: R::Word, ray: &Ray<R>, surface: &Surface<R>, t: R) -> (R, R);
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

            /// The point that `ray` hits at distance `t`. In lanes, all primitives have the same
            /// shape.
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

            /// The texture coordinates of that point, both in [0, 1] up to rounding unless a mesh has its own.
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
