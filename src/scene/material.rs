//! Materials and the background, resolved: names have become indices.

use glam::Vec3;

pub use super::description::{Fresnel, Sides};

/// How a surface scatters light. Textures are indices into the scene's list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Material {
    /// Uniform over the hemisphere: f·cos θ = ρ/2π (report, III.B).
    Diffuse {
        /// Texture of ρ.
        albedo: u32,
    },
    /// Lambert's law: f = ρ/π (report, III.C).
    Lambertian {
        /// Texture of ρ.
        albedo: u32,
    },
    /// Mirror direction + `fuzz` × a uniform point of the unit ball (report, III.D).
    Metal {
        /// Texture of the reflectance.
        albedo: u32,
        /// 0 (mirror) to 1.
        fuzz: f32,
    },
    /// Clear glass in air (report, III.E).
    Dielectric {
        /// Index of refraction relative to air.
        ior: f32,
        /// How much is reflected.
        fresnel: Fresnel,
    },
    /// Frosted glass in air, by GGX microfacets.
    RoughDielectric {
        /// Index of refraction relative to air.
        ior: f32,
        /// Roughness α.
        alpha: f32,
    },
    /// Metal by its complex index of refraction.
    Conductor {
        /// Real part, a channel each.
        eta: Vec3,
        /// Imaginary part, a channel each.
        k: Vec3,
        /// Roughness α of GGX microfacets; 0 is smooth.
        alpha: f32,
    },
    /// Emits and absorbs (report, III.G).
    Light(Emission),
}

/// What a light emits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// Linear RGB.
    pub radiance: Vec3,
    /// The sides that shine.
    pub sides: Sides,
}

impl Emission {
    /// Radiance towards a viewer, on the front of the surface or not.
    #[inline]
    pub fn radiance(&self, front: bool) -> Vec3 {
        match self.sides {
            Sides::Both => self.radiance,
            Sides::Front if front => self.radiance,
            Sides::Front => Vec3::ZERO,
        }
    }
}

/// Radiance from outside the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    /// The same in all directions.
    Constant(Vec3),
    /// Linear in the height of the unit direction, from −y to +y.
    Gradient {
        /// At −y.
        bottom: Vec3,
        /// At +y.
        top: Vec3,
    },
}

impl Background {
    /// Radiance seen along the unit vector `direction`.
    #[inline]
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        match *self {
            Self::Constant(radiance) => radiance,
            Self::Gradient { bottom, top } => {
                let t = 0.5 * (direction.y + 1.0);
                bottom * (1.0 - t) + top * t
            }
        }
    }
}
