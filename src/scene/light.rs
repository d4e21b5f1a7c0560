//! The lights that can be sampled.

use glam::{DVec3, Vec3};
use std::f64::consts::PI;

use super::alias::AliasTable;
use super::material::{Emission, Material, Sides};
use crate::geometry::{Geometry, Primitive, Quad, Sphere, Triangle};

/// A primitive that shines and can be sampled from any point.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Index of the primitive.
    pub primitive: u32,
    /// What it emits.
    pub emission: Emission,
    /// Chance of being chosen, in proportion to its power.
    pub chance: f32,
    /// Its shape, prepared for sampling.
    pub shape: LightShape,
}

/// How a light is sampled.
#[derive(Clone, Debug, PartialEq)]
pub enum LightShape {
    /// Uniform in the cone that it fills.
    Sphere(Sphere),
    /// Uniform in its solid angle if it is a rectangle, else by area.
    Quad(QuadLight),
    /// Uniform in its solid angle.
    Triangle(TriangleLight),
}

/// A parallelogram in a frame of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadLight {
    /// Corner.
    pub corner: Vec3,
    /// Unit vectors along the edges and the normal.
    pub axes: [Vec3; 3],
    /// Lengths of the edges.
    pub size: (f32, f32),
    /// Area.
    pub area: f32,
    /// Whether it is a rectangle.
    pub rectangle: bool,
}

/// A triangle with its plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleLight {
    /// The vertices.
    pub vertices: [Vec3; 3],
    /// Unit normal of the front.
    pub normal: Vec3,
    /// Area.
    pub area: f32,
}

/// The lights of a scene in the order of their primitives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lights {
    lights: Vec<Light>,
    /// The light that each primitive is, or [`Self::NONE`].
    of_primitive: Vec<u32>,
    table: Option<AliasTable>,
}

impl Lights {
    pub(crate) const NONE: u32 = u32::MAX;

    /// Those of the primitives whose materials, `of`, shine.
    pub(super) fn new(geometry: &Geometry, materials: &[Material], of: &[u32]) -> Self {
        let (mut lights, mut powers) = (Vec::new(), Vec::new());
        let mut of_primitive = vec![Self::NONE; of.len()];
        for (primitive, &material) in (0..).zip(of) {
            let Material::Light(emission) = materials[material as usize] else { continue };
            if emission.radiance == Vec3::ZERO {
                continue;
            }
            let (shape, area) = shape(geometry.get(primitive));
            of_primitive[primitive as usize] = lights.len() as u32;
            powers.push(power(&emission, area));
            lights.push(Light { primitive, emission, chance: 1.0, shape });
        }
        let table = (!lights.is_empty()).then(|| AliasTable::new(&powers));
        for (light, index) in lights.iter_mut().zip(0..) {
            let share = table.as_ref().map_or(0, |table| table.share(index));
            light.chance = share as f32 * (1.0 / 4_294_967_296.0);
        }
        Self { lights, of_primitive, table }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }

    /// All of them.
    pub fn all(&self) -> &[Light] {
        &self.lights
    }

    /// The light that 32 random bits choose.
    ///
    /// # Panics
    /// Where there are none.
    #[inline]
    pub fn choose(&self, bits: u32) -> &Light {
        let table = self.table.as_ref().expect("there are lights");
        &self.lights[table.choose(bits) as usize]
    }

    /// The light that a primitive is, if it is one.
    #[inline]
    pub fn of(&self, primitive: u32) -> Option<&Light> {
        self.lights.get(self.of_primitive[primitive as usize] as usize)
    }

    /// [`Self::of`] as numbers.
    pub(crate) fn of_primitives(&self) -> &[u32] {
        &self.of_primitive
    }

    /// By which they are chosen, if there are any.
    pub(crate) fn table(&self) -> Option<&AliasTable> {
        self.table.as_ref()
    }
}

/// Radiant power in proportion to others': the luminance of what is emitted (Rec. 709), on all sides
/// that shine. Not 0, however dim.
fn power(emission: &Emission, area: f64) -> f64 {
    let [r, g, b] = emission.radiance.as_dvec3().to_array();
    let sides = if emission.sides == Sides::Both { 2.0 } else { 1.0 };
    let power = (0.2126 * r + 0.7152 * g + 0.0722 * b) * area * sides;
    if power > 1e-300 { power } else { 1e-300 }
}

/// A primitive as a light, and its area.
fn shape(primitive: Primitive<'_>) -> (LightShape, f64) {
    match primitive {
        Primitive::Sphere(sphere) => {
            let radius = f64::from(sphere.radius);
            (LightShape::Sphere(*sphere), 4.0 * PI * radius * radius)
        }
        Primitive::Quad(quad) => {
            let light = QuadLight::new(quad);
            (LightShape::Quad(light), f64::from(light.area))
        }
        Primitive::Triangle(triangle) => {
            let light = TriangleLight::new(triangle);
            (LightShape::Triangle(light), f64::from(light.area))
        }
    }
}

impl QuadLight {
    fn new(quad: &Quad) -> Self {
        let (u, v) = (quad.u.as_dvec3(), quad.v.as_dvec3());
        let (width, height) = (u.dot(u).sqrt(), v.dot(v).sqrt());
        Self {
            corner: quad.q,
            axes: [(u / width).as_vec3(), (v / height).as_vec3(), quad.normal],
            size: (width as f32, height as f32),
            area: quad.area(),
            rectangle: quad.is_rectangle(),
        }
    }
}

impl TriangleLight {
    fn new(triangle: &Triangle) -> Self {
        let [a, b, c] = triangle.vertices.map(|v| v.as_dvec3());
        let normal: DVec3 = (b - a).cross(c - a);
        let twice = normal.dot(normal).sqrt();
        Self {
            vertices: triangle.vertices,
            normal: (normal / twice).as_vec3(),
            area: (0.5 * twice) as f32,
        }
    }
}
