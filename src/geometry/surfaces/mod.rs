//! Computes the points where rays hit primitives, with one file for each shape.
//!
//! Each shape has a table of its primitives, which many lanes can read at once.

mod instance;
mod moving_sphere;
mod quad;
mod sphere;
mod triangle;

use std::sync::Arc;

use super::{Geometry, Hit, Ray, Shape, Surface, shapes};
use crate::math::Real;

/// The table of the primitives of one shape.
trait SurfaceTable {
    fn new(geometry: &Arc<Geometry>) -> Self;

    /// The point where `ray` has this hit.
    fn find<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>) -> Surface<R>;

    /// The texture coordinates of that point, both in [0, 1] up to rounding unless a mesh has its own.
    fn uv<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>, surface: &Surface<R>) -> (R, R);
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
                match shape {
                    $(Shape::$name => self.$module.find(ray, hit),)*
                }
            }

            /// The texture coordinates of that point, both in [0, 1] up to rounding unless a mesh has its own.
            pub(crate) fn uv<R: Real>(
                &self,
                shape: Shape,
                ray: &Ray<R>,
                hit: Hit<R>,
                surface: &Surface<R>,
            ) -> (R, R) {
                match shape {
                    $(Shape::$name => self.$module.uv(ray, hit, surface),)*
                }
            }
        }
    };
}

shapes!(surfaces);
