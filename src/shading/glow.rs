//! The light of surfaces whose radiance varies, by a texture or by holes.

use glam::{DVec3, Vec3};

use super::{TexturePoint, TextureTables};
use crate::geometry::{Hit, Primitive, Ray, Shape, Surface, Surfaces};
use crate::math::warp::uniform_sphere;
use crate::math::{Row, cross, normalize};

/// Number of points at which textures are evaluated to find the mean radiance of all primitives, unless there are
/// more primitives.
const POINTS: usize = 1 << 20;
/// No mean is below this share of the largest radiance, so that no texel is missed for ever.
const LEAST_MEAN: f32 = 1e-3;

/// A point of a primitive, without shading.
#[derive(Clone, Copy)]
pub(super) struct GlowPoint<'a> {
    surfaces: &'a Surfaces,
    shape: Shape,
    ray: Ray,
    hit: Hit,
    surface: Surface,
}

impl<'a> GlowPoint<'a> {
    /// The point that `ray` hits.
    pub(super) fn new(surfaces: &'a Surfaces, shape: Shape, ray: Ray, hit: Hit) -> Self {
        let surface = surfaces.find(shape, &ray, hit, shape == Shape::Instance);
        Self { surfaces, shape, ray, hit, surface }
    }

    /// The radiance of the light with this row, which is 0 in holes.
    pub(super) fn radiance(&self, textures: &TextureTables, row: Row) -> Vec3 {
        if self.surfaces.is_hole(self.hit.primitive, &self.ray, self.hit.t) {
            return Vec3::ZERO;
        }
        let [r, g, b, code] = row.map(f32::from_bits);
        textures.color::<f32>((Vec3::new(r, g, b), code), self)
    }
}

impl TexturePoint<f32> for GlowPoint<'_> {
    fn point(&self) -> Vec3 {
        self.surface.point
    }

    fn uv(&self) -> (f32, f32) {
        self.surfaces.uv(self.shape, &self.ray, self.hit, &self.surface)
    }

    fn second_uv(&self) -> (f32, f32) {
        self.surfaces.second_uv(self.shape, &self.ray, self.hit, &self.surface)
    }

    fn vertex_color(&self) -> Vec3 {
        self.surfaces.color(self.shape, &self.ray, self.hit)
    }
}

/// `n`² points spread evenly over a primitive, each with a normal.
fn points(primitive: Primitive, n: usize) -> impl Iterator<Item = (Vec3, Vec3)> {
    let at = move |i: usize| (i as f32 + 0.5) / n as f32;
    (0..n * n).map(move |i| {
        let (u, v) = (at(i % n), at(i / n));
        match primitive {
            Primitive::Sphere(sphere) => {
                let normal = uniform_sphere(u, v);
                (sphere.center + normal * sphere.radius, normal)
            }
            Primitive::Quad(quad) => (quad.q + quad.u * u + quad.v * v, quad.normal),
            Primitive::Triangle(triangle) => {
                let [a, b, c] = triangle.vertices;
                // The square-root mapping keeps areas (Turk 1990).
                let root = u.sqrt();
                let point = a + (b - a) * (root * (1.0 - v)) + (c - a) * (root * v);
                (point, normalize(cross(b - a, c - a)))
            }
        }
    })
}

/// The mean radiance of a primitive whose light has this row, one of `count`. `largest` bounds it.
pub(super) fn mean_radiance(
    (surfaces, textures): (&Surfaces, &TextureTables),
    (shape, number, primitive): (Shape, u32, Primitive),
    (row, largest): (Row, Vec3),
    count: usize,
) -> Vec3 {
    let n = (POINTS / count).clamp(1, 4096).isqrt();
    let radiance = |(point, normal): (Vec3, Vec3)| {
        let ray = Ray { origin: point + normal, direction: -normal, time: 0.0 };
        let point = GlowPoint::new(surfaces, shape, ray, Hit::of(number, 1.0));
        point.radiance(textures, row).as_dvec3()
    };
    let sum: DVec3 = points(primitive, n).map(radiance).sum();
    let mean = (sum / (n * n) as f64).as_vec3();
    // Of a texture that seems black, every colour is as likely.
    if mean == Vec3::ZERO { largest * LEAST_MEAN } else { mean }
}
