//! The principled material, with the parameters that glTF and other formats share.

mod albedo;
mod coat;
mod layered;
mod parameters;
mod refraction;
mod sheen;

use glam::Vec3;
use serde::{Deserialize, Serialize};

pub(super) use self::albedo::Shares;
pub(super) use self::layered::LayeredBsdf;
pub(super) use self::parameters::Parameters;
use self::parameters::{Rows, parameters};
use super::{Emission, MaterialModel, MaterialParameters, Opacity, Sides, check_normals};
use crate::checks::{Location, MAX_RADIANCE};
use crate::error::Result;
use crate::math::precise::sin_cos_degrees;
use crate::math::{Real, max, row};
use crate::shading::{Color, Interaction, Number, TextureRef, TextureTables};

/// Smallest GGX roughness.
const LEAST_ALPHA: f32 = 0.001;

/// A surface between matte, metal and glass, with an optional clear coat.
///
/// Under the coat, GGX microfacets reflect light by Schlick's approximation. What they do not
/// reflect reaches a diffuse base or passes through the surface, unless it is metal. The parameters
/// are those of glTF 2.0 and its extensions `KHR_materials_specular`, `_ior`, `_transmission`,
/// `_volume`, `_clearcoat`, `_anisotropy`, `_sheen` and `_diffuse_transmission`; `docs/materials.md` states the
/// formulas.
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
    /// Index of refraction relative to air, 1.01 to 1000.
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
    /// Name of a normal map of the coat, which otherwise has the normal of the surface without a map.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coat_normal: Option<TextureRef>,
    /// Colour of the reflection at normal incidence, for the part that is not metal: 0 or more in each channel,
    /// or a texture. Products with the reflectance of `ior` above 1 count as 1.
    #[serde(skip_serializing_if = "is_white")]
    pub specular_color: Color,
    /// How much rougher the surface is in one direction, 0 to 1.
    #[serde(skip_serializing_if = "is_zero")]
    pub anisotropy: f32,
    /// Angle from the tangent to that direction, counter-clockwise, in degrees.
    #[serde(skip_serializing_if = "is_zero")]
    pub anisotropy_rotation: f32,
    /// Name of a map of that direction, by red and green as in normal maps, and of a factor of `anisotropy`, by
    /// blue: an image texture with linear encoding.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub anisotropy_map: Option<TextureRef>,
    /// Colour of a sheen of fibres on the surface, each channel in [0, 1], or a texture.
    #[serde(skip_serializing_if = "is_black")]
    pub sheen_color: Color,
    /// Roughness of the sheen, 0 to 1, or a texture.
    #[serde(skip_serializing_if = "Number::is_zero")]
    pub sheen_roughness: Number,
    /// Share of the light of the diffuse base that leaves on the other side, 0 to 1, or a texture.
    #[serde(skip_serializing_if = "Number::is_zero")]
    pub diffuse_transmission: Number,
    /// Colour of that light, each channel in [0, 1], or a texture.
    #[serde(skip_serializing_if = "is_white")]
    pub diffuse_transmission_color: Color,
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

fn is_white(color: &Color) -> bool {
    *color == [1.0; 3].into()
}

fn is_black(color: &Color) -> bool {
    *color == [0.0; 3].into()
}

fn is_zero(number: &f32) -> bool {
    *number == 0.0
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
            coat_normal: None,
            specular_color: [1.0; 3].into(),
            anisotropy: 0.0,
            anisotropy_rotation: 0.0,
            anisotropy_map: None,
            sheen_color: [0.0; 3].into(),
            sheen_roughness: 0.0.into(),
            diffuse_transmission: 0.0.into(),
            diffuse_transmission_color: [1.0; 3].into(),
            emission: [0.0; 3].into(),
            emission_sides: Sides::Both,
            normal: None,
            opacity: None,
        }
    }
}

impl Principled {
    /// Whether light enters the surface and is refracted.
    fn refracts(&self) -> bool {
        !self.thin && !self.transmission.is_zero()
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
        coat_roughness,
        specular_color,
        sheen_color,
        sheen_roughness,
        diffuse_transmission,
        diffuse_transmission_color;
        coat_normal,
        anisotropy_map
    );

    fn needs_tangents(&self) -> bool {
        self.normal.is_some() || self.coat_normal.is_some() || self.anisotropy > 0.0
    }

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
        let absorption = self.attenuation_color.map(|c| -ln(c) / self.attenuation_distance);
        self.refracts().then(|| absorption.into())
    }

    fn is_pane(&self) -> bool {
        let emits = self.emission.constant() != Some([0.0; 3]);
        let smooth = self.roughness.is_zero() && self.anisotropy == 0.0;
        self.thin && smooth && self.transmission != 0.0.into() && !emits
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
            ("sheen_roughness", &self.sheen_roughness),
            ("diffuse_transmission", &self.diffuse_transmission),
        ];
        for (name, number) in numbers {
            number.check(e, name, 0.0..=1.0)?;
        }
        e.check((1.01..=1e3).contains(&self.ior), "ior", "in [1.01, 1000]", self.ior)?;
        self.specular_color.check_within(e, "specular_color", 1e3)?;
        self.sheen_color.check(e, "sheen_color")?;
        self.diffuse_transmission_color.check(e, "diffuse_transmission_color")?;
        e.check(
            (0.0..=1.0).contains(&self.anisotropy),
            "anisotropy",
            "in [0, 1]",
            self.anisotropy,
        )?;
        let rotation = self.anisotropy_rotation;
        e.check(rotation.abs() <= 360.0, "anisotropy_rotation", "in [-360, 360]", rotation)?;
        for (name, map) in
            [("coat_normal", &self.coat_normal), ("anisotropy_map", &self.anisotropy_map)]
        {
            map.as_ref().map_or(Ok(()), |map| check_normals(map, name, e))?;
        }
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
    type Entry = Rows;
    type Bsdf<R: Real> = LayeredBsdf<R>;

    const GLOSSY: bool = true;
    const TEXTURED: bool = true;
    const LARGE: bool = true;

    fn entry(&self, textures: &mut TextureTables) -> Rows {
        Shares::<f32>::prepare();
        if !is_black(&self.sheen_color) {
            sheen::prepare();
        }
        if self.refracts() && !self.roughness.is_zero() {
            refraction::prepare();
        }
        let mut two = |first: &Number, second: &Number| {
            let ([a, b], [c, d]) = (textures.number(first), textures.number(second));
            [a, b, c, d]
        };
        let (base, specular) =
            (two(&self.metalness, &self.roughness), two(&self.specular, &self.transmission));
        let coat = two(&self.coat, &self.coat_roughness);
        let soft = two(&self.sheen_roughness, &self.diffuse_transmission);
        let coat_apart =
            !self.coat.is_zero() && (self.normal.is_some() || self.coat_normal.is_some());
        let has_extras = !is_white(&self.specular_color)
            || !is_black(&self.sheen_color)
            || !self.diffuse_transmission.is_zero()
            || self.anisotropy > 0.0;
        let (sin, cos) = sin_cos_degrees(self.anisotropy_rotation.into());
        Rows {
            base_color: textures.row(&self.base_color),
            numbers: [base, specular, coat],
            coat_color_ior: row(self.coat_color.into(), self.ior),
            flags: [
                self.thin.into(),
                self.is_pane().into(),
                u32::from(has_extras) | u32::from(coat_apart) << 1,
                textures.normal_code(self.coat_normal.as_ref()),
            ],
            extras: [
                textures.row(&self.specular_color),
                textures.row(&self.sheen_color),
                soft,
                textures.row(&self.diffuse_transmission_color),
                [
                    self.anisotropy.to_bits(),
                    (cos as f32).to_bits(),
                    (sin as f32).to_bits(),
                    textures.normal_code(self.anisotropy_map.as_ref()),
                ],
            ],
        }
    }

    fn passes(table: &[Rows], index: u32, at: &Interaction<'_, f32>) -> Vec3 {
        LayeredBsdf::new(&Parameters { pane: false, ..parameters(table, index, at) }, at).passes()
    }

    #[inline(always)]
    fn bsdf<R: Real>(table: &[Rows], index: R::Index, at: &Interaction<'_, R>) -> LayeredBsdf<R> {
        LayeredBsdf::new(&parameters(table, index, at), at)
    }
}

/// The GGX roughness α for a roughness.
#[inline(always)]
pub(super) fn alpha<R: Real>(roughness: R) -> R {
    max(roughness * roughness, R::splat(LEAST_ALPHA))
}

/// Reflectance of a dielectric at normal incidence.
#[inline(always)]
pub(super) fn reflectance_at_normal<R: Real>(ior: R) -> R {
    let slope = (ior - R::ONE) / (ior + R::ONE);
    slope * slope
}

/// Natural logarithm of `x` in (0, 1], but at least that of 2^-24.
fn ln(x: f32) -> f32 {
    crate::math::powers::ln(crate::math::max(x, 1.0 / 16_777_216.0))
}
