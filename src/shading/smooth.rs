//! Smooth shading: scattering about an interpolated normal, without light through the surface.

use super::{Bsdf, Interaction, SPECULAR, Scatter, ScatterNormals};
use crate::math::{Mask, Real, dot, max, min};
use crate::sampler::Randoms;

/// The scattering of a material about a shading normal.
pub(crate) struct Smoothed<B, R: Real> {
    bsdf: B,
    /// The geometric normal on the side that was hit.
    normal: R::Vec3,
    normals: ScatterNormals<R>,
    smooth: R::Mask,
    soft: R::Mask,
}

impl<R: Real> Interaction<'_, R> {
    /// Adapts the scattering of the material at this point to the surface.
    #[inline(always)]
    pub(crate) fn smoothed<B: Bsdf<R>>(&self, bsdf: B) -> Smoothed<B, R> {
        let Self { normal, normals, smooth, soft, .. } = *self;
        Smoothed { bsdf, normal, normals, smooth, soft }
    }
}

impl<B, R: Real> Smoothed<B, R> {
    /// The factor for light that is scattered to `direction`. It is 0 if the direction is on one side
    /// of the surface by the shading normal and on the other by the geometric normal, since light
    /// would leak through the surface.
    ///
    /// Light that is reflected by a `soft` surface fades out where the geometric normal turns away
    /// from it. Otherwise, the faces of a mesh would show as steps at the terminator (Chiang, Li,
    /// Burley 2019, "Taming the Shadow Terminator").
    #[inline(always)]
    fn factor(&self, direction: R::Vec3, transmitted: R::Mask, soft: R::Mask) -> R {
        let ScatterNormals { shading, mirror } = self.normals;
        let cos = dot(direction, self.normal);
        let above = cos.gt(R::ZERO);
        // Rounding can turn the sign of a grazing direction, so the material's word is not enough.
        let consistent = transmitted.select(!above, above & dot(direction, mirror).gt(R::ZERO));
        // Mirrors also reflect to directions that the shading normal turns away from.
        let shaded = max(dot(direction, shading), R::splat(f32::MIN_POSITIVE));
        let g = min(cos / (shaded * dot(self.normal, shading)), R::ONE);
        let fade = ((R::ONE - g) * g + 1.0) * g;
        let factor = (soft & !transmitted).select(fade, R::ONE);
        consistent.select(factor, R::ZERO)
    }
}

impl<B: Bsdf<R>, R: Real> Bsdf<R> for Smoothed<B, R> {
    const TRANSMITS: bool = B::TRANSMITS;

    #[inline(always)]
    fn specular(&self) -> R::Mask {
        self.bsdf.specular()
    }

    #[inline(always)]
    fn albedo(&self) -> R::Vec3 {
        self.bsdf.albedo()
    }

    #[inline(always)]
    fn sample(&self, randoms: &Randoms<R>) -> Scatter<R> {
        let scatter = self.bsdf.sample(randoms);
        if !self.smooth.any() {
            return scatter;
        }
        let Scatter { direction, transmitted, weight, pdf, scattered } = scatter;
        // Mirrors have no terminator.
        let soft = self.soft & !pdf.eq(R::splat(SPECULAR));
        let factor = self.smooth.select(self.factor(direction, transmitted, soft), R::ONE);
        let scattered = scattered & factor.gt(R::ZERO);
        Scatter { direction, transmitted, weight: weight * factor, pdf, scattered }
    }

    #[inline(always)]
    fn evaluate(&self, direction: R::Vec3) -> (R::Vec3, R) {
        let (f_cos, pdf) = self.bsdf.evaluate(direction);
        if !self.smooth.any() {
            return (f_cos, pdf);
        }
        let transmitted = dot(direction, self.normals.mirror).lt(R::ZERO);
        let factor = self.factor(direction, transmitted, self.soft);
        (f_cos * self.smooth.select(factor, R::ONE), pdf)
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::math::warp::uniform_sphere;
    use crate::math::{Stream, normalize};

    #[test]
    fn factors_are_in_range_even_for_grazing_directions() {
        let mut random = Stream::new(12);
        for i in 0..400_000 {
            let mut direction = || uniform_sphere(random.uniform(), random.uniform());
            let (normal, toward) = (direction(), direction());
            let shading = normalize(normal + toward * 0.3);
            // Nearly perpendicular to the shading normal, or to the geometric one.
            let about = [shading, normal][i % 2];
            let across = normalize(toward - about * dot(toward, about));
            let rise = [-1e-7, 0.0, 1e-7, 1e-30, 0.3][i % 5];
            let (smooth, soft) = (true, i % 3 > 0);
            let mirror = if i % 7 == 0 { normalize(shading + normal) } else { shading };
            let normals = ScatterNormals { shading, mirror };
            let smoothed: Smoothed<_, f32> = Smoothed { bsdf: (), normal, normals, smooth, soft };
            let direction = normalize(across + about * rise);
            for transmitted in [false, true] {
                let factor = smoothed.factor(direction, transmitted, soft);
                assert!((0.0..=1.0).contains(&factor), "{factor} {direction} {normal} {shading}");
            }
        }
        let flat = Vec3::Z;
        let (normal, normals) = (flat, ScatterNormals { shading: flat, mirror: flat });
        let smoothed: Smoothed<_, f32> =
            Smoothed { bsdf: (), normal, normals, smooth: true, soft: true };
        assert_eq!(smoothed.factor(Vec3::Z, false, true), 1.0);
        assert_eq!(smoothed.factor(-Vec3::Z, false, true), 0.0);
        assert_eq!(smoothed.factor(-Vec3::Z, true, true), 1.0);
    }
}
