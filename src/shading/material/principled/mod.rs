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
use crate::math::{Real, Row, Word, row};
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
    /// Emitted radiance in linear RGB, 0 to 1e30, or a texture.
    pub emission: Color,
    /// The sides that emit light.
    #[serde(skip_serializing_if = "is_both")]
    pub emission_sides: Sides,
    /// Name of a normal map: an image texture with linear encoding.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<TextureRef>,
    /// Holes in the surface, which must then be of triangles.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opacity: Option<Opacity>,
}

/// JSON has no infinite numbers, so the default is left out.
fn is_infinite(distance: &f32) -> bool {
    *distance == f32::INFINITY
}

fn is_both(sides: &Sides) -> bool {
    *sides == Sides::Both
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
            emission_sides: Sides::Both,
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
        let (radiance, sides) = (Vec3::from(self.emission.constant()?), self.emission_sides);
        let varies = self.opacity.is_some();
        (radiance != Vec3::ZERO && !varies).then_some(Emission { radiance, sides })
    }

    fn varied_emission(&self) -> Option<(&Color, Sides)> {
        let varies = match self.emission.constant() {
            None => true,
            Some(radiance) => radiance != [0.0; 3] && self.opacity.is_some(),
        };
        varies.then_some((&self.emission, self.emission_sides))
    }

    fn transmits(&self) -> bool {
        true
    }

    fn absorption(&self) -> Option<Vec3> {
        let refracts = !self.thin && self.transmission != 0.0.into();
        let absorption = self.attenuation_color.map(|c| -ln(c) / self.attenuation_distance);
        refracts.then(|| absorption.into())
    }

    fn is_pane(&self) -> bool {
        let emits = self.emission.constant() != Some([0.0; 3]);
        self.thin && self.roughness == 0.0.into() && self.transmission != 0.0.into() && !emits
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
        self.emission.check_within(e, "emission", MAX_RADIANCE)
    }
}

impl MaterialModel for Principled {
    /// The base colour; the words of metalness and roughness, of specular and transmission, of coat
    /// and coat roughness; (coat colour, index of refraction); (1 if thin,
    /// 1 if it is a pane, 0, 0).
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
        [
            textures.row(&self.base_color),
            base,
            specular,
            coat,
            row(self.coat_color.into(), self.ior),
            [self.thin.into(), self.is_pane().into(), 0, 0],
        ]
    }

    fn passes(table: &[[Row; 6]], index: u32, at: &Interaction<'_, f32>) -> Vec3 {
        LayeredBsdf::new(&Parameters { pane: false, ..parameters(table, index, at) }, at).passes()
    }

    #[inline(always)]
    fn bsdf<R: Real>(
        table: &[[Row; 6]],
        index: R::Index,
        at: &Interaction<'_, R>,
    ) -> LayeredBsdf<R> {
        LayeredBsdf::new(&parameters(table, index, at), at)
    }
}

/// The parameters of the entries at `index` for the point `at`.
#[inline(always)]
fn parameters<R: Real>(
    table: &[[Row; 6]],
    index: R::Index,
    at: &Interaction<'_, R>,
) -> Parameters<R> {
    let base_color = at.color(R::gather(table, index, |entry| &entry[0]));
    let numbers = |i: usize| {
        let (words, last) = R::gather(table, index, |entry: &[Row; 6]| &entry[i]);
        at.two_numbers([[words[0], words[1]], [words[2], last]])
    };
    let [metalness, roughness] = numbers(1);
    let [specular, transmission] = numbers(2);
    let [coat, coat_roughness] = numbers(3);
    let (coat_color, ior) = R::gather(table, index, |entry| &entry[4]);
    let (flags, _) = R::gather(table, index, |entry| &entry[5]);
    let is_set = |flag: R| !flag.to_bits().eq(R::Word::splat(0));
    Parameters {
        base_color,
        metalness,
        roughness,
        specular,
        transmission,
        thin: is_set(flags[0]),
        pane: is_set(flags[1]),
        ior,
        coat,
        coat_roughness,
        coat_color,
    }
}

/// Natural logarithm of `x` in (0, 1], but at least that of 2^-24.
fn ln(x: f32) -> f32 {
    crate::math::powers::ln(crate::math::max(x, 1.0 / 16_777_216.0))
}
