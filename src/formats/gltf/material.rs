//! Materials and textures of glTF files.

use super::Reader;
use super::file::{Material, MaterialExtensions, Primitive, TextureInfo};
use crate::image::Encoding;
use crate::shading::material::Principled;
use crate::shading::texture::{Channel, Filter, Image, VertexColor, Wrap};
use crate::shading::{Color, Number, Opacity, TextureRef};

/// What a texture is read for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Usage {
    Colors,
    /// Colours that are multiplied by those of vertices.
    TimesVertices,
    Numbers,
    Normals,
}

/// A number of a file, limited to [0, 1].
fn share(number: f64) -> f32 {
    number.clamp(0.0, 1.0) as f32
}

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
        if coat.clearcoat_normal_texture.is_some() {
            self.import.warn("normal maps of coats are not supported, so coats follow the surface");
        }
        let (ior, reflected) = self.reflection(extensions);
        let (transmission, volume) = (&extensions.transmission, &extensions.volume);
        let strength = extensions.emissive_strength.emissive_strength.unwrap_or(1.0);
        let emitted = file.emissive_factor.map(|c| (c * strength).clamp(0.0, 1e30) as f32);
        let emission = match &file.emissive_texture {
            Some(texture) if emitted != [0.0; 3] => self.color(texture, emitted, false)?,
            _ => Color::Rgb(emitted),
        };
        let mut material = Principled {
            base_color,
            metalness: self.number(rough, Channel::B, base.metallic_factor.unwrap_or(metal))?,
            roughness: self.number(rough, Channel::G, base.roughness_factor.unwrap_or(1.0))?,
            specular: self.number(
                specular.specular_texture.as_ref(),
                Channel::A,
                specular.specular_factor.unwrap_or(1.0) * reflected,
            )?,
            ior,
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

    /// The index of refraction, and a factor of specular reflection.
    ///
    /// At normal incidence, glTF's surfaces reflect ((ior − 1)/(ior + 1))² times `specularColorFactor`.
    /// Where no light passes, only this product counts, so another index stands for it: converters
    /// write `ior` 1000 beside the colour that was meant.
    fn reflection(&mut self, extensions: &MaterialExtensions) -> (f32, f64) {
        let specular = &extensions.specular;
        // An index of 0 stands for an infinite one.
        let ior = extensions.ior.ior.map_or(1.5, |ior| if ior == 0.0 { f64::MAX } else { ior });
        let color = specular.specular_color_factor.unwrap_or([1.0; 3]);
        let is_grey = color == [color[0]; 3];
        let mean = if is_grey { color[0] } else { (color[0] + color[1] + color[2]) / 3.0 };
        let has_texture = specular.specular_color_texture.is_some();
        let limited = |ior: f64| ior.clamp(1.01, 10.0) as f32;
        if has_texture || !is_grey {
            self.import.warn("colours of specular reflection are not supported, so it is white");
        }
        if extensions.transmission.transmission_factor > 0.0 || mean == 1.0 && !has_texture {
            return (limited(ior), mean.clamp(0.0, 1.0));
        }
        let root = (ior - 1.0) / (ior + 1.0);
        let reflected = root * root * mean;
        // If only a texture tells the reflectance, it counts as 0.04, which is usual.
        let reflected = if has_texture && reflected > 0.5 { 0.04 } else { reflected };
        let root = reflected.clamp(0.0, 0.99).sqrt();
        (limited((1.0 + root) / (1.0 - root)), 1.0)
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

    /// A texture times `factor` and, where it is `colored`, times the colours of vertices.
    fn color(
        &mut self,
        info: &TextureInfo,
        factor: [f32; 3],
        colored: bool,
    ) -> Result<Color, String> {
        let usage = if colored { Usage::TimesVertices } else { Usage::Colors };
        Ok(match self.texture(info, usage)? {
            Some(texture) => Color::Texture { texture, factor },
            None => Color::Rgb(factor.map(|c| 0.5 * c)),
        })
    }

    fn number(
        &mut self,
        info: Option<&TextureInfo>,
        channel: Channel,
        factor: f64,
    ) -> Result<Number, String> {
        let factor = share(factor);
        let Some(info) = info.filter(|_| factor > 0.0) else { return Ok(Number::Value(factor)) };
        Ok(match self.texture(info, Usage::Numbers)? {
            Some(texture) => Number::Texture { texture, channel, factor },
            None => Number::Value(factor),
        })
    }

    fn normal_map(&mut self, info: Option<&TextureInfo>) -> Result<Option<TextureRef>, String> {
        let Some(info) = info else { return Ok(None) };
        if set_of(info) != 0 {
            self.import.warn("normal maps on other texture coordinates than the first are not supported, so surfaces are flat there");
            return Ok(None);
        }
        self.texture(info, Usage::Normals)
    }

    /// A texture of the scene; `None` if its image is missing and need not be there.
    fn texture(&mut self, info: &TextureInfo, usage: Usage) -> Result<Option<TextureRef>, String> {
        let gltf = self.gltf;
        let texture = gltf.document.textures.get(info.index);
        let texture = texture.ok_or_else(|| format!("unknown texture {}", info.index))?;
        let Some(source) = texture.source else {
            self.import.warn("textures in formats of extensions are grey");
            return Ok(None);
        };
        let file = gltf.image_file(source)?;
        if let Some(file) = &file
            && !self.import.is_usable(file, "so it is grey")
        {
            return Ok(None);
        }
        let mut image = Image::from_file(file.as_deref().unwrap_or(&self.file));
        image.index = file.is_none().then_some(source as u32);
        image.encoding = match usage {
            Usage::Colors | Usage::TimesVertices => Encoding::Auto,
            Usage::Numbers | Usage::Normals => Encoding::Linear,
        };
        image.vertex_colors = usage == Usage::TimesVertices;
        if usage == Usage::Normals {
            image.normal_scale = info.scale.map_or(1.0, |scale| scale.clamp(-1e3, 1e3) as f32);
        }
        if let Some(sampler) = texture.sampler {
            let sampler = gltf.document.samplers.get(sampler);
            let sampler = sampler.ok_or("a texture has an unknown sampler")?;
            let wrap = |code| match code {
                Some(33_071) => Wrap::Clamp,
                Some(33_648) => Wrap::Mirror,
                _ => Wrap::Repeat,
            };
            (image.wrap_u, image.wrap_v) = (wrap(sampler.wrap_s), wrap(sampler.wrap_t));
            if sampler.mag_filter == Some(9728) {
                image.filter = Filter::Nearest;
            }
        }
        image.uv = match set_of(info) {
            set @ (0 | 1) => set,
            _ => {
                self.import.warn(
                    "only two sets of texture coordinates are supported, so textures use the first",
                );
                0
            }
        };
        if let Some(transform) = &info.extensions.transform {
            let [x, y] = transform.scale.unwrap_or([1.0; 2]);
            let degrees = transform.rotation.to_degrees();
            let (sin, cos) = crate::math::precise::sin_cos_degrees(degrees);
            // The file's v runs down: v = 1 - v', before and after the transform.
            let offset = [transform.offset[0] + sin * y, 1.0 - transform.offset[1] - cos * y];
            image.scale = (x as f32, y as f32);
            image.rotation = degrees as f32;
            image.offset = (offset[0] as f32, offset[1] as f32);
        }
        let key = format!("{image:?}");
        if let Some(known) = self.textures.get(&key) {
            return Ok(Some(TextureRef::Named(known.clone())));
        }
        let name = format!("texture {}", self.textures.len());
        self.scene.add_texture(name.clone(), image);
        self.textures.insert(key, name.clone());
        Ok(Some(TextureRef::Named(name)))
    }
}

/// The set of texture coordinates of a texture.
fn set_of(info: &TextureInfo) -> u32 {
    let own = info.extensions.transform.as_ref().and_then(|transform| transform.tex_coord);
    own.unwrap_or(info.tex_coord)
}
