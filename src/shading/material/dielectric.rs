//! Clear, smooth glass (report, III.E).

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::{Bsdf, MaterialModel, MaterialParameters, Opacity, SPECULAR, Scatter};
use crate::checks::Location;
use crate::error::Result;
use crate::math::{Mask, Real, Row, Vector, dot, fresnel, max, min, normalize, reflect, row};
use crate::sampler::{Dimension, Randoms};
use crate::shading::{Interaction, TextureRef, TextureTables};

/// Clear glass in air. Each path is randomly either reflected or refracted.
///
/// Paths carry basic radiance, L/n², which refraction does not change; see ARCHITECTURE.md.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Dielectric {
    /// Index of refraction relative to air, 0.01 to 100.
    pub ior: f32,
    /// Formula for the reflectance.
    #[serde(default)]
    pub fresnel: Fresnel,
    /// Name of a normal map: an image texture with linear encoding.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<TextureRef>,
    /// Holes in the surface, which must then be of triangles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opacity: Option<Opacity>,
}

impl Dielectric {
    /// Creates the material without a normal map and without holes.
    pub fn new(ior: f32, fresnel: Fresnel) -> Self {
        Self { ior, fresnel, normal: None, opacity: None }
    }
}

/// Formula for the reflectance of a dielectric.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fresnel {
    /// Schlick's approximation. As in the report, it uses the angle of incidence, whichever side
    /// the path arrives on.
    #[default]
    Schlick,
    /// The exact Fresnel equations.
    Exact,
}

impl MaterialParameters for Dielectric {
    texture_methods!();

    fn transmits(&self) -> bool {
        true
    }

    fn absorption(&self) -> Option<Vec3> {
        Some(Vec3::ZERO)
    }

    fn check(&self, e: &Location<'_>) -> Result<()> {
        e.check((0.01..=100.0).contains(&self.ior), "ior", "in [0.01, 100]", self.ior)
    }
}

impl MaterialModel for Dielectric {
    /// (`f`, 0, 0), index of refraction. `f` is 1 for the exact Fresnel equations, 0 for Schlick.
    type Entry = Row;
    type Bsdf<R: Real> = DielectricBsdf<R>;

    const GLOSSY: bool = true;
    const TEXTURED: bool = true;

    fn entry(&self, _: &mut TextureTables) -> Row {
        let exact = if self.fresnel == Fresnel::Exact { 1.0 } else { 0.0 };
        row(Vec3::X * exact, self.ior)
    }

    #[inline(always)]
    fn bsdf<R: Real>(table: &[Row], index: R::Index, at: &Interaction<'_, R>) -> DielectricBsdf<R> {
        let (flags, ior) = R::gather(table, index, |row| row);
        let (exact, front) = (flags[0].gt(R::ZERO), at.front);
        DielectricBsdf { direction: at.ray.direction, normal: at.normals.mirror, front, ior, exact }
    }
}

pub(crate) struct DielectricBsdf<R: Real> {
    /// Direction of the arriving path.
    direction: R::Vec3,
    /// Normal on the side that was hit.
    normal: R::Vec3,
    front: R::Mask,
    ior: R,
    exact: R::Mask,
}

impl<R: Real> Bsdf<R> for DielectricBsdf<R> {
    #[inline(always)]
    fn specular(&self) -> R::Mask {
        R::Mask::ALL
    }

    #[inline(always)]
    fn albedo(&self) -> R::Vec3 {
        R::Vec3::gray(R::ONE)
    }

    #[inline(always)]
    fn sample(&self, randoms: &Randoms<R>) -> Scatter<R> {
        let Self { direction, normal, front, ior, exact } = *self;
        let inverse = R::ONE / ior;
        let eta = front.select(inverse, ior);
        let cos = min(-dot(direction, normal), R::ONE);
        let sin2_refracted = eta * eta * (R::ONE - cos * cos);
        let mut reflectance = fresnel::schlick(cos, ior);
        if exact.any() {
            let beyond = front.select(ior, inverse);
            reflectance = exact.select(fresnel::dielectric(cos, beyond), reflectance);
        }
        let reflected = sin2_refracted.gt(R::ONE) | randoms.one(Dimension::LOBE).lt(reflectance);
        let along = eta * cos - max(R::ZERO, R::ONE - sin2_refracted).sqrt();
        let refraction = direction * eta + normal * along;
        let next = reflected.select(reflect(direction, normal), refraction);
        Scatter {
            direction: normalize(next),
            transmitted: !reflected,
            weight: R::Vec3::gray(R::ONE),
            pdf: R::splat(SPECULAR),
            scattered: R::Mask::ALL,
        }
    }

    #[inline(always)]
    fn evaluate(&self, _: R::Vec3) -> (R::Vec3, R) {
        (R::Vec3::zero(), R::ZERO)
    }
}
