//! What the values of an MTL section mean in ptfast.

use std::path::Path;

use super::images::{Images, Maps};
use super::section::{Section, Wrong};
use crate::formats::import::Import;
use crate::math::max;
use crate::shading::material::{Dielectric, Fresnel, Lambertian, Light, Principled};
use crate::shading::texture::Channel;
use crate::shading::{Color, Material, Number, Opacity, Sides, TextureRef};

/// The keywords that are read, and those of the light that local illumination models add everywhere.
const READ: [&str; 25] = [
    "aniso", "anisor", "d", "illum", "ka", "kd", "ke", "ks", "map_d", "map_ka", "map_kd", "map_ke",
    "map_kn", "map_pm", "map_pr", "ni", "norm", "ns", "pc", "pcr", "pm", "pr", "ps", "tf", "tr",
];

const BLACK: Color = Color::Rgb([0.0; 3]);

/// Limits reflected or transmitted shares of light to [0, 1].
fn share(color: [f32; 3]) -> [f32; 3] {
    color.map(|c| c.clamp(0.0, 1.0))
}

impl Section<'_> {
    /// The material that the section describes.
    pub(crate) fn material(
        &self,
        import: &mut Import<'_>,
        images: &mut Images,
        folder: &Path,
    ) -> Result<Material, Wrong> {
        self.warn_of_keywords(import);
        let maps = self.maps(import, images, folder);
        let diffuse = share(self.color("kd", import)?.unwrap_or([0.8; 3]));
        // Maya and others write `Kd 0 0 0` beside maps, so maps replace the colour.
        let base_color = textured(maps.base_color.clone(), [1.0; 3], diffuse);
        let emitted = self.color("ke", import)?.unwrap_or([0.0; 3]).map(|c| c.clamp(0.0, 1e30));
        let factor = if emitted == [0.0; 3] { [1.0; 3] } else { emitted };
        let emission = textured(maps.emission.clone(), factor, emitted);
        let opaque = self.opaque()?;
        if let Some(glass) = self.glass(&maps, &base_color, opaque, import)? {
            return Ok(glass);
        }
        let mut opacity = match maps.alpha.clone() {
            Some((texture, channel)) => Some(Number::Texture { texture, channel, factor: opaque }),
            None => (opaque < 1.0).then_some(Number::Value(opaque)),
        };
        let is_lamp = matches!(&emission, Color::Rgb(_)) && emission != BLACK;
        if is_lamp && opacity.take().is_some() {
            import.warn("lamps are opaque here, so their `d`, `Tr` and `map_d` have no effect");
        }
        let opacity = opacity.map(|alpha| Opacity::Blend { alpha });
        match &emission {
            Color::Rgb(radiance) if is_lamp && base_color == BLACK => {
                Ok(Light { radiance: *radiance, sides: Sides::Both }.into())
            }
            _ => self.surface(maps, base_color, emission, opacity, import),
        }
    }

    /// Warns of what is not supported.
    fn warn_of_keywords(&self, import: &mut Import<'_>) {
        for keyword in self.keywords() {
            match keyword {
                // `normal` warns of those.
                "bump" | "map_bump" => {}
                "disp" | "map_disp" => {
                    import.warn("displacement is not supported, so surfaces stay flat");
                }
                _ if READ.contains(&keyword) || self.is_zero(keyword) => {}
                _ => import.warn(format!("`{keyword}` is not supported, so it has no effect")),
            }
        }
    }

    /// The opacity, 0 to 1. If both are written, `Tr` may mean the opposite: exporters disagree.
    fn opaque(&self) -> Result<f32, Wrong> {
        let opaque = match (self.number("d")?, self.number("tr")?) {
            (Some(opaque), _) => opaque,
            (None, Some(transparent)) => 1.0 - transparent,
            (None, None) => 1.0,
        };
        Ok(opaque.clamp(0.0, 1.0))
    }

    /// Whether the section has keywords of physically based materials.
    fn is_pbr(&self) -> bool {
        ["pr", "pm", "map_pr", "map_pm"].iter().any(|keyword| self.has(keyword))
    }

    fn illumination_model(&self) -> Result<f32, Wrong> {
        Ok(self.number("illum")?.unwrap_or(2.0))
    }

    fn ior(&self) -> Result<f32, Wrong> {
        Ok(self.number("ni")?.unwrap_or(1.5))
    }

    /// The glass of illumination models 4, 6, 7 and 9. Blender writes those for opacity; its glass is that
    /// of [`surface`](Self::surface).
    fn glass(
        &self,
        maps: &Maps,
        base_color: &Color,
        opaque: f32,
        import: &mut Import<'_>,
    ) -> Result<Option<Material>, Wrong> {
        let (tint, model) = (self.color("tf", import)?, self.illumination_model()?);
        let tinted = share(tint.unwrap_or([1.0; 3]));
        if self.by_blender || self.is_pbr() || ![4.0, 6.0, 7.0, 9.0].contains(&model) {
            return Ok(None);
        }
        // Model 9 without `Tf` is Blender's opacity in a file that another program wrote anew. Maya writes
        // model 4 and `Tf 1 1 1` for opaque surfaces, too.
        let passes = opaque < 1.0 && (model != 9.0 || tint.is_some())
            || tinted != [1.0; 3]
            || tint.is_some() && *base_color == BLACK;
        let tint = tinted;
        if !passes {
            return Ok(None);
        }
        if matches!(base_color, Color::Texture { .. }) || maps.alpha.is_some() {
            import.warn("maps on glass, except of normals, are not supported, so it is clear");
        }
        let normal = maps.normal.clone();
        let ior = self.ior()?;
        if tint == [1.0; 3] {
            let clear = Dielectric::new(ior.clamp(0.01, 100.0), Fresnel::Exact);
            return Ok(Some(Dielectric { normal, ..clear }.into()));
        }
        let glass = Principled {
            base_color: Color::Rgb(tint),
            roughness: 0.0.into(),
            ior: ior.clamp(1.01, 10.0),
            transmission: 1.0.into(),
            normal,
            ..Principled::default()
        };
        Ok(Some(glass.into()))
    }

    /// All other surfaces: matte, with highlights, metal, or with the keywords of physically based
    /// materials, which may let light through.
    fn surface(
        &self,
        maps: Maps,
        base_color: Color,
        emission: Color,
        opacity: Option<Opacity>,
        import: &mut Import<'_>,
    ) -> Result<Material, Wrong> {
        let (blender, is_pbr, model) = (self.by_blender, self.is_pbr(), self.illumination_model()?);
        let reflected = self.color("ks", import)?.map(share);
        let specular = reflected.unwrap_or([0.0; 3]);
        let shiny = specular != [0.0; 3] && model >= 2.0;
        let normal = maps.normal;
        if !is_pbr && !shiny && emission == BLACK {
            return Ok(Lambertian { normal, opacity, ..Lambertian::new(base_color) }.into());
        }
        let mean = |color: [f32; 3]| (color[0] + color[1] + color[2]) / 3.0;
        // Elsewhere, a mirror without a diffuse part is metal.
        let mirror = !is_pbr && !blender && shiny && base_color == BLACK;
        // Blender writes models 3 and 6 for metal, and its metalness as `Ka`.
        let is_metal = !is_pbr && shiny && (model == 3.0 || model == 6.0 && blender);
        let metal = match self.number("pm")? {
            Some(metal) => metal,
            None if mirror => 1.0,
            None if is_metal => self.color("ka", import)?.map_or(1.0, mean),
            None => 0.0,
        };
        let factor = match reflected {
            Some([0.0, 0.0, 0.0]) if blender || model < 2.0 => 0.0,
            _ if blender => 1.0,
            _ if is_pbr => 1.0,
            _ if shiny => mean(specular) / 0.04,
            _ => 0.0,
        };
        let passing = self.color("tf", import)?.filter(|_| is_pbr).map_or(0.0, mean);
        let base_color = match base_color {
            _ if mirror => Color::Rgb(specular),
            Color::Rgb(color) if passing >= 1.0 => Color::Rgb(glass_color(color)),
            other => other,
        };
        // Half of Blender's specular level is the reflectance of the index of refraction.
        let specular_color = match reflected {
            Some(level) if blender => level.map(|c| 2.0 * c),
            _ => [1.0; 3],
        };
        let coat = self.number("pc")?.unwrap_or(0.0);
        let turn = self.number("anisor")?.unwrap_or(0.0);
        let sheen = self.number("ps")?.unwrap_or(0.0);
        let number = |texture: Option<TextureRef>, value: f32| match texture {
            Some(texture) => Number::Texture { texture, channel: Channel::R, factor: 1.0 },
            None => Number::Value(value.clamp(0.0, 1.0)),
        };
        Ok(Principled {
            base_color,
            metalness: number(maps.metalness, metal),
            roughness: number(maps.roughness, self.roughness()?),
            specular: number(None, factor),
            specular_color: specular_color.into(),
            anisotropy: self.number("aniso")?.unwrap_or(0.0).clamp(0.0, 1.0),
            // In turns.
            anisotropy_rotation: 360.0 * (turn % 1.0),
            sheen_color: share([sheen; 3]).into(),
            // There is no keyword for it, so it is Blender's usual value.
            sheen_roughness: number(None, if sheen > 0.0 { 0.5 } else { 0.0 }),
            ior: self.ior()?.clamp(1.01, 10.0),
            transmission: number(None, passing),
            // Blender's coat once had a factor of 1/4, which its files keep.
            coat: number(None, if blender { 0.25 * coat } else { coat }),
            coat_roughness: number(None, self.number("pcr")?.unwrap_or(0.0)),
            emission,
            normal,
            opacity,
            ..Principled::default()
        }
        .into())
    }

    /// `Pr`, or else the roughness of an exponent `Ns`.
    fn roughness(&self) -> Result<f32, Wrong> {
        let exponent = self.number("ns")?.unwrap_or(0.0);
        Ok(match self.number("pr")? {
            Some(rough) => rough,
            None if self.by_blender => 1.0 - (exponent.clamp(0.0, 1000.0) / 1000.0).sqrt(),
            // Phong's exponent as a GGX α (Walter et al. 2007, section 5.2), whose root is the roughness.
            None => (2.0 / (exponent.clamp(0.0, 1e6) + 2.0)).sqrt().sqrt(),
        })
    }
}

/// The colour of clear glass at each of the two surfaces that light passes: the hue of `Kd`. Its brightness
/// does not count, since exporters write their usual grey for clear glass.
fn glass_color(color: [f32; 3]) -> [f32; 3] {
    match max(max(color[0], color[1]), color[2]) {
        most if most > 0.0 => color.map(|c| (c / most).sqrt()),
        _ => [1.0; 3],
    }
}

/// A texture times `factor`, or else `color`.
fn textured(texture: Option<TextureRef>, factor: [f32; 3], color: [f32; 3]) -> Color {
    match texture {
        Some(texture) => Color::Texture { texture, factor },
        None => Color::Rgb(color),
    }
}
