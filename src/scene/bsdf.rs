//! What all scattering has in common.

use crate::math::{Mask, Real};
use crate::sampler::Randoms;

/// The light that surfaces or media scatter from all directions to those from which paths come.
pub(crate) trait Bsdf<R: Real> {
    /// Whether surfaces scatter light to their other side.
    const TRANSMITS: bool = false;

    /// Whether [`Scatter::pdf`] is [`SPECULAR`] for all directions.
    #[inline(always)]
    fn specular(&self) -> R::Mask {
        R::Mask::NONE
    }

    /// A direction about as likely as it carries light.
    fn sample(&self, randoms: &Randoms<R>) -> Scatter<R>;

    /// f·|cos θ| for the unit vector `direction`, and the density with which [`Bsdf::sample`] draws it.
    /// Both leave out specular directions.
    fn evaluate(&self, direction: R::Vec3) -> (R::Vec3, R);
}

/// A direction that a path takes.
pub(crate) struct Scatter<R: Real> {
    /// Of unit length.
    pub(crate) direction: R::Vec3,
    /// Whether the path leaves on the side of the surface that it did not come from.
    pub(crate) transmitted: R::Mask,
    /// f·|cos θ|/pdf.
    pub(crate) weight: R::Vec3,
    /// Density of the direction per unit solid angle, or [`SPECULAR`].
    pub(crate) pdf: R,
    /// Whether the path goes on; where it does not, the surface absorbs it.
    pub(crate) scattered: R::Mask,
}

/// The density of directions that nothing but the surface itself could have chosen.
pub(crate) const SPECULAR: f32 = f32::INFINITY;
