//! The shapes that have code of their own in tests, leaf blocks and shading.

use glam::Vec3;

use super::Primitive;

/// A shape of primitives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    Sphere,
    MovingSphere,
    Quad,
    Triangle,
}

impl Shape {
    /// All shapes, by number.
    pub(crate) const ALL: [Self; 4] =
        [Self::Sphere, Self::MovingSphere, Self::Quad, Self::Triangle];

    pub(crate) fn of(primitive: Primitive<'_>) -> Self {
        match primitive {
            Primitive::Sphere(sphere) if sphere.motion() == Vec3::ZERO => Self::Sphere,
            Primitive::Sphere(_) => Self::MovingSphere,
            Primitive::Quad(_) => Self::Quad,
            Primitive::Triangle(_) => Self::Triangle,
        }
    }
}
