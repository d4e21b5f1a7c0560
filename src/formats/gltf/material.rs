//! Materials of glTF files.

use super::Reader;
use super::file::{Material, Primitive};
use super::texture::{Usage, share};
use crate::shading::material::Principled;
use crate::shading::texture::{Channel, VertexColor};
use crate::shading::{Color, Number, Opacity, TextureRef};

impl Reader<'_, '_, '_> {
    /// The name of the scene's material for a part of a mesh, which may have colours at its vertices.
    pub(crate) fn material_of(
        &mut self,
        primitive: &Primitive,
        colored: bool,
    ) -> Result<String, String> {
        let mappings = &primitive.extensions.variants.mappings;
        let chosen = self.variant.and_then(|variant| {
            mappings.iter().find(|mapping| mapping.variants.contains(&variant))
        });
        let index = chosen.map(|mapping| mapping.material).or(primitive.material);
        if let Some(known) = self.materials.get(&(index, colored)) {
            return Ok(known.clone());
        }
        let usual = Material::default();
        let gltf = self.gltf;
        let file = match index {
            None => &usual,
            Some(index) => {
                let material = gltf.document.materials.get(index);
                material.ok_or_else(|| format!("unknown material {index}"))?
            }
        };
        let material = self.principled(file, colored)?;
        let own = file.name.as_deref().filter(|name| !name.is_empty()).unwrap_or("material");
        let name = self.unique(own, index.unwrap_or(0));
        self.scene.add_material(name.clone(), material);
        self.materials.insert((index, colored), name.clone());
        Ok(name)
    }

    fn principled(&mut self, file: &Material, colored: bool) -> Result<Principled, String> {
        let base = &file.pbr_metallic_roughness;
        let [r, g, b, alpha] = base.base_color_factor.unwrap_or([1.0; 4]);
        let base_color = match &base.base_color_texture {
            Some(texture) => self.color(texture, [r, g, b].map(share), colored)?,
            None if colored => {
                let factor = [r, g, b].map(share);
                Color::Texture { texture: TextureRef::from(VertexColor {}), factor }
            }
            None => Color::Rgb([r, g, b].map(share)),
        };
        let rough = base.metallic_roughness_texture.as_ref();
        let metal = if file.extensions.specular_glossiness.is_some() { 0.0 } else { 1.0 };
        let extensions = &file.extensions;
        let (coat, specular) = (&extensions.clearcoat, &extensions.specular);
        let (transmission, volume) = (&extensions.transmission, &extensions.volume);
        let (sheen, anisotropy) = (&extensions.sheen, &extensions.anisotropy);
        let through = &extensions.diffuse_transmission;
        if through.diffuse_transmission_factor > 0.0 && volume.thickness_factor > 0.0 {
            self.import.warn(
                "light is not scattered inside volumes, so it leaves them where it enters them",
            );
        }
        // An index of 0 stands for an infinite one.
        let ior = extensions.ior.ior.map_or(1.5, |ior| if ior == 0.0 { f64::MAX } else { ior });
        let strength = extensions.emissive_strength.emissive_strength.unwrap_or(1.0);
        let emitted = file.emissive_factor.map(|c| (c * strength).clamp(0.0, 1e30) as f32);
        let emission = self.color_or(file.emissive_texture.as_ref(), emitted.map(f64::from))?;
        let mut material = Principled {
            base_color,
            metalness: self.number(rough, Channel::B, base.metallic_factor.unwrap_or(metal))?,
            roughness: self.number(rough, Channel::G, base.roughness_factor.unwrap_or(1.0))?,
            specular: self.number(
                specular.specular_texture.as_ref(),
                Channel::A,
                specular.specular_factor.unwrap_or(1.0),
            )?,
            specular_color: self.color_or(
                specular.specular_color_texture.as_ref(),
                specular.specular_color_factor.unwrap_or([1.0; 3]).map(|c| c.clamp(0.0, 1e3)),
            )?,
            ior: ior.clamp(1.01, 1e3) as f32,
            anisotropy: share(anisotropy.anisotropy_strength),
            anisotropy_rotation: (anisotropy.anisotropy_rotation.to_degrees() % 360.0) as f32,
            anisotropy_map: match anisotropy.anisotropy_strength > 0.0 {
                true => self.normal_map(anisotropy.anisotropy_texture.as_ref())?,
                false => None,
            },
            sheen_color: self.color_or(
                sheen.sheen_color_texture.as_ref(),
                sheen.sheen_color_factor.map(|c| c.clamp(0.0, 1.0)),
            )?,
            sheen_roughness: self.number(
                sheen.sheen_roughness_texture.as_ref(),
                Channel::A,
                sheen.sheen_roughness_factor,
            )?,
            diffuse_transmission: self.number(
                through.diffuse_transmission_texture.as_ref(),
                Channel::A,
                through.diffuse_transmission_factor,
            )?,
            diffuse_transmission_color: self.color_or(
                through.diffuse_transmission_color_texture.as_ref(),
                through
                    .diffuse_transmission_color_factor
                    .unwrap_or([1.0; 3])
                    .map(|c| c.clamp(0.0, 1.0)),
            )?,
            transmission: self.number(
                transmission.transmission_texture.as_ref(),
                Channel::R,
                transmission.transmission_factor,
            )?,
            thin: volume.thickness_factor <= 0.0,
            attenuation_color: volume
                .attenuation_color
                .unwrap_or([1.0; 3])
                .map(|c| c.clamp(1e-6, 1.0) as f32),
            attenuation_distance: volume
                .attenuation_distance
                .map_or(f32::INFINITY, |d| d.clamp(1e-9, 1e30) as f32),
            coat: self.number(
                coat.clearcoat_texture.as_ref(),
                Channel::R,
                coat.clearcoat_factor,
            )?,
            coat_roughness: self.number(
                coat.clearcoat_roughness_texture.as_ref(),
                Channel::G,
                coat.clearcoat_roughness_factor,
            )?,
            coat_normal: match coat.clearcoat_factor > 0.0 {
                true => self.normal_map(coat.clearcoat_normal_texture.as_ref())?,
                false => None,
            },
            emission,
            normal: self.normal_map(file.normal_texture.as_ref())?,
            ..Principled::default()
        };
        if extensions.unlit.is_some() {
            self.import.warn("unlit surfaces emit their colour, and so light other surfaces");
            material.emission = std::mem::replace(&mut material.base_color, Color::Rgb([0.0; 3]));
            (material.metalness, material.specular) = (0.0.into(), 0.0.into());
        }
        material.opacity = self.opacity(file, alpha)?;
        Ok(material)
    }

    /// The opacity of a material.
    fn opacity(&mut self, file: &Material, alpha: f64) -> Result<Option<Opacity>, String> {
        let texture = file.pbr_metallic_roughness.base_color_texture.as_ref();
        let mode = file.alpha_mode();
        if mode == "OPAQUE" || texture.is_none() && alpha >= 1.0 {
            return Ok(None);
        }
        let alpha = match texture {
            None => Number::Value(share(alpha)),
            // As a colour, so that the image is read once.
            Some(texture) => match self.texture(texture, Usage::Colors)? {
                None => return Ok(None),
                Some(texture) => {
                    Number::Texture { texture, channel: Channel::A, factor: share(alpha) }
                }
            },
        };
        Ok(Some(match mode {
            "MASK" => Opacity::Mask { alpha, threshold: share(file.alpha_cutoff.unwrap_or(0.5)) },
            _ => Opacity::Blend { alpha },
        }))
    }
}
