//! The interface that all scattering shares.

use crate::math::{Mask, Real};
use crate::sampler::Randoms;

/// The scattering of light at a point of a surface or medium, seen from the direction that the path
/// comes from.
pub(crate) trait Bsdf<R: Real> {
    /// Whether light is scattered to the other side of the surface, too.
    const TRANSMITS: bool = false;

    /// Whether [`Scatter::pdf`] is [`SPECULAR`] for every sampled direction.
    #[inline(always)]
    fn specular(&self) -> R::Mask {
        R::Mask::NONE
    }

    /// Samples a direction, with a density roughly proportional to the light that it carries.
    fn sample(&self, randoms: &Randoms<R>) -> Scatter<R>;

    /// The colour in the layer `albedo`: about the share of light that is scattered, in [0, 1].
    fn albedo(&self) -> R::Vec3;

    /// f·|cos θ| for the unit vector `direction`, and the density with which [`Bsdf::sample`] draws
    /// it. Neither includes specular directions.
    fn evaluate(&self, direction: R::Vec3) -> (R::Vec3, R);
}

/// A sampled direction in which a path continues.
pub(crate) struct Scatter<R: Real> {
    /// Unit direction.
    pub(crate) direction: R::Vec3,
    /// Whether the path crosses to the other side of the surface.
    pub(crate) transmitted: R::Mask,
    /// f·|cos θ|/pdf.
    pub(crate) weight: R::Vec3,
    /// Density of the direction per unit solid angle, or [`SPECULAR`].
    pub(crate) pdf: R,
    /// Whether the path continues. Otherwise the surface absorbs it.
    pub(crate) scattered: R::Mask,
}

/// The density of a specular direction, which only [`Bsdf::sample`] can find: no other strategy
/// samples it.
pub(crate) const SPECULAR: f32 = f32::INFINITY;
