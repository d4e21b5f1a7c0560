//! What rays can meet in a scene.

use std::sync::Arc;

use super::light::LightFile;
use super::{Background, Material, MaterialMap, Medium};
use crate::geometry::Geometry;

/// The content of a scene: all names are resolved to indices, and every number is in its range.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct World {
    pub(crate) background: Background,
    pub(crate) geometry: Arc<Geometry>,
    pub(crate) materials: Vec<Material>,
    /// The material of each primitive.
    pub(crate) material_map: MaterialMap,
    /// The lights that are not primitives.
    pub(crate) lights: Vec<LightFile>,
    /// The media, which do not overlap.
    pub(crate) media: Vec<Medium>,
}

impl World {
    /// The material of a primitive.
    pub(crate) fn material(&self, primitive: u32) -> &Material {
        &self.materials[self.material_map.get(primitive) as usize]
    }

    /// Number of lights: primitives that emit light, other lights, and an environment map.
    pub(crate) fn light_count(&self) -> u32 {
        let emits: Vec<bool> = self.materials.iter().map(Material::emits).collect();
        let emits = |primitive: &u32| emits[self.material_map.get(*primitive) as usize];
        let map = matches!(self.background, Background::Image(_)) && !self.background.is_black();
        let lights = (0..self.geometry.len() as u32).filter(emits).count()
            + self.lights.iter().filter(|light| light.emits()).count()
            + usize::from(map);
        lights as u32
    }

    /// Number of primitives that emit light that varies.
    pub(crate) fn varied_lights(&self) -> usize {
        let varies: Vec<bool> = self
            .materials
            .iter()
            .map(|material| material.model().varied_emission().is_some())
            .collect();
        if !varies.contains(&true) {
            return 0;
        }
        let varies = |primitive: &u32| varies[self.material_map.get(*primitive) as usize];
        (0..self.geometry.len() as u32).filter(varies).count()
    }

    /// Bytes of all textures and the environment map. An image that several materials share counts once.
    pub(crate) fn texture_bytes(&self) -> u64 {
        let mut images: Vec<_> = self.materials.iter().flat_map(Material::images).collect();
        if let Background::Image(map) = &self.background {
            images.push(Arc::clone(map.texels()));
        }
        images.sort_unstable_by_key(Arc::as_ptr);
        images.dedup_by_key(|image| Arc::as_ptr(image));
        images.into_iter().map(|image| image.bytes()).sum()
    }
}
