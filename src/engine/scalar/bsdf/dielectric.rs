//! Clear glass: reflection or refraction, chosen by chance (report, III.E).

use super::{Arrival, SPECULAR, Scatter};
use crate::engine::dimension::{Dimension, Randoms};
use crate::math::{dot, fresnel, max, min, normalize, reflect};
use crate::scene::Fresnel;
use glam::Vec3;

/// A smooth surface of glass. Paths carry basic radiance, L/n², which refraction does not change: see
/// ARCHITECTURE.md.
pub(in crate::engine) struct Dielectric {
    pub(super) arrival: Arrival,
    pub(super) ior: f32,
    pub(super) fresnel: Fresnel,
}

impl Dielectric {
    pub(super) fn sample(&self, randoms: &Randoms) -> Scatter {
        let Self { arrival: Arrival { direction, normal, front }, ior, fresnel } = *self;
        let eta = if front { 1.0 / ior } else { ior };
        let cos = min(-dot(direction, normal), 1.0);
        let sin2_refracted = eta * eta * (1.0 - cos * cos);
        let reflectance = match fresnel {
            Fresnel::Schlick => fresnel::schlick(cos, ior),
            Fresnel::Exact => fresnel::dielectric(cos, if front { ior } else { 1.0 / ior }),
        };
        let reflected = sin2_refracted > 1.0 || randoms.one(Dimension::LOBE) < reflectance;
        let (side, direction) = if reflected {
            (normal, reflect(direction, normal))
        } else {
            let along = eta * cos - max(0.0, 1.0 - sin2_refracted).sqrt();
            (-normal, direction * eta + normal * along)
        };
        Scatter { direction: normalize(direction), side, weight: Vec3::ONE, pdf: SPECULAR }
    }
}
