//! Scattering by a clear coat, GGX microfacets, and a diffuse base.

use std::f32::consts::PI;

use super::albedo::{Shares, schlick_weight};
use crate::math::microfacet::Ggx;
use crate::math::warp::cosine_hemisphere;
use crate::math::{Frame, Mask, Real, Vector, dot, max, min, normalize};
use crate::sampler::{Dimension, Randoms};
use crate::shading::{Bsdf, Interaction, Scatter};

/// Smallest GGX roughness.
const LEAST_ALPHA: f32 = 0.001;
/// Reflectance of the coat at normal incidence: that of an index of refraction of 1.5.
const COAT_F0: f32 = 0.04;

/// The parameters of the material at a point.
pub(in crate::shading::material) struct Parameters<R: Real> {
    pub(in crate::shading::material) base_color: R::Vec3,
    pub(in crate::shading::material) metalness: R,
    pub(in crate::shading::material) roughness: R,
    pub(in crate::shading::material) specular: R,
    pub(in crate::shading::material) transmission: R,
    pub(in crate::shading::material) thin: R::Mask,
    /// Whether the light that passes is left to [`MaterialModel::passes`](super::MaterialModel::passes).
    pub(in crate::shading::material) pane: R::Mask,
    pub(in crate::shading::material) ior: R,
    pub(in crate::shading::material) coat: R,
    pub(in crate::shading::material) coat_roughness: R,
    pub(in crate::shading::material) coat_color: R::Vec3,
}

/// The scattering of the material. Directions are in the frame of the microfacets.
pub(crate) struct LayeredBsdf<R: Real> {
    frame: Frame<R::Vec3>,
    /// Normal of the diffuse base.
    base: R::Vec3,
    /// Direction back along the path.
    wo: R::Vec3,
    /// Microfacets of the base.
    ggx: Ggx<R>,
    /// Reflectance of the microfacets at normal incidence, and at grazing angles.
    f0: R::Vec3,
    f90: R,
    /// The same two numbers of the part that is not metal.
    dielectric_f0: R,
    specular: R,
    /// Factor of the reflected light for light that microfacets reflect more than once (Turquin
    /// 2019, "Practical Multiple Scattering Compensation for Microfacet Models").
    compensation: R::Vec3,
    /// The BRDF of the base, before the factor for light that the microfacets let in.
    diffuse: R::Vec3,
    /// Colour of light that passes through the surface.
    transmission: R::Vec3,
    thin: R::Mask,
    /// Index of refraction beyond the surface divided by the index before it.
    eta: R,
    coat: R,
    coat_ggx: Ggx<R>,
    /// Factor of all light that leaves the layers below the coat in the direction `wo`.
    below: R::Vec3,
    /// Probabilities of sampling the coat and the microfacets. The base has the rest.
    chances: [R; 2],
}

impl<R: Real> LayeredBsdf<R> {
    /// The GGX roughness.
    #[inline(always)]
    pub(in crate::shading::material) fn alpha(roughness: R) -> R {
        max(roughness * roughness, R::splat(LEAST_ALPHA))
    }

    /// It is not inlined, because all loops over paths share its code.
    #[inline(never)]
    pub(in crate::shading::material) fn new(p: &Parameters<R>, at: &Interaction<'_, R>) -> Self {
        let frame = Frame::new(at.normals.mirror);
        let wo = frame.local(-at.ray.direction);
        let mut base = R::Vec3::new(R::ZERO, R::ZERO, R::ONE);
        if at.smooth.any() {
            base = at.smooth.select(frame.local(at.normals.shading), base);
        }
        let (ggx, coat_ggx) =
            (Ggx { alpha: Self::alpha(p.roughness) }, Ggx { alpha: Self::alpha(p.coat_roughness) });
        let not_metal = R::ONE - p.metalness;
        let dielectric_f0 = reflectance_at_normal(p.ior) * p.specular;
        let f0 = R::Vec3::gray(dielectric_f0 * not_metal) + p.base_color * p.metalness;
        let f90 = p.specular * not_metal + p.metalness;

        let refracts = (not_metal * p.transmission).gt(R::ZERO) & !p.thin;
        let inside = !at.front & refracts;
        let eta = inside.select(R::ONE / p.ior, p.ior);
        let (outside_cos, enclosed) = outside(wo[2], eta);
        let (shares, mean) = (Shares::at(outside_cos, ggx.alpha), Shares::mean(ggx.alpha));
        // What microfacets lose depends on the cosine inside.
        let lost = if inside.any() { Shares::at(wo[2], ggx.alpha) } else { shares };
        let all = lost.low + lost.high;
        let compensation =
            R::Vec3::gray(R::ONE) + p.base_color * (p.metalness * ((R::ONE - all) / all));
        let enters = R::ONE - (dielectric_f0 * shares.low + p.specular * shares.high);
        let enters = enclosed.select(R::ZERO, enters);
        let enters_mean = R::ONE - (dielectric_f0 * mean.low + p.specular * mean.high);
        let opaque = not_metal * (R::ONE - p.transmission);
        let diffuse = p.base_color * (opaque * enters / enters_mean * (1.0 / PI));
        let transmission = p.base_color * (not_metal * p.transmission);
        let transmission = p.pane.select(R::Vec3::zero(), transmission);

        let coat_share = coat_reflects(p.coat, coat_ggx, wo[2]);
        let below = p.coat_color * p.coat + R::Vec3::gray(R::ONE - p.coat);
        let below = below * (R::ONE - coat_share);
        // Lobes are chosen by their share of the reflected light.
        let reflected = (f0 * shares.low + R::Vec3::gray(f90 * shares.high)) * compensation;
        let reflected = enclosed.select(R::Vec3::gray(R::ONE), reflected);
        let weight = |color: R::Vec3| mean_of(color * below);
        let weights = [
            coat_share,
            weight(reflected + transmission * enters),
            weight(p.base_color * (opaque * enters)),
        ];
        // Black surfaces have no chance of 0/0.
        let sum = max(weights[0] + weights[1] + weights[2], R::splat(1e-6));
        let chances = [weights[0] / sum, weights[1] / sum];

        Self {
            frame,
            base,
            wo,
            ggx,
            f0,
            f90,
            dielectric_f0,
            specular: p.specular,
            compensation,
            diffuse,
            transmission,
            thin: p.thin,
            eta,
            coat: p.coat,
            coat_ggx,
            below,
            chances,
        }
    }

    /// Reflectance of microfacets that are hit at the cosine `cos`, and the share of the light that
    /// passes through them. From inside, Schlick's formula applies to the cosine outside.
    #[inline(always)]
    fn split(&self, cos: R) -> (R::Vec3, R::Vec3) {
        let (cos, enclosed) = outside(cos, self.eta);
        let grazing = schlick_weight(cos);
        let reflects = self.f0 + (R::Vec3::gray(self.f90) - self.f0) * grazing;
        let dielectric = self.dielectric_f0 + (self.specular - self.dielectric_f0) * grazing;
        let passes = enclosed.select(R::ZERO, R::ONE - dielectric);
        (enclosed.select(R::Vec3::gray(R::ONE), reflects), self.transmission * passes)
    }

    /// The share of light that passes a smooth, thin sheet.
    pub(in crate::shading::material) fn passes(&self) -> R::Vec3 {
        let (_, passes) = self.split(min(self.wo[2], R::ONE));
        passes * self.below
    }

    /// Probability that a sample of a microfacet with this [`split`](Self::split) is a reflection.
    #[inline(always)]
    fn reflection_chance(&self, (reflects, passes): (R::Vec3, R::Vec3)) -> R {
        let (reflects, passes) = (mean_of(reflects), mean_of(passes));
        // Without transmission, the quotient is exactly 1.
        reflects / max(reflects + passes, R::splat(1e-12))
    }

    /// f·|cos θ| without the Fresnel factor, and the density, of reflection by GGX microfacets.
    #[inline(always)]
    fn reflect(&self, ggx: Ggx<R>, wi: R::Vec3, m: R::Vec3) -> (R, R) {
        let (lo, li) = (ggx.length(self.wo), ggx.length(wi));
        let pdf = ggx.density(m) / ((self.wo[2] + lo) * 2.0);
        let shadowing = wi[2] * (self.wo[2] + lo) / (self.wo[2] * li + wi[2] * lo);
        (shadowing * pdf, pdf)
    }

    /// f·|cos θ| without the Fresnel factor, and the density, of refraction into `wi` below the
    /// surface, and the cosine at the microfacet (Walter et al. 2007).
    #[inline(always)]
    fn refract(&self, wi: R::Vec3) -> (R, R, R) {
        let half = normalize(self.wo + wi * self.eta);
        let m = half[2].lt(R::ZERO).select(-half, half);
        let (before, after) = (dot(self.wo, m), dot(wi, m));
        let (lo, li) = (self.ggx.length(self.wo), self.ggx.length(wi));
        let visible = self.ggx.density(m) * 2.0 * before / (self.wo[2] + lo);
        let sum = before + self.eta * after;
        let pdf = visible * (self.eta * self.eta * after.abs() / (sum * sum));
        let possible = before.gt(R::ZERO) & after.lt(R::ZERO) & pdf.gt(R::ZERO);
        let pdf = possible.select(pdf, R::ZERO);
        (pdf * (wi[2] * 2.0 / (wi[2] - li)), pdf, before)
    }

    /// f·|cos θi| and the density of `wi`. As [`Self::new`], it is not inlined.
    #[inline(never)]
    fn value(&self, wi: R::Vec3) -> (R::Vec3, R) {
        let [coat_chance, chance] = self.chances;
        let above = wi[2].gt(R::ZERO);
        // A thin sheet transmits like a mirror image of its reflection.
        let upper = R::Vec3::new(wi[0], wi[1], wi[2].abs());
        let m = normalize(self.wo + upper);
        let (f_cos, pdf) = self.reflect(self.ggx, upper, m);
        let cos = min(dot(self.wo, m), R::ONE);
        let (reflects, mut passes) = self.split(cos);
        let reflection_chance = self.reflection_chance((reflects, passes));
        let mut light = reflects * self.compensation * f_cos;
        let mut density = chance * reflection_chance * pdf;

        let enters = {
            let (cos, enclosed) = outside(upper[2], self.eta);
            let Shares { low, high } = Shares::at(cos, self.ggx.alpha);
            let enters = R::ONE - (self.dielectric_f0 * low + self.specular * high);
            enclosed.select(R::ZERO, enters)
        };
        let base_cos = max(dot(self.base, wi), R::ZERO);
        light = light + self.diffuse * (enters * base_cos);
        let base_chance = max(R::ONE - (coat_chance + chance), R::ZERO);
        density = density + base_chance * base_cos * (1.0 / PI);

        // The layers below the coat, and the coat itself.
        let coated = self.coat.gt(R::ZERO);
        let mut leaving = R::ONE;
        if coated.any() {
            leaving = R::ONE - coat_reflects(self.coat, self.coat_ggx, upper[2]);
        }
        light = light * self.below * leaving;
        if coated.any() {
            let (f_cos, pdf) = self.reflect(self.coat_ggx, upper, m);
            let high = schlick_weight(cos);
            let reflectance = (R::splat(COAT_F0) + high * (1.0 - COAT_F0)) * self.coat;
            light = light + R::Vec3::gray(reflectance * f_cos);
            density = density + coat_chance * pdf;
        }
        light = above.select(light, R::Vec3::zero());
        density = above.select(density, R::ZERO);

        let below = !above & mean_of(self.transmission).gt(R::ZERO);
        if below.any() {
            let (mut f_cos, mut pdf, mut passing_chance) = (f_cos, pdf, R::ONE - reflection_chance);
            if (below & !self.thin).any() {
                let (bent_f_cos, bent_pdf, cos) = self.refract(wi);
                let split = self.split(min(cos, R::ONE));
                let chance = R::ONE - self.reflection_chance(split);
                f_cos = self.thin.select(f_cos, bent_f_cos);
                pdf = self.thin.select(pdf, bent_pdf);
                passing_chance = self.thin.select(passing_chance, chance);
                passes = self.thin.select(passes, split.1);
            }
            light = below.select(passes * self.below * f_cos, light);
            density = below.select(chance * passing_chance * pdf, density);
        }
        (light, density)
    }
}

/// The cosine outside of a denser body for light that arrives at the cosine `cos` from inside, where
/// `eta` is below 1, and whether it is totally reflected. Other light keeps its cosine.
#[inline(always)]
fn outside<R: Real>(cos: R, eta: R) -> (R, R::Mask) {
    let inside = eta.lt(R::ONE);
    if !inside.any() {
        return (cos, R::Mask::NONE);
    }
    let sin2 = (R::ONE - cos * cos) / (eta * eta);
    let bent = max(R::ZERO, R::ONE - sin2).sqrt();
    (inside.select(bent, cos), inside & sin2.ge(R::ONE))
}

/// Reflectance of a dielectric at normal incidence.
#[inline(always)]
pub(in crate::shading::material) fn reflectance_at_normal<R: Real>(ior: R) -> R {
    let slope = (ior - R::ONE) / (ior + R::ONE);
    slope * slope
}

/// Share of the light that a coat of this strength reflects at the cosine `cos`.
#[inline(always)]
fn coat_reflects<R: Real>(coat: R, ggx: Ggx<R>, cos: R) -> R {
    if !coat.gt(R::ZERO).any() {
        return R::ZERO;
    }
    let Shares { low, high } = Shares::at(cos, ggx.alpha);
    coat * (low * COAT_F0 + high)
}

#[inline(always)]
fn mean_of<V: Vector>(color: V) -> V::Real {
    (color[0] + color[1] + color[2]) * (1.0 / 3.0)
}

impl<R: Real> Bsdf<R> for LayeredBsdf<R> {
    const TRANSMITS: bool = true;

    #[inline(always)]
    fn albedo(&self) -> R::Vec3 {
        self.diffuse * R::splat(PI) + self.transmission + self.f0
    }

    #[inline(always)]
    fn sample(&self, randoms: &Randoms<R>) -> Scatter<R> {
        let [coat, facets] = self.chances;
        let lobe = randoms.one(Dimension::LOBE);
        let in_coat = lobe.lt(coat);
        let in_facets = lobe.lt(coat + facets);
        let (u, v) = randoms.two(Dimension::SCATTER);
        let ggx = Ggx { alpha: in_coat.select(self.coat_ggx.alpha, self.ggx.alpha) };
        let m = ggx.sample(self.wo, R::ONE, u, v);
        let cos = min(dot(self.wo, m), R::ONE);
        let mut wi = m * (cos * 2.0) - self.wo;
        // The same number, which is uniform in the microfacets' range, chooses what they do.
        let reflects = (lobe - coat).lt(facets * self.reflection_chance(self.split(cos)));
        let passes = in_facets & !in_coat & !reflects;
        if passes.any() {
            let sin2 = (R::ONE - cos * cos) / (self.eta * self.eta);
            let along = cos / self.eta - max(R::ZERO, R::ONE - sin2).sqrt();
            let refracted = m * along - self.wo / self.eta;
            let mirrored = R::Vec3::new(wi[0], wi[1], -wi[2]);
            wi = passes.select(self.thin.select(mirrored, refracted), wi);
        }
        let (base, _) = cosine_hemisphere(self.base, u, v);
        let wi = normalize(in_facets.select(wi, base));
        let (light, pdf) = self.value(wi);
        let transmitted = wi[2].lt(R::ZERO);
        Scatter {
            direction: self.frame.world(wi),
            transmitted,
            weight: light / pdf,
            pdf,
            // A microfacet may send light to the wrong side of the surface.
            scattered: pdf.gt(R::ZERO) & !(transmitted ^ passes),
        }
    }

    #[inline(always)]
    fn evaluate(&self, direction: R::Vec3) -> (R::Vec3, R) {
        self.value(self.frame.local(direction))
    }
}
