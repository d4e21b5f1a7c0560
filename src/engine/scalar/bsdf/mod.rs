//! How surfaces and media scatter light: a file for each model, with its samples, values and densities side by
//! side.

mod conductor;
mod dielectric;
mod diffuse;
mod metal;
mod phase;
mod rough_dielectric;

use glam::Vec3;

use crate::engine::dimension::Randoms;
use crate::scene::Material;
use conductor::Conductor;
use dielectric::Dielectric;
use diffuse::Diffuse;
use metal::Metal;
use phase::Phase;
use rough_dielectric::RoughDielectric;

/// Where a path arrives at a surface.
#[derive(Clone, Copy)]
pub(in crate::engine) struct Arrival {
    /// Of the path, of unit length.
    pub(in crate::engine) direction: Vec3,
    /// Of the surface, on the side that was hit.
    pub(in crate::engine) normal: Vec3,
    /// Whether that is the front.
    pub(in crate::engine) front: bool,
}

/// The light that a surface or a medium scatters from all directions to that from which a path has come.
pub(in crate::engine) enum Bsdf {
    Diffuse(Diffuse),
    Metal(Metal),
    Dielectric(Dielectric),
    Conductor(Conductor),
    RoughDielectric(RoughDielectric),
    Phase(Phase),
}

/// A direction that a path takes.
pub(in crate::engine) struct Scatter {
    /// Of unit length.
    pub(in crate::engine) direction: Vec3,
    /// The normal on whose side it leaves.
    pub(in crate::engine) side: Vec3,
    /// f·|cos θ|/pdf.
    pub(in crate::engine) weight: Vec3,
    /// Density of the direction per unit solid angle; [`SPECULAR`] where it is the only one.
    pub(in crate::engine) pdf: f32,
}

/// The density of directions that nothing but the surface itself could have chosen.
pub(in crate::engine) const SPECULAR: f32 = f32::INFINITY;

impl Bsdf {
    /// That of `material`, which is no light and whose textures have these colours.
    pub(in crate::engine) fn new(
        material: &Material,
        arrival: Arrival,
        color: impl Fn(u32) -> Vec3,
    ) -> Self {
        let normal = arrival.normal;
        match *material {
            Material::Diffuse { albedo } => {
                Self::Diffuse(Diffuse { normal, albedo: color(albedo), cosine: false })
            }
            Material::Lambertian { albedo } => {
                Self::Diffuse(Diffuse { normal, albedo: color(albedo), cosine: true })
            }
            Material::Metal { albedo, fuzz } => {
                Self::Metal(Metal::new(arrival, color(albedo), fuzz))
            }
            Material::Dielectric { ior, fresnel } => {
                Self::Dielectric(Dielectric { arrival, ior, fresnel })
            }
            Material::Conductor { eta, k, alpha } => {
                Self::Conductor(Conductor::new(arrival, eta, k, alpha))
            }
            Material::RoughDielectric { ior, alpha } => {
                Self::RoughDielectric(RoughDielectric::new(arrival, ior, alpha))
            }
            Material::Light(_) => unreachable!("lights scatter nothing"),
        }
    }

    /// That of a medium.
    pub(in crate::engine) fn phase(albedo: Vec3) -> Self {
        Self::Phase(Phase { albedo })
    }

    /// Whether all its directions are [`SPECULAR`].
    pub(in crate::engine) fn is_specular(&self) -> bool {
        match self {
            Self::Diffuse(_) | Self::RoughDielectric(_) | Self::Phase(_) => false,
            Self::Metal(metal) => metal.is_specular(),
            Self::Conductor(conductor) => conductor.ggx.alpha == 0.0,
            Self::Dielectric(_) => true,
        }
    }

    /// A direction about as likely as it carries light; `None` where the path is absorbed.
    pub(in crate::engine) fn sample(&self, randoms: &Randoms) -> Option<Scatter> {
        match self {
            Self::Diffuse(diffuse) => Some(diffuse.sample(randoms)),
            Self::Metal(metal) => metal.sample(randoms),
            Self::Dielectric(dielectric) => Some(dielectric.sample(randoms)),
            Self::Conductor(conductor) => conductor.sample(randoms),
            Self::RoughDielectric(dielectric) => dielectric.sample(randoms),
            Self::Phase(phase) => Some(phase.sample(randoms)),
        }
    }

    /// f·|cos θ| for the unit vector `direction`, and the density with which [`Self::sample`] draws
    /// it; neither tells of specular directions.
    pub(in crate::engine) fn evaluate(&self, direction: Vec3) -> (Vec3, f32) {
        match self {
            Self::Diffuse(diffuse) => diffuse.evaluate(direction),
            Self::Metal(metal) => metal.evaluate(direction),
            Self::Dielectric(_) => (Vec3::ZERO, 0.0),
            Self::Conductor(conductor) => conductor.evaluate(direction),
            Self::RoughDielectric(dielectric) => dielectric.evaluate(direction),
            Self::Phase(phase) => phase.evaluate(),
        }
    }
}
