//! Scattering by a sheen, a clear coat, GGX microfacets, and a diffuse base.

use std::f32::consts::PI;

use super::albedo::{Shares, schlick_weight};
use super::coat::Coat;
use super::parameters::{Extras, Parameters};
use super::refraction::{kept, outside};
use super::sheen::Sheen;
use super::{LEAST_ALPHA, alpha, reflectance_at_normal};
use crate::math::microfacet::Ggx;
use crate::math::warp::cosine_hemisphere;
use crate::math::{Frame, Mask, Real, Vector, dot, max, max_element, min, normalize};
use crate::sampler::{Dimension, Randoms};
use crate::shading::{Bsdf, Interaction, Scatter};

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
    /// The same two numbers of the part that is not metal. The first is that of the brightest channel.
    dielectric_f0: R,
    specular: R,
    /// Factor of the reflected light for light that microfacets of metal reflect more than once (Turquin
    /// 2019, "Practical Multiple Scattering Compensation for Microfacet Models").
    compensation: R::Vec3,
    /// The BRDF of the base, before the factor for light that the microfacets let in, and the same of light
    /// that leaves on the other side.
    diffuse: R::Vec3,
    through: R::Vec3,
    /// Colour of light that passes through the surface.
    transmission: R::Vec3,
    /// Reflectance beyond the critical angle: 1, and what rough glass reflects more than once.
    enclosed: R,
    thin: R::Mask,
    /// Index of refraction beyond the surface divided by the index before it.
    eta: R,
    coat: Coat<R>,
    sheen: Sheen<R>,
    /// Factors of all light that leaves the layers below the coat, and below the sheen, in the direction `wo`.
    below_coat: R::Vec3,
    below: R::Vec3,
    /// Probabilities of sampling the coat and the microfacets. The base and the sheen have the rest.
    chances: [R; 2],
    /// Share of the samples of the base that leave on the other side.
    through_chance: R,
}

impl<R: Real> LayeredBsdf<R> {
    /// It is not inlined, because all loops over paths share its code.
    #[inline(never)]
    pub(in crate::shading::material) fn new(p: &Parameters<R>, at: &Interaction<'_, R>) -> Self {
        let (frame, ggx) = facets(p, at);
        let wo = frame.local(-at.ray.direction);
        let mut base = R::Vec3::new(R::ZERO, R::ZERO, R::ONE);
        if at.smooth.any() {
            base = at.smooth.select(frame.local(at.normals.shading), base);
        }
        let alpha = ggx.mean_alpha();
        let not_metal = R::ONE - p.metalness;
        let colored = p.extras.specular_color * reflectance_at_normal(p.ior);
        let limited = |channel: usize| min(colored[channel], R::ONE);
        let dielectric = R::Vec3::new(limited(0), limited(1), limited(2)) * p.specular;
        let dielectric_f0 = max_element(dielectric);
        let passing = not_metal * p.transmission;
        let refracts = passing.gt(R::ZERO) & !p.thin;
        let inside = !at.front & refracts;
        let eta = inside.select(R::ONE / p.ior, p.ior);
        let (outside_cos, enclosed) = outside(wo[2], eta);
        let (shares, mean) = (Shares::at(outside_cos, alpha), Shares::mean(alpha));
        // What microfacets lose depends on the cosine inside.
        let lost = if inside.any() { Shares::at(wo[2], alpha) } else { shares };
        let all = lost.low + lost.high;
        // What rough glass would reflect or refract more than once adds to both. Mixed with metal, it would count twice.
        let rough = refracts & alpha.gt(R::splat(LEAST_ALPHA)) & p.metalness.eq(R::ZERO);
        let mut more = R::ONE;
        if rough.any() {
            more = rough.select(R::ONE / kept(wo[2], alpha, eta, p.specular), R::ONE);
        }
        let glass = R::ONE + p.transmission * (more - R::ONE);
        let f0 = dielectric * (not_metal * glass) + p.base_color * p.metalness;
        let f90 = p.specular * not_metal * glass + p.metalness;
        let compensation =
            R::Vec3::gray(R::ONE) + p.base_color * (p.metalness * ((R::ONE - all) / all));
        let enters = R::ONE - (dielectric_f0 * shares.low + p.specular * shares.high);
        let enters = enclosed.select(R::ZERO, enters);
        let enters_mean = R::ONE - (dielectric_f0 * mean.low + p.specular * mean.high);
        let opaque = not_metal * (R::ONE - p.transmission);
        let (up, down) = (opaque * (R::ONE - p.extras.through), opaque * p.extras.through);
        let diffuse = p.base_color * (up * enters / enters_mean * (1.0 / PI));
        let through = p.extras.through_color * (down * enters / enters_mean * (1.0 / PI));
        let transmission = p.base_color * (passing * more);
        let transmission = p.pane.select(R::Vec3::zero(), transmission);

        let coat = Coat::new(p, at, &frame, wo);
        let coat_share = coat.share();
        let below_coat = p.coat_color * p.coat + R::Vec3::gray(R::ONE - p.coat);
        let below_coat = below_coat * (R::ONE - coat_share);
        let Extras { sheen_color, sheen_roughness, .. } = p.extras;
        let sheen = Sheen::new(sheen_color, sheen_roughness, wo[2]);
        let below = below_coat * sheen.leaves();
        // Lobes are chosen by their share of the reflected light.
        let reflected = (f0 * shares.low + R::Vec3::gray(f90 * shares.high)) * compensation;
        let reflected = enclosed.select(R::Vec3::gray(R::ONE), reflected);
        let weight = |color: R::Vec3| mean_of(color * below);
        let through_weight = weight(p.extras.through_color * (down * enters));
        let weights = [
            coat_share,
            weight(reflected + transmission * enters),
            weight(p.base_color * (up * enters))
                + through_weight
                + mean_of(sheen.reflects * below_coat),
        ];
        // Black surfaces have no chance of 0/0.
        let sum = max(weights[0] + weights[1] + weights[2], R::splat(1e-6));
        let chances = [weights[0] / sum, weights[1] / sum];
        let through_chance = through_weight / max(weights[2], R::splat(1e-12));

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
            through,
            transmission,
            enclosed: glass,
            thin: p.thin,
            eta,
            coat,
            sheen,
            below_coat,
            below,
            chances,
            through_chance,
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
        (enclosed.select(R::Vec3::gray(self.enclosed), reflects), self.transmission * passes)
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
        let (f_cos, pdf) = self.ggx.reflect(self.wo, upper, m);
        let cos = min(dot(self.wo, m), R::ONE);
        let (reflects, mut passes) = self.split(cos);
        let reflection_chance = self.reflection_chance((reflects, passes));
        let mut light = reflects * self.compensation * f_cos;
        let mut density = chance * reflection_chance * pdf;

        let enters = {
            let (cos, enclosed) = outside(upper[2], self.eta);
            let Shares { low, high } = Shares::at(cos, self.ggx.mean_alpha());
            let enters = R::ONE - (self.dielectric_f0 * low + self.specular * high);
            enclosed.select(R::ZERO, enters)
        };
        let side_cos = dot(self.base, wi);
        let base_cos = max(side_cos, R::ZERO);
        light = light + self.diffuse * (enters * base_cos);
        let base_chance = max(R::ONE - (coat_chance + chance), R::ZERO);
        let up_chance = base_chance * (R::ONE - self.through_chance);
        density = density + up_chance * base_cos * (1.0 / PI);

        light = light * self.below;
        if self.sheen.exists() {
            light = light + self.sheen.value(self.wo, upper) * self.below_coat;
        }
        if self.coat.exists() {
            let (coat, pdf) = self.coat.value(upper, m);
            light = light + R::Vec3::gray(coat);
            density = density + coat_chance * pdf;
        }
        light = above.select(light, R::Vec3::zero());
        density = above.select(density, R::ZERO);

        let passes_any = self.transmission + self.through;
        let below = !above & mean_of(passes_any).gt(R::ZERO);
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
            let base_cos = max(-side_cos, R::ZERO);
            let passing = passes * f_cos + self.through * (enters * base_cos);
            light = below.select(passing * self.below, light);
            let down_chance = base_chance * self.through_chance;
            let passing = chance * passing_chance * pdf + down_chance * base_cos * (1.0 / PI);
            density = below.select(passing, density);
        }
        (light, density)
    }
}

/// The frame of the microfacets and their distribution.
#[inline(always)]
fn facets<R: Real>(p: &Parameters<R>, at: &Interaction<'_, R>) -> (Frame<R::Vec3>, Ggx<R>) {
    let (normal, alpha) = (at.normals.mirror, alpha(p.roughness));
    let (frame, ggx) = (Frame::new(normal), Ggx::new(alpha));
    let Extras { anisotropy, direction, .. } = p.extras;
    let stretched = anisotropy.gt(R::ZERO);
    if !stretched.any() {
        return (frame, ggx);
    }
    let along = at.on_surface(direction);
    let x = normalize(along - normal * dot(along, normal));
    let length2 = dot(x, x);
    // Where texture coordinates define no direction, microfacets are the same in all directions.
    let stretched = stretched & length2.gt(R::splat(0.5)) & length2.lt(R::splat(2.0));
    let rougher = alpha + (R::ONE - alpha) * (anisotropy * anisotropy);
    (
        Frame::with_x(x, normal).select(stretched, frame),
        Ggx::anisotropic(rougher, alpha).select(stretched, ggx),
    )
}

#[inline(always)]
fn mean_of<V: Vector>(color: V) -> V::Real {
    (color[0] + color[1] + color[2]) * (1.0 / 3.0)
}

impl<R: Real> Bsdf<R> for LayeredBsdf<R> {
    const TRANSMITS: bool = true;

    #[inline(always)]
    fn albedo(&self) -> R::Vec3 {
        (self.diffuse + self.through) * R::splat(PI) + self.transmission + self.f0
    }

    #[inline(always)]
    fn sample(&self, randoms: &Randoms<R>) -> Scatter<R> {
        let [coat, facets] = self.chances;
        let lobe = randoms.one(Dimension::LOBE);
        let in_coat = lobe.lt(coat);
        let in_facets = lobe.lt(coat + facets);
        let (u, v) = randoms.two(Dimension::SCATTER);
        let wo = in_coat.select(self.coat.wo, self.wo);
        let m = self.coat.ggx.select(in_coat, self.ggx).sample(wo, R::ONE, u, v);
        let cos = min(dot(wo, m), R::ONE);
        let mut wi = m * (cos * 2.0) - wo;
        wi = in_coat.select(self.coat.in_layer_below(wi), wi);
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
        let base_chance = R::ONE - (coat + facets);
        let down = !in_facets & (lobe - (coat + facets)).lt(base_chance * self.through_chance);
        let (base, _) = cosine_hemisphere(down.select(-self.base, self.base), u, v);
        let wi = normalize(in_facets.select(wi, base));
        let (light, pdf) = self.value(wi);
        let transmitted = wi[2].lt(R::ZERO);
        Scatter {
            direction: self.frame.world(wi),
            transmitted,
            weight: light / pdf,
            pdf,
            // A microfacet may send light to the wrong side of the surface.
            scattered: pdf.gt(R::ZERO) & !(transmitted ^ (passes | down)),
        }
    }

    #[inline(always)]
    fn evaluate(&self, direction: R::Vec3) -> (R::Vec3, R) {
        self.value(self.frame.local(direction))
    }
}
