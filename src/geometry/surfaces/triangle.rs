//! Points on triangles.

use std::sync::Arc;

use super::SurfaceTable;
use crate::geometry::triangle::surface;
use crate::geometry::triangles::{MAPPED, Rows, SMOOTH, SOFT};
use crate::geometry::{Geometry, Hit, Ray, Shading, Surface};
use crate::math::{Mask, Real, Word, dot, normalize};
use crate::simd::axes;

/// A reference to the geometry, whose rows can be gathered as they are.
#[derive(Debug)]
pub(super) struct Table {
    /// The number of the first triangle among all primitives.
    first: u32,
    geometry: Arc<Geometry>,
}

/// The corners of triangles: the indices of their vertices, and the triangles' flags.
struct Corners<R: Real> {
    vertices: [R::Index; 3],
    flags: R::Word,
}

impl<R: Real> Corners<R> {
    /// The triangles with this flag.
    #[inline(always)]
    fn have(&self, flag: u32) -> R::Mask {
        !(self.flags & R::Word::splat(flag)).eq(R::Word::splat(0))
    }

    /// The row of each vertex.
    #[inline(always)]
    fn gather(&self, table: &[crate::math::Row]) -> [(R::Vec3, R); 3] {
        // `map` would call a function for each vertex.
        axes(|i| R::gather(table, self.vertices[i], |row| row))
    }
}

/// The value at the point with these barycentric coordinates for the second and the third vertex.
#[inline(always)]
fn interpolate<R: Real, T>(values: [T; 3], [second, third]: [R; 2]) -> T
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Mul<R, Output = T>,
{
    let [a, b, c] = values;
    a * (R::ONE - second - third) + b * second + c * third
}

impl Table {
    /// The table of the triangles of `geometry`, of which the first has the number `first`.
    pub(super) fn with_first(first: u32, geometry: Arc<Geometry>) -> Self {
        Self { first, geometry }
    }

    #[inline(always)]
    fn rows(&self) -> Rows<'_> {
        self.geometry.triangles.rows()
    }

    #[inline(always)]
    fn corners<R: Real>(&self, primitive: R::Word) -> Corners<R> {
        let Rows { corners, positions, .. } = self.rows();
        let index = R::index(primitive.wrapping_sub(R::Word::splat(self.first)), corners.len());
        let (vertices, flags) = R::gather(corners, index, |row| row);
        let vertex = |i: usize| R::index(vertices[i].to_bits(), positions.len());
        Corners { vertices: [vertex(0), vertex(1), vertex(2)], flags: flags.to_bits() }
    }

    /// The interpolated normals of the triangles that are smooth.
    #[inline(always)]
    fn shading<R: Real>(&self, corners: &Corners<R>, normal: R::Vec3, at: [R; 2]) -> Shading<R> {
        let smooth = corners.have(SMOOTH);
        if !smooth.any() {
            return Shading::flat(normal);
        }
        let vertices = corners.gather(self.rows().normals).map(|(normal, _)| normal);
        let mean = interpolate(vertices, at);
        // Opposite normals cancel.
        let smooth = smooth & dot(mean, mean).gt(R::splat(1e-6));
        let normal = smooth.select(normalize(mean), normal);
        Shading { normal, smooth, soft: smooth & corners.have(SOFT) }
    }
}

impl SurfaceTable for Table {
    fn new(geometry: &Arc<Geometry>) -> Self {
        Self::with_first(geometry.first_triangle() as u32, Arc::clone(geometry))
    }

    #[inline(always)]
    fn find<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>) -> Surface<R> {
        let corners = self.corners::<R>(hit.primitive);
        let positions = corners.gather(self.rows().positions).map(|(position, _)| position);
        let (surface, at) = surface(positions, ray, hit.t);
        Surface { shading: self.shading(&corners, surface.normal, at), ..surface }
    }

    /// The interpolated texture coordinates, or without these the barycentric coordinates for the
    /// second and the third vertex.
    #[inline(always)]
    fn uv<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>, _: &Surface<R>) -> (R, R) {
        let corners = self.corners::<R>(hit.primitive);
        let vertices = corners.gather(self.rows().positions);
        let (_, at) = surface(vertices.map(|(position, _)| position), ray, hit.t);
        let mapped = corners.have(MAPPED);
        if !mapped.any() {
            return at.into();
        }
        let u = interpolate(vertices.map(|(_, u)| u), at);
        let v = interpolate(corners.gather(self.rows().normals).map(|(_, v)| v), at);
        (mapped.select(u, at[0]), mapped.select(v, at[1]))
    }
}
