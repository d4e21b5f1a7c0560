//! Resolution of materials and the textures that they name.

use std::collections::HashMap;
use std::sync::Arc;

use super::Resolver;
use crate::error::{Result, suggestion};
use crate::image::split_layer;
use crate::shading::texture::Channel;
use crate::shading::{Images, Material, Number, Texture, TextureRef};

impl Resolver<'_> {
    /// Checks the materials and returns them with their texture names replaced by the textures.
    pub(super) fn materials(&self, images: &mut Images<'_>) -> Result<Vec<Material>> {
        let textures = self.textures(images)?;
        let mut materials = Vec::new();
        for (name, material) in &self.file.materials.0 {
            let e = self.element(format!("materials.{name}"), "material");
            let mut material = material.clone();
            for reference in material.textures() {
                let texture = match reference {
                    TextureRef::Named(name) => match textures.get(name.as_str()) {
                        Some(texture) => Arc::clone(texture),
                        None => {
                            let known = suggestion(name, self.file.textures.names());
                            return Err(e.error(format!("unknown texture `{name}`{known}")));
                        }
                    },
                    TextureRef::Texture(texture) => {
                        let mut texture = Texture::clone(texture);
                        texture.model_mut().load(&e, images)?;
                        Arc::new(texture)
                    }
                };
                *reference = TextureRef::Texture(texture);
            }
            divide_by_alpha(&mut material);
            material.check(&e)?;
            materials.push(material);
        }
        Ok(materials)
    }

    fn textures(&self, images: &mut Images<'_>) -> Result<HashMap<&str, Arc<Texture>>> {
        let mut materials: Vec<Material> =
            self.file.materials.0.iter().map(|(_, material)| material.clone()).collect();
        let references = materials.iter_mut().flat_map(Material::textures);
        let unnamed: Vec<_> = references.filter_map(|reference| reference.unnamed()).collect();
        let named = self.file.textures.0.iter().map(|(_, texture)| texture);
        images.preload(named.chain(unnamed).filter_map(|texture| texture.model().file()));
        let mut textures = HashMap::new();
        for (name, texture) in &self.file.textures.0 {
            let e = self.element(format!("textures.{name}"), "texture");
            let mut texture = texture.clone();
            texture.model_mut().load(&e, images)?;
            textures.insert(name.as_str(), Arc::new(texture));
        }
        Ok(textures)
    }
}

/// Divides the colours of an EXR file by its alpha in a material whose opacity that alpha is: there, the light of holes
/// would be missing twice.
fn divide_by_alpha(material: &mut Material) {
    let opacity = material.model().opacity().map(|opacity| opacity.alpha());
    let Some(Number::Texture { texture, channel: Channel::A, .. }) = opacity else { return };
    let alpha = Arc::clone(texture.get());
    let Some(file) = alpha.model().file() else { return };
    if !alpha.model().texels().is_some_and(|texels| texels.associated()) {
        return;
    }
    // The same file may be named in several ways, and by its layers.
    let path = |file: &str| split_layer(file.trim_start_matches("./")).0.to_owned();
    for reference in material.textures() {
        let mut texture = Texture::clone(reference.get());
        let own = texture.model().file().map(|own| (path(own.file), own.index));
        if own == Some((path(file.file), file.index)) {
            texture.model_mut().divide_by_alpha();
            *reference = TextureRef::Texture(Arc::new(texture));
        }
    }
}
