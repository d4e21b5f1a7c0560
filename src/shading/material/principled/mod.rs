//! The principled material, with the parameters that glTF and other formats share.

mod albedo;
mod layered;

use glam::Vec3;
use serde::{Deserialize, Serialize};

pub(super) use self::albedo::Shares;
pub(super) use self::layered::{LayeredBsdf, Parameters, reflectance_at_normal};
use super::{Emission, MaterialModel, MaterialParameters, Opacity, Sides};
use crate::checks::{Location, MAX_RADIANCE};
use crate::error::Result;
use crate::math::{Real, Row, row};
use crate::shading::{Color, Interaction, Number, TextureRef, TextureTables};

/// A surface between matte, metal and glass, with an optional clear coat.
///
/// Under the coat, GGX microfacets reflect light by Schlick's approximation. What they do not
/// reflect reaches a diffuse base or passes through the surface, unless it is metal. The parameters
/// are those of glTF 2.0 and its extensions `KHR_materials_specular`, `_ior`, `_transmission`,
/// `_volume` and `_clearcoat`; `docs/materials.md` states the formulas.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct Principled {
    /// Colour of the diffuse base, of the light that passes through, and of metal: each channel in
    /// [0, 1], or a texture.
    pub base_color: Color,
    /// Share of metal, 0 to 1, or a texture.
    pub metalness: Number,
    /// Roughness, 0 to 1, or a texture. The GGX roughness α is its square, at least 0.001.
    pub roughness: Number,
    /// Factor of the reflectance of the part that is not metal, 0 to 1, or a texture.
    pub specular: Number,
    /// Index of refraction relative to air, 1.01 to 10.
    pub ior: f32,
    /// Share of the light that enters the surface and passes through it, 0 to 1, or a texture.
    pub transmission: Number,
    /// Whether light passes through without refraction, as through a thin sheet.
    pub thin: bool,
    /// Colour that light keeps after `attenuation_distance` inside the surface, each channel above 0
    /// and at most 1.
    pub attenuation_color: [f32; 3],
    /// Distance for `attenuation_color`, above 0; infinite for clear glass.
    #[serde(skip_serializing_if = "is_infinite")]
    pub attenuation_distance: f32,
    /// Strength of the clear coat, 0 to 1, or a texture.
    pub coat: Number,
    /// Roughness of the clear coat, 0 to 1, or a texture.
    pub coat_roughness: Number,
    /// Colour of the light that passes the clear coat, each channel in [0, 1].
    pub coat_color: [f32; 3],
    /// Emitted radiance in linear RGB, 0 to 1e30, or a texture. Light samples do not find the light
    /// of a texture, only paths that hit the surface.
    pub emission: Color,
    /// Name of a normal map: an image texture with linear encoding.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<TextureRef>,
    /// Holes in the surface, which must then be of triangles and emit no light but that of a texture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opacity: Option<Opacity>,
}

/// JSON has no infinite numbers, so the default is left out.
fn is_infinite(distance: &f32) -> bool {
    *distance == f32::INFINITY
}

impl Default for Principled {
    /// Matte plastic with a grey base.
    fn default() -> Self {
        Self {
            base_color: [0.8; 3].into(),
            metalness: 0.0.into(),
            roughness: 0.5.into(),
            specular: 1.0.into(),
            ior: 1.5,
            transmission: 0.0.into(),
            thin: false,
            attenuation_color: [1.0; 3],
            attenuation_distance: f32::INFINITY,
            coat: 0.0.into(),
            coat_roughness: 0.0.into(),
            coat_color: [1.0; 3],
            emission: [0.0; 3].into(),
            normal: None,
            opacity: None,
        }
    }
}

impl MaterialParameters for Principled {
    texture_methods!(
        base_color,
        emission,
        metalness,
        roughness,
        specular,
        transmission,
        coat,
        coat_roughness
    );

    fn emission(&self) -> Option<Emission> {
        let radiance = Vec3::from(self.emission.constant()?);
        (radiance != Vec3::ZERO).then_some(Emission { radiance, sides: Sides::Both })
    }

    fn emission_texture(&self) -> Option<&Color> {
        Some(&self.emission).filter(|emission| emission.constant().is_none())
    }

    fn transmits(&self) -> bool {
        true
    }

    fn check(&self, e: &Location<'_>) -> Result<()> {
        self.base_color.check(e, "base_color")?;
        let numbers = [
            ("metalness", &self.metalness),
            ("roughness", &self.roughness),
            ("specular", &self.specular),
            ("transmission", &self.transmission),
            ("coat", &self.coat),
            ("coat_roughness", &self.coat_roughness),
        ];
        for (name, number) in numbers {
            number.check(e, name, 0.0..=1.0)?;
        }
        e.check((1.01..=10.0).contains(&self.ior), "ior", "in [1.01, 10]", self.ior)?;
        let color = self.attenuation_color;
        let ok = color.iter().all(|&c| c > 0.0 && c <= 1.0);
        e.check(ok, "attenuation_color", "in (0, 1] per channel", color)?;
        let distance = self.attenuation_distance;
        e.check(distance > 0.0, "attenuation_distance", "above 0", distance)?;
        e.color("coat_color", self.coat_color, 1.0)?;
        self.emission.check_within(e, "emission", MAX_RADIANCE)?;
        let radiance = self.emission.constant().unwrap_or_default();
        let allowed = self.opacity.is_none() || radiance == [0.0; 3];
        e.check(allowed, "emission", "0, or varied by a texture, where there is opacity", radiance)
    }
}

impl MaterialModel for Principled {
    /// The base colour; the words of metalness and roughness, of specular and transmission, of coat
    /// and coat roughness; (coat colour, index of refraction); (absorption per unit of length, 1 if
    /// thin).
    type Entry = [Row; 6];
    type Bsdf<R: Real> = LayeredBsdf<R>;

    const GLOSSY: bool = true;
    const TEXTURED: bool = true;
    const LARGE: bool = true;

    fn entry(&self, textures: &mut TextureTables) -> [Row; 6] {
        Shares::<f32>::prepare();
        let mut two = |first: &Number, second: &Number| {
            let ([a, b], [c, d]) = (textures.number(first), textures.number(second));
            [a, b, c, d]
        };
        let (base, specular) =
            (two(&self.metalness, &self.roughness), two(&self.specular, &self.transmission));
        let coat = two(&self.coat, &self.coat_roughness);
        let absorption = self.attenuation_color.map(|c| -ln(c) / self.attenuation_distance);
        [
            textures.row(&self.base_color),
            base,
            specular,
            coat,
            row(self.coat_color.into(), self.ior),
            row(absorption.into(), f32::from(u8::from(self.thin))),
        ]
    }

    #[inline(always)]
    fn bsdf<R: Real>(
        table: &[[Row; 6]],
        index: R::Index,
        at: &Interaction<'_, R>,
    ) -> LayeredBsdf<R> {
        let base_color = at.color(R::gather(table, index, |entry| &entry[0]));
        let numbers = |i: usize| {
            let (words, last) = R::gather(table, index, |entry: &[Row; 6]| &entry[i]);
            at.two_numbers([[words[0], words[1]], [words[2], last]])
        };
        let [metalness, roughness] = numbers(1);
        let [specular, transmission] = numbers(2);
        let [coat, coat_roughness] = numbers(3);
        let (coat_color, ior) = R::gather(table, index, |entry| &entry[4]);
        let (absorption, thin) = R::gather(table, index, |entry| &entry[5]);
        let parameters = Parameters {
            base_color,
            metalness,
            roughness,
            specular,
            transmission,
            thin: thin.gt(R::ZERO),
            ior,
            coat,
            coat_roughness,
            coat_color,
            absorption,
        };
        LayeredBsdf::new(&parameters, at)
    }
}

/// Natural logarithm of `x` in (0, 1], but at least that of 2^-24.
fn ln(x: f32) -> f32 {
    crate::math::powers::ln(crate::math::max(x, 1.0 / 16_777_216.0))
}
