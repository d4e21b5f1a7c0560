//! The lights that can be sampled.

use glam::Vec3;

use super::material::{Emission, Material};
use crate::geometry::{Geometry, Primitive, Quad};

/// A primitive that shines and can be sampled from any point.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Index of the primitive.
    pub primitive: u32,
    /// What it emits.
    pub emission: Emission,
    /// Its shape, prepared for sampling.
    pub shape: LightShape,
}

/// How a light is sampled.
#[derive(Clone, Debug, PartialEq)]
pub enum LightShape {
    /// A sphere: uniform in the cone that it fills.
    Sphere,
    /// A rectangle: uniform in its solid angle.
    Rectangle(Rectangle),
    /// Any other parallelogram: uniform by area.
    Parallelogram,
}

/// A rectangle in its own orthonormal frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Corner.
    pub corner: Vec3,
    /// Unit vectors along the edges and the normal.
    pub axes: [Vec3; 3],
    /// Lengths of the edges.
    pub size: (f32, f32),
}

impl Rectangle {
    fn new(quad: &Quad) -> Self {
        let (u, v) = (quad.u.as_dvec3(), quad.v.as_dvec3());
        let (width, height) = (u.dot(u).sqrt(), v.dot(v).sqrt());
        Self {
            corner: quad.q,
            axes: [(u / width).as_vec3(), (v / height).as_vec3(), quad.normal],
            size: (width as f32, height as f32),
        }
    }
}

/// The lights of a scene in the order of their primitives. Triangles that shine are not
/// among them: a path finds them by hitting them.
pub(super) fn collect(geometry: &Geometry, materials: &[Material], of: &[u32]) -> Vec<Light> {
    let light = |(primitive, &material): (usize, &u32)| {
        let primitive = primitive as u32;
        let Material::Light(emission) = materials[material as usize] else { return None };
        let shape = match geometry.get(primitive) {
            Primitive::Sphere(_) => LightShape::Sphere,
            Primitive::Quad(quad) if quad.is_rectangle() => {
                LightShape::Rectangle(Rectangle::new(quad))
            }
            Primitive::Quad(_) => LightShape::Parallelogram,
            Primitive::Triangle(_) => return None,
        };
        (emission.radiance != Vec3::ZERO).then_some(Light { primitive, emission, shape })
    };
    of.iter().enumerate().filter_map(light).collect()
}
