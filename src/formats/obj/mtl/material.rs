//! What the values of an MTL section mean in ptfast.

use std::path::Path;

use super::section::{Section, Wrong};
use crate::formats::import::Import;
use crate::image::Encoding;
use crate::shading::material::{Dielectric, Fresnel, Lambertian, Light, Principled};
use crate::shading::texture::Channel;
use crate::shading::{Color, Material, Number, Opacity, Sides, TextureRef};

/// The keywords that are read, and those of the light that local illumination models add everywhere.
const READ: [&str; 22] = [
    "d", "illum", "ka", "kd", "ke", "ks", "map_d", "map_ka", "map_kd", "map_ke", "map_kn",
    "map_pm", "map_pr", "ni", "norm", "ns", "pc", "pcr", "pm", "pr", "tf", "tr",
];

const BLACK: Color = Color::Rgb([0.0; 3]);

/// The maps of a section.
struct Maps {
    base_color: Option<TextureRef>,
    emission: Option<TextureRef>,
    roughness: Option<TextureRef>,
    metalness: Option<TextureRef>,
    alpha: Option<TextureRef>,
    normal: Option<TextureRef>,
}

/// Limits reflected or transmitted shares of light to [0, 1].
fn share(color: [f32; 3]) -> [f32; 3] {
    color.map(|c| c.clamp(0.0, 1.0))
}

impl Section<'_> {
    /// The material that the section describes.
    pub(crate) fn material(
        &self,
        import: &mut Import<'_>,
        folder: &Path,
    ) -> Result<Material, Wrong> {
        self.warn_of_keywords(import);
        let maps = self.maps(import, folder);
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
            Some(texture) => Some(Number::Texture { texture, channel: Channel::R, factor: opaque }),
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
                "bump" | "map_bump" => {
                    import.warn("bump maps are not supported, so surfaces stay flat");
                }
                "disp" | "map_disp" => {
                    import.warn("displacement is not supported, so surfaces stay flat");
                }
                _ if READ.contains(&keyword) => {}
                _ => import.warn(format!("`{keyword}` is not supported, so it has no effect")),
            }
        }
    }

    fn maps(&self, import: &mut Import<'_>, folder: &Path) -> Maps {
        let mut map =
            |keywords: &[&str], encoding| self.texture(keywords, encoding, import, folder);
        Maps {
            base_color: map(&["map_kd"], Encoding::Auto),
            emission: map(&["map_ke"], Encoding::Auto),
            roughness: map(&["map_pr"], Encoding::Linear),
            metalness: map(&["map_pm"], Encoding::Linear),
            alpha: map(&["map_d"], Encoding::Linear),
            normal: map(&["norm", "map_kn"], Encoding::Linear),
        }
    }

    /// The opacity, 0 to 1.
    fn opaque(&self) -> Result<f32, Wrong> {
        let opaque = match self.number("tr")? {
            Some(transparent) => 1.0 - transparent,
            None => self.number("d")?.unwrap_or(1.0),
        };
        Ok(opaque.clamp(0.0, 1.0))
    }

    fn illumination_model(&self) -> Result<f32, Wrong> {
        Ok(self.number("illum")?.unwrap_or(2.0))
    }

    fn ior(&self) -> Result<f32, Wrong> {
        Ok(self.number("ni")?.unwrap_or(1.5))
    }

    /// The glass of illumination models 4, 6, 7 and 9.
    fn glass(
        &self,
        maps: &Maps,
        base_color: &Color,
        opaque: f32,
        import: &mut Import<'_>,
    ) -> Result<Option<Material>, Wrong> {
        let tint = share(self.color("tf", import)?.unwrap_or([1.0; 3]));
        // Maya writes model 4 and `Tf 1 1 1` for opaque surfaces, too.
        let passes = opaque < 1.0 || tint != [1.0; 3] || self.has("tf") && *base_color == BLACK;
        if !passes || ![4.0, 6.0, 7.0, 9.0].contains(&self.illumination_model()?) {
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

    /// A surface without transmission: matte, or with highlights.
    fn surface(
        &self,
        maps: Maps,
        base_color: Color,
        emission: Color,
        opacity: Option<Opacity>,
        import: &mut Import<'_>,
    ) -> Result<Material, Wrong> {
        let specular = share(self.color("ks", import)?.unwrap_or([0.0; 3]));
        let shiny = specular != [0.0; 3] && self.illumination_model()? >= 2.0;
        let (rough, metal) = (self.number("pr")?, self.number("pm")?);
        let is_pbr = [&maps.roughness, &maps.metalness].into_iter().any(Option::is_some)
            || rough.is_some()
            || metal.is_some();
        let normal = maps.normal;
        if !is_pbr && !shiny && emission == BLACK {
            return Ok(Lambertian { normal, opacity, ..Lambertian::new(base_color) }.into());
        }
        // Phong's exponent as a GGX roughness (Walter et al. 2007, section 5.2).
        let exponent = self.number("ns")?.unwrap_or(0.0).clamp(0.0, 1e6);
        let alpha = (2.0 / (exponent + 2.0)).sqrt();
        // A mirror without a diffuse part is metal.
        let mirror = !is_pbr && shiny && base_color == BLACK;
        let mean = (specular[0] + specular[1] + specular[2]) / 3.0;
        let specular_share = if shiny { (mean / 0.04).clamp(0.0, 1.0) } else { 0.0 };
        let number = |texture: Option<TextureRef>, value: f32| match texture {
            Some(texture) => Number::Texture { texture, channel: Channel::R, factor: 1.0 },
            None => Number::Value(value.clamp(0.0, 1.0)),
        };
        Ok(Principled {
            base_color: if mirror { Color::Rgb(specular) } else { base_color },
            metalness: number(maps.metalness, metal.unwrap_or(if mirror { 1.0 } else { 0.0 })),
            roughness: number(maps.roughness, rough.unwrap_or_else(|| alpha.sqrt())),
            specular: Number::Value(if is_pbr { 1.0 } else { specular_share }),
            ior: self.ior()?.clamp(1.01, 10.0),
            coat: number(None, self.number("pc")?.unwrap_or(0.0)),
            coat_roughness: number(None, self.number("pcr")?.unwrap_or(0.0)),
            emission,
            normal,
            opacity,
            ..Principled::default()
        }
        .into())
    }
}

/// A texture times `factor`, or else `color`.
fn textured(texture: Option<TextureRef>, factor: [f32; 3], color: [f32; 3]) -> Color {
    match texture {
        Some(texture) => Color::Texture { texture, factor },
        None => Color::Rgb(color),
    }
}
