//! Points on triangles.

use std::sync::Arc;

use glam::Vec3;

use super::{Partials, SurfaceTable};
use crate::geometry::triangle::{inset, surface};
use crate::geometry::triangles::{COLORED, MAPPED, MAPPED_TWICE, Rows, SMOOTH, SOFT, TANGENT};
use crate::geometry::{Geometry, Hit, Ray, ShadingNormal, Surface, Triangles};
use crate::math::{Mask, Real, Vector, Word, dot, normalize};
use crate::simd::axes;

/// A reference to the geometry, whose rows can be gathered as they are.
#[derive(Debug)]
pub(super) struct Table {
    /// The number of the first triangle among all primitives.
    first: u32,
    geometry: Arc<Geometry>,
}

/// A point of a triangle.
pub(super) struct Face<R: Real> {
    /// The first vertex.
    first: R::Vec3,
    /// The edges from there to the others.
    pub(super) edges: [R::Vec3; 2],
    /// The barycentric coordinates of the point for the second and the third vertex.
    pub(super) shares: [R; 2],
}

impl<R: Real> Face<R> {
    /// The point with these barycentric coordinates.
    #[inline(always)]
    pub(super) fn point(&self, [second, third]: [R; 2]) -> R::Vec3 {
        let [u, v] = self.edges;
        self.first + (u * second + v * third)
    }
}

/// A list of triangles.
#[derive(Clone, Copy)]
struct TriangleList<'a> {
    /// The number of the first triangle among all primitives.
    first: u32,
    triangles: &'a Triangles,
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

    /// Whether `ray` meets a hole of a primitive at distance `t`.
    pub(super) fn is_hole(&self, primitive: u32, ray: &Ray, t: f32) -> bool {
        self.geometry.is_hole(primitive, 0, ray, t)
    }

    /// The exact point where `ray` has this hit.
    #[inline(always)]
    pub(super) fn find_exactly<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>) -> (Surface<R>, Face<R>) {
        let corners = self.view().corners::<R>(hit.primitive);
        let [a, b, c] = corners.gather(self.view().rows().positions).map(|(position, _)| position);
        let (surface, shares) = surface([a, b, c], ray, hit.t);
        let shading = self.view().shading(&corners, surface.normal, shares);
        let face = Face { first: a, edges: [b - a, c - a], shares };
        (Surface { shading, ..surface }, face)
    }

    #[inline(always)]
    fn view(&self) -> TriangleList<'_> {
        TriangleList { first: self.first, triangles: &self.geometry.triangles }
    }
}

impl<'a> TriangleList<'a> {
    #[inline(always)]
    fn rows(&self) -> Rows<'a> {
        self.triangles.rows()
    }

    #[inline(always)]
    fn corners<R: Real>(&self, primitive: R::Word) -> Corners<R> {
        let Rows { corners, positions, .. } = self.rows();
        let index = R::index(primitive.wrapping_sub(R::Word::splat(self.first)), corners.len());
        let (vertices, flags) = R::gather(corners, index, |row| row);
        let vertex = |i: usize| R::index(vertices[i].to_bits(), positions.len());
        Corners { vertices: [vertex(0), vertex(1), vertex(2)], flags: flags.to_bits() }
    }

    /// The corners of the triangles that `ray` hits, and the barycentric coordinates of the hits for
    /// the second and the third vertex.
    #[inline(always)]
    fn locate<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>) -> (Corners<R>, [R; 2]) {
        let corners = self.corners::<R>(hit.primitive);
        let positions = corners.gather(self.rows().positions).map(|(position, _)| position);
        let (_, at) = surface(positions, ray, hit.t);
        (corners, at)
    }

    /// The texture coordinates u of the three vertices, and the coordinates v.
    #[inline(always)]
    fn uvs<R: Real>(&self, corners: &Corners<R>) -> [[R; 3]; 2] {
        let u = corners.gather(self.rows().positions).map(|(_, u)| u);
        [u, corners.gather(self.rows().normals).map(|(_, v)| v)]
    }

    /// The interpolated normals of the triangles that are smooth.
    #[inline(always)]
    fn shading<R: Real>(
        &self,
        corners: &Corners<R>,
        normal: R::Vec3,
        at: [R; 2],
    ) -> ShadingNormal<R> {
        let smooth = corners.have(SMOOTH);
        if !smooth.any() {
            return ShadingNormal::flat(normal);
        }
        let vertices = corners.gather(self.rows().normals).map(|(normal, _)| normal);
        let mean = interpolate(vertices, at);
        // Opposite normals cancel.
        let smooth = smooth & dot(mean, mean).gt(R::splat(1e-6));
        let normal = smooth.select(normalize(mean), normal);
        ShadingNormal { normal, smooth, soft: smooth & corners.have(SOFT) }
    }

    /// The interpolated texture coordinates, or without these the barycentric coordinates for the
    /// second and the third vertex.
    #[inline(always)]
    fn uv<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>) -> (R, R) {
        let (corners, at) = self.locate::<R>(ray, hit);
        let mapped = corners.have(MAPPED);
        if !mapped.any() {
            return at.into();
        }
        let [u, v] = self.uvs(&corners).map(|coordinates| interpolate(coordinates, at));
        (mapped.select(u, at[0]), mapped.select(v, at[1]))
    }

    fn second_uv<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>) -> (R, R) {
        let (first_u, first_v) = self.uv(ray, hit);
        let (corners, at) = self.locate::<R>(ray, hit);
        let mapped = corners.have(MAPPED_TWICE);
        if !mapped.any() {
            return (first_u, first_v);
        }
        let Rows { colors, tangents, .. } = self.rows();
        let u = interpolate(corners.gather(colors).map(|(_, u)| u), at);
        let v = interpolate(corners.gather(tangents).map(|(_, v)| v), at);
        (mapped.select(u, first_u), mapped.select(v, first_v))
    }

    fn color<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>) -> R::Vec3 {
        let (corners, at) = self.locate::<R>(ray, hit);
        let (colored, white) = (corners.have(COLORED), <R::Vec3 as Vector>::gray(R::ONE));
        if !colored.any() {
            return white;
        }
        let color = interpolate(corners.gather(self.rows().colors).map(|(color, _)| color), at);
        colored.select(color, white)
    }
}

impl Triangles {
    /// Texture coordinates where `ray` hits triangle `triangle` at distance `t`.
    pub(crate) fn uv(&self, triangle: u32, ray: &Ray, t: f32) -> (f32, f32) {
        TriangleList { first: 0, triangles: self }.uv(ray, Hit::of(triangle, t))
    }

    /// As [`uv`](Self::uv), for the second set, or the first if there is only one.
    pub(crate) fn second_uv(&self, triangle: u32, ray: &Ray, t: f32) -> (f32, f32) {
        TriangleList { first: 0, triangles: self }.second_uv(ray, Hit::of(triangle, t))
    }

    /// The interpolated colour of the vertices, or white.
    pub(crate) fn color(&self, triangle: u32, ray: &Ray, t: f32) -> Vec3 {
        TriangleList { first: 0, triangles: self }.color(ray, Hit::of(triangle, t))
    }
}

impl SurfaceTable for Table {
    fn new(geometry: &Arc<Geometry>) -> Self {
        Self::with_first(geometry.first_triangle() as u32, Arc::clone(geometry))
    }

    #[inline(always)]
    fn find<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>) -> Surface<R> {
        let (surface, face) = self.find_exactly(ray, hit);
        let point = face.point(inset(face.edges, face.shares, surface.offset));
        Surface { point, ..surface }
    }

    #[inline(always)]
    fn uv<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>, _: &Surface<R>) -> (R, R) {
        self.view().uv(ray, hit)
    }

    fn second_uv<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>, _: &Surface<R>) -> (R, R) {
        self.view().second_uv(ray, hit)
    }

    fn color<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>) -> R::Vec3 {
        self.view().color(ray, hit)
    }

    /// Solves the two equations that the edges and the differences of texture coordinates along them
    /// define.
    fn partials<R: Real>(&self, ray: &Ray<R>, hit: Hit<R>, _: &Surface<R>) -> Partials<R> {
        let (corners, at) = self.view().locate::<R>(ray, hit);
        let [a, b, c] = corners.gather(self.view().rows().positions).map(|(position, _)| position);
        let edges = [b - a, c - a];
        let mut partials = Partials::new(edges[0], edges[1]);
        let mapped = corners.have(MAPPED);
        if mapped.any() {
            let [u, v] = self.view().uvs(&corners).map(|[a, b, c]| [b - a, c - a]);
            let inverse = R::ONE / (u[0] * v[1] - u[1] * v[0]);
            let along_u = (edges[0] * v[1] - edges[1] * v[0]) * inverse;
            let along_v = (edges[1] * u[0] - edges[0] * u[1]) * inverse;
            partials =
                Partials::new(mapped.select(along_u, edges[0]), mapped.select(along_v, edges[1]));
        }
        let has_tangent = corners.have(TANGENT);
        if has_tangent.any() {
            let tangents = corners.gather(self.view().rows().tangents).map(|(tangent, _)| tangent);
            partials.tangent = has_tangent.select(interpolate(tangents, at), partials.tangent);
        }
        partials
    }
}
