//! Textures of glTF files.

use super::Reader;
use super::file::TextureInfo;
use crate::image::Encoding;
use crate::shading::texture::{Channel, Filter, Image, Wrap};
use crate::shading::{Color, Number, TextureRef};

/// What a texture is read for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Usage {
    Colors,
    /// Colours that are multiplied by those of vertices.
    TimesVertices,
    Numbers,
    Normals,
}

/// A number of a file, limited to [0, 1].
pub(super) fn share(number: f64) -> f32 {
    number.clamp(0.0, 1.0) as f32
}

impl Reader<'_, '_, '_> {
    /// A texture times `factor` and, where it is `colored`, times the colours of vertices.
    pub(super) fn color(
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

    /// A texture times `factor`, or the factor alone without a texture.
    pub(super) fn color_or(
        &mut self,
        info: Option<&TextureInfo>,
        factor: [f64; 3],
    ) -> Result<Color, String> {
        let factor = factor.map(|c| c as f32);
        match info {
            Some(info) if factor != [0.0; 3] => self.color(info, factor, false),
            _ => Ok(Color::Rgb(factor)),
        }
    }

    pub(super) fn number(
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

    pub(super) fn normal_map(
        &mut self,
        info: Option<&TextureInfo>,
    ) -> Result<Option<TextureRef>, String> {
        let Some(info) = info else { return Ok(None) };
        if set_of(info) != 0 {
            self.import.warn("maps of normals and directions on other texture coordinates than the first are not supported, so they have no effect");
            return Ok(None);
        }
        self.texture(info, Usage::Normals)
    }

    /// A texture of the scene; `None` if its image is missing and need not be there.
    pub(super) fn texture(
        &mut self,
        info: &TextureInfo,
        usage: Usage,
    ) -> Result<Option<TextureRef>, String> {
        let gltf = self.gltf;
        let texture = gltf.document.textures.get(info.index);
        let texture = texture.ok_or_else(|| format!("unknown texture {}", info.index))?;
        let Some(source) = texture.image() else {
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
