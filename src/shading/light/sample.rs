//! Light samples, and the sampling of flat lights.

use crate::math::{Mask, Real, Select, Vector, dot};

/// A sampled direction from a point to a light.
#[derive(Clone, Copy)]
pub(crate) struct LightSample<R: Real> {
    /// Unit direction to the light.
    pub(crate) direction: R::Vec3,
    /// Distance to the light.
    pub(crate) distance: R,
    /// Density of the direction per unit solid angle.
    pub(crate) pdf: R,
    /// Factor of the light's radiance in this direction.
    pub(crate) tint: R::Vec3,
    /// Whether the direction hits the light's front side.
    pub(crate) front: R::Mask,
    /// Whether the light can be visible at all. If not, the other fields are meaningless.
    pub(crate) visible: R::Mask,
}

impl<R: Real> Select<R::Mask> for LightSample<R> {
    #[inline(always)]
    fn select(mask: R::Mask, yes: Self, no: Self) -> Self {
        Self {
            direction: mask.select(yes.direction, no.direction),
            distance: mask.select(yes.distance, no.distance),
            pdf: mask.select(yes.pdf, no.pdf),
            tint: mask.select(yes.tint, no.tint),
            front: mask.select(yes.front, no.front),
            visible: mask.select(yes.visible, no.visible),
        }
    }
}

/// Plane and area of a flat light.
pub(super) struct Plane<R: Real> {
    pub(super) point: R::Vec3,
    pub(super) normal: R::Vec3,
    pub(super) area: R,
}

impl<R: Real> Plane<R> {
    /// Returns the sample in this direction. Its density is `pdf` in the lanes of `exact`. In the
    /// other lanes, it is the density of a point chosen uniformly by area.
    #[inline(always)]
    pub(super) fn sample(
        &self,
        from: R::Vec3,
        direction: R::Vec3,
        exact: R::Mask,
        pdf: R,
    ) -> LightSample<R> {
        let slope = dot(self.normal, direction);
        let distance = -dot(self.normal, from - self.point) / slope;
        let pdf = exact.select(pdf, self.area_pdf(direction, distance));
        let positive = |x: R| x.gt(R::ZERO) & x.lt(R::INFINITY);
        LightSample {
            direction,
            distance,
            pdf,
            tint: R::Vec3::gray(R::ONE),
            front: slope.lt(R::ZERO),
            visible: positive(distance) & positive(pdf),
        }
    }

    /// Returns the density per unit solid angle of a point chosen uniformly by area that lies at
    /// `distance` in this direction.
    #[inline(always)]
    pub(super) fn area_pdf(&self, direction: R::Vec3, distance: R) -> R {
        distance * distance / (self.area * dot(self.normal, direction).abs())
    }
}
