//! A diffuse base below a clear coat that refracts.

use serde::{Deserialize, Serialize};

use super::principled::{LayeredBsdf, Parameters, Shares, alpha, reflectance_at_normal};
use super::{MaterialModel, MaterialParameters, Opacity};
use crate::checks::Location;
use crate::error::Result;
use crate::math::{Real, Row, Vector, max};
use crate::shading::{Color, Interaction, Number, TextureRef, TextureTables};

/// A matte surface below a clear, colourless coat, such as varnished wood or glazed pottery (pbrt-v4's
/// `coateddiffuse`).
///
/// The coat refracts light on its way in and out, and reflects part of it back to the base, which
/// makes colours more saturated. pbrt follows this light at random; here it is summed up as if the
/// base scattered it to the coat uniformly: f = T(θo) T(θi) ρ/(1 − ρ r) (1 − r)/(π T̅), where T is the
/// share of light that passes the coat, T̅ its mean, and r the share that the coat reflects back
/// (Kubelka-Munk's sum; Walter et al. 2007 for rough coats).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct CoatedDiffuse {
    /// Reflectance ρ of the base, a colour with each channel in [0, 1] or a texture.
    pub reflectance: Color,
    /// Roughness of the coat, 0 to 1, or a texture. The GGX roughness α is its square, at least
    /// 0.001.
    #[serde(default = "Number::zero")]
    pub roughness: Number,
    /// Index of refraction of the coat relative to air, 1.01 to 10.
    #[serde(default = "usual_ior")]
    pub ior: f32,
    /// Name of a normal map: an image texture with linear encoding.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<TextureRef>,
    /// Holes in the surface, which must then be of triangles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opacity: Option<Opacity>,
}

fn usual_ior() -> f32 {
    1.5
}

impl CoatedDiffuse {
    /// Creates the material with a coat of index 1.5.
    pub fn new(reflectance: impl Into<Color>, roughness: impl Into<Number>) -> Self {
        let (reflectance, roughness) = (reflectance.into(), roughness.into());
        Self { reflectance, roughness, ior: usual_ior(), normal: None, opacity: None }
    }
}

impl MaterialParameters for CoatedDiffuse {
    texture_methods!(reflectance, roughness);

    fn check(&self, e: &Location<'_>) -> Result<()> {
        self.reflectance.check(e, "reflectance")?;
        self.roughness.check(e, "roughness", 0.0..=1.0)?;
        e.check((1.01..=10.0).contains(&self.ior), "ior", "in [1.01, 10]", self.ior)
    }
}

impl MaterialModel for CoatedDiffuse {
    /// Row of ρ, and (the words of the roughness, index of refraction, 0).
    type Entry = [Row; 2];
    type Bsdf<R: Real> = LayeredBsdf<R>;

    const GLOSSY: bool = true;
    const TEXTURED: bool = true;
    const LARGE: bool = true;

    fn entry(&self, textures: &mut TextureTables) -> [Row; 2] {
        Shares::<f32>::prepare();
        let [roughness, code] = textures.number(&self.roughness);
        [textures.row(&self.reflectance), [roughness, code, self.ior.to_bits(), 0]]
    }

    #[inline(always)]
    fn bsdf<R: Real>(
        table: &[[Row; 2]],
        index: R::Index,
        at: &Interaction<'_, R>,
    ) -> LayeredBsdf<R> {
        let reflectance = at.color(R::gather(table, index, |entry| &entry[0]));
        let (row, _) = R::gather(table, index, |entry| &entry[1]);
        let (roughness, ior) = (at.number([row[0], row[1]]), row[2]);
        let mean = Shares::mean(alpha(roughness));
        let reflected = reflectance_at_normal(ior) * mean.low + mean.high;
        let back = R::ONE - (R::ONE - reflected) / (ior * ior);
        let summed =
            |rho: R| rho * (R::ONE - back) / max(R::ONE - rho * back, R::splat(f32::MIN_POSITIVE));
        let base_color =
            R::Vec3::new(summed(reflectance[0]), summed(reflectance[1]), summed(reflectance[2]));
        LayeredBsdf::new(&Parameters::plastic(base_color, roughness, ior), at)
    }
}
